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
#include "pipeline/motion/motion_efforts_table.hpp"
#include "pipeline/motion/motion_fit.hpp"
#include "pipeline/recordings/external_loads.hpp"
#include "pipeline/recordings/marker_motion.hpp"
#include "pipeline/recordings/measured_force.hpp"
#include "pipeline/recordings/motion_table.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

/// A scanned body. `scene` is that of build_skeleton without a leap: it starts in the scan's pose, and its
/// world has the patient's axes, in metres.
struct BodyModel {
  Scene scene;
  FootSoles soles;  ///< only needed for another person's motion
};

struct CapturedRecording {
  MarkerMotion motion;
  std::optional<MarkerMotion> trial;  ///< the person standing still
  std::vector<MeasuredForce> forces;  ///< in the axes of the markers
};

/// Joint angles instead of markers.
struct CapturedAngles {
  MotionTable angles;
  std::vector<MeasuredForce> forces;  ///< in axes of their own: z up, or their mean force points up
  std::optional<Eigen::Vector3d> up;  ///< up in the forces' axes, if their file gives it
};

struct CapturedMotionRequest {
  /// Whether the recorded person is another than the scanned one. Then the motion is fitted to the body's
  /// size, its feet are set on the ground, and forces scale with its mass (motion_transfer.hpp).
  bool other_person = false;
  /// Whether the motion also determines the markers' places on the body (marker_calibration.hpp), not the
  /// trial alone.
  bool calibrate = false;
  std::optional<double> recorded_mass;  ///< kg, of the other person; empty: from the forces
  double cutoff = 6;                    ///< Hz, of the low-pass filter over the positions; 0: none
  std::function<void(double)> progress;
};

/// A body's motion, with all that it was computed from. World axes, z up.
struct CapturedMotion {
  Scene scene;              ///< the body with its markers; starts in the first recorded pose
  MarkerMotion markers;     ///< as recorded; if another person was recorded, as this body would show them
  MarkerMotion trial;       ///< one frame in which the markers were placed
  bool standing = false;    ///< whether it shows the person standing
  bool calibrated = false;  ///< whether the markers were then moved to where the motion shows them
  MotionFit fit;
  RecordedPositions positions;
  std::vector<ExternalLoad> loads;  ///< on the feet
  RecordedEfforts efforts;
  double landmark_distance = 0;             ///< m, rms distance of the trial's markers from their landmarks
  double length_ratio = 1, mass_ratio = 1;  ///< body over recorded person
  std::vector<std::string> warnings;
};

/// Fits the recording to the body and computes the joint moments:
///   1. Up is the recording's own, or the axis along which trunk and head lie above the feet.
///   2. The standing trial places the markers on the body (marker_placement.hpp). Without a trial, the first
///      frame that shows the most markers does.
///      The motion then calibrates their places, if asked for.
///   3. Each frame is fitted to its markers (motion_fit.hpp).
///   4. Another person's motion is transferred to the body (motion_transfer.hpp).
///   5. Inverse dynamics gives the joint moments (motion_efforts_table.hpp).
/// Errors: fewer than three markers over landmarks; those of the steps.
Result<CapturedMotion> captured_motion(const BodyModel& body, const BodyMarkers& markers,
                                       const CapturedRecording& recording,
                                       const CapturedMotionRequest& request);

/// The same from joint angles (angle_motion.hpp), without markers and their fit. Another person's size is not
/// recorded: it is the one at which the body's feet reach the floor (size_by_height). Errors: angle_motion's;
/// a size that is not between 0.4 and 2.5; those of steps 4 and 5.
Result<CapturedMotion> captured_angles(const BodyModel& body, const Landmarks& landmarks,
                                       const CapturedAngles& recording, const CapturedMotionRequest& request);

}  // namespace borelli
