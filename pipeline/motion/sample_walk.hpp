// A made-up motion capture of a walking body, whose joint angles, ground forces and joint moments are known.
//
// Inverse kinematics brings the feet to their planned places (walk_plan.hpp), where they neither slide nor
// sink, and keeps the legs near sketched joint angles (gait_angles.hpp). The body's centre moves so that the
// ground reaction acts under the feet: first like a linear inverted pendulum over the planned centre of
// pressure, then corrected by inverse dynamics (Kajita and others, Biped walking pattern generation by using
// preview control of zero-moment point, ICRA 2003). Truncated Fourier series make the motion smooth and
// periodic.
//
// The ground forces balance the root exactly. A wrench has six components; a foot on the floor can give all
// of them: three forces, the centre of pressure for the two horizontal moments, and the vertical free moment.
// Each force points at the body's gravity centre as nearly as the sum of both allows. Forces and motion agree
// exactly, but the walk is not a model of normal gait.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "dynamics/scene/scene.hpp"
#include "dynamics/scene/site.hpp"
#include "pipeline/body/foot_soles.hpp"
#include "pipeline/motion/motion_efforts_table.hpp"
#include "pipeline/motion/walk_plan.hpp"
#include "pipeline/recordings/external_loads.hpp"
#include "pipeline/recordings/marker_motion.hpp"

namespace borelli {

struct SampleWalkOptions {
  double duration = 2.4;    ///< s
  double rate = 100;        ///< Hz
  double speed = 1.2;       ///< m/s
  double cadence = 110;     ///< steps a minute
  double step_width = 0.1;  ///< m, between the heels
  double marker_noise = 0;  ///< m, standard deviation per coordinate
  std::uint64_t seed = 1;   ///< of the noise
};

/// World: z up, the floor z = 0, walking along -y.
struct SampleWalk {
  WalkTiming timing;
  MarkerMotion markers;
  std::vector<ExternalLoad> loads;  ///< right foot, left foot; NaN points where a foot is in the air
  RecordedPositions positions;
  RecordedEfforts efforts;            ///< exact, under the loads
  std::vector<std::string> warnings;  ///< a centre of pressure outside of the sole
};

/// `body`: as build_skeleton makes it without a leap, standing on the floor z = 0, with both legs. `markers`:
/// places on its solids by name. `soles`: m, the world of the body's start. Errors: a body without legs;
/// options out of range; as MarkerFit.
Result<SampleWalk> sample_walk(const Scene& body, const std::map<std::string, SolidPoint>& markers,
                               const FootSoles& soles, const SampleWalkOptions& options = {});

/// The markers in OpenSim's axes (x forwards, y up, z to the right).
MarkerMotion in_opensim_axes(MarkerMotion markers);
/// The ground forces with OpenSim's names (ground_force_vx ..., 1_ground_force_vx ...) in its axes; zeros
/// where a foot is in the air.
MotionTable force_table_of(const std::vector<ExternalLoad>& loads);

}  // namespace borelli
