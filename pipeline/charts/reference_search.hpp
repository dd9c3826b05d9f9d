// Finds the reference of a work-precision diagram: two unlike methods of high order that agree at extreme
// tolerances, at the output times of the comparison.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "dynamics/scene/settings.hpp"
#include "dynamics/system/system.hpp"
#include "pipeline/charts/motion_difference.hpp"

namespace borelli {

struct Reference {
  bool found = false;
  std::vector<std::string> runs;         ///< method and tolerance of both
  double position = 0, orientation = 0;  ///< their difference up to the horizon: the reference's own error
  double horizon = 0;                    ///< s, end of the comparison
  std::string words;                     ///< the above as a sentence
};

/// Difference of two motions at each row, as a running maximum; position over `length`.
std::vector<MotionDifference> motion_differences(const Trajectory& a, const Trajectory& b,
                                                 const std::vector<Eigen::Vector3d>& centres, double length);

/// The larger of both numbers.
double size_of(const MotionDifference& difference);

struct ReferenceRequest {
  int outputs;    ///< times of output, evenly spread over the motion
  double budget;  ///< processor time of a run to be judged, s; the reference may take a hundred times that
  bool anew;  ///< if fewer than a quarter of the outputs are usable, distribute as many over the usable time
  std::function<void(const std::string& what)> progress;  ///< receives the name of each run
};

struct FoundReference {
  Reference reference;
  std::optional<Trajectory> motion;          ///< at the output times; empty: no reference
  std::size_t last_row = 0;                  ///< last usable row
  double end_time = 0, output_interval = 0;  ///< s, final end time and spacing of the outputs
};

/// Looks for the reference of the motion from the system's start. `how`: end time and all settings that do
/// not depend on the method. `centres`: gravity centres of the solids, each in its own frame.
FoundReference find_reference(const System& system, const std::vector<Eigen::Vector3d>& centres,
                              const SimulationSettings& how, const ReferenceRequest& request);

}  // namespace borelli
