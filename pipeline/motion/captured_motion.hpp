// A captured motion on a scanned body: markers placed by its landmarks, joint angles, ground forces, joint
// moments.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "dynamics/inverse/recorded_motion.hpp"
#include "dynamics/scene/scene.hpp"
#include "pipeline/body/foot_soles.hpp"
#include "pipeline/motion/body_markers.hpp"
#include "pipeline/motion/external_loads.hpp"
#include "pipeline/motion/marker_motion.hpp"
#include "pipeline/motion/measured_force.hpp"
#include "pipeline/motion/motion_efforts_table.hpp"
#include "pipeline/motion/motion_fit.hpp"

namespace borelli {

/// A body as build_skeleton makes it of a scan, without a leap. Its scene starts in the scan's pose, whose world
/// are the patient's axes in metres.
struct BodyModel {
  Scene scene;
  FootSoles soles;
};

struct CapturedRecording {
  MarkerMotion motion;
  std::optional<MarkerMotion> trial;  ///< the person standing still
  std::vector<MeasuredForce> forces;  ///< in the axes of the markers
};

struct CapturedMotionRequest {
  /// The recorded person is not the scanned one: the motion is made to fit the body's size, its feet are set down
  /// on the ground, and forces scale with the mass.
  bool other_person = false;
  std::optional<double> recorded_mass;  ///< kg, of the other person; empty: as the forces tell
  double cutoff = 6;                    ///< Hz, of the low-pass filter over the positions; 0: none
  std::function<void(double)> progress;
};

/// What the motion of a body is made of. World axes, z up.
struct CapturedMotion {
  Scene scene;            ///< the body with the markers at their places; starts in the first pose
  MarkerMotion markers;   ///< of this body: measured, or made for its size
  MarkerMotion trial;     ///< one frame in which the markers were placed
  bool standing = false;  ///< whether it shows the person standing
  std::vector<std::string> followers;  ///< markers whose places on their segments only the trial gives
  MotionFit fit;
  RecordedPositions positions;
  std::vector<ExternalLoad> loads;  ///< on the feet
  RecordedEfforts efforts;
  double landmark_distance =
      0;  ///< m, rms of the markers in the trial from the landmarks that they stand over
  double length_ratio = 1, mass_ratio = 1;  ///< of the body to the recorded person
  std::vector<std::string> warnings;
};

/// Fits the recording to the body and finds its joint moments.
///
/// The recording's up is its own, or the axis along which markers of trunk and head lie above those of the feet.
/// The trial (without one: the first frame that shows most markers) places all markers on their segments in
/// the pose that brings those over landmarks nearest; another person's model is first sized to it
/// (static_fit.hpp). Then every frame is fitted (motion_fit.hpp), and inverse dynamics follow. Errors: fewer
/// than three markers over landmarks; those of the steps.
Result<CapturedMotion> captured_motion(const BodyModel& body, const BodyMarkers& markers,
                                       const CapturedRecording& recording,
                                       const CapturedMotionRequest& request);

}  // namespace borelli
