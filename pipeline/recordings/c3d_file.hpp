// C3D: markers, model outputs, analog channels, events and force plates of one recording.
// Source: C3D user guide, www.c3d.org.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "error/error.hpp"
#include "pipeline/recordings/marker_motion.hpp"
#include "pipeline/recordings/measured_force.hpp"

namespace borelli {

/// What a model computed and a program stored beside the markers: joint angles, moments, powers.
struct ModelOutput {
  std::string name;
  std::string kind;  ///< the file's group without its plural, in capitals: ANGLE, FORCE, MOMENT, POWER ...
  std::string unit;  ///< as the file has it: deg, N, Nmm, W ...; empty if it does not tell
  Eigen::Matrix3Xd values;  ///< in `unit`, one column per frame; NaN where there is none
};

struct AnalogChannel {
  std::string name, description;
  std::string unit;        ///< as the file has it
  Eigen::VectorXd values;  ///< in `unit`, one per analog sample
};

struct MotionEvent {
  double time;  ///< s, on the clock of the markers
  std::string label;
  std::string context;  ///< Left, Right, General ...; empty for events of the header
  std::string subject, description;
};

struct C3dFile {
  MarkerMotion markers;  ///< time 0 is that of frame number 1, as the events count
  /// m, one row per marker and one column per frame: mean distance of the cameras' rays. 0 where a program
  /// filled or filtered the point; NaN in a gap.
  Eigen::MatrixXd residuals;
  std::vector<ModelOutput> outputs;
  std::vector<double> analog_times;  ///< s; the first sample of a frame is taken at the frame's time
  std::vector<AnalogChannel> analog;
  std::vector<MotionEvent> events;    ///< in the order of their times
  std::vector<MeasuredForce> forces;  ///< one per force plate of type 1 to 4, at the analog rate
  std::vector<std::string> subjects;
  std::vector<std::string> warnings;  ///< what was repaired or left out, and why
};

/// Reads a file of Intel, DEC or MIPS processors, of integers or floating-point numbers.
///
/// - A point is a gap (NaN) if its residual is negative, if a coordinate is not finite, or if a marker is at
///   exactly (0, 0, 0) with residual 0, as some programs write gaps.
/// - Points named in a group of POINT:TYPE_GROUPS, or in POINT:ANGLES, FORCES, MOMENTS, POWERS, SCALARS or
///   REACTIONS, are model outputs. MODELED_MARKERS stay markers.
/// - Names come from POINT:LABELS, LABELS2 and so on. The subject's prefix is dropped if the file has one subject.
///   A point without a label is `point_7`; a second `A` is `A_2`.
/// - `up` comes from POINT:Y_SCREEN; its sign is changed if the markers are then below the force plates. Without
///   Y_SCREEN it is the plates' normal, if that is along an axis.
/// - Analog: (number - OFFSET) * SCALE * GEN_SCALE; unsigned where ANALOG:FORMAT says so.
/// - Counts, frames, scale: as c3d_layout. Forces: as measured_force.
/// Errors: the file is no C3D (wrong key byte or processor), is cut short, has an unknown unit of length, or
/// has counts that exceed its size. Counts are compared with the file's size before memory is allocated for
/// them.
Result<C3dFile> read_c3d(const std::filesystem::path& path);

}  // namespace borelli
