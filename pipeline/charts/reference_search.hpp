// The reference of a work-precision diagram: what two unlike methods of high order agree on at extreme
// tolerances, over the output times that runs are compared at.
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
  double position = 0, orientation = 0;  ///< what they differ by up to the horizon: the reference's own error
  double horizon = 0;                    ///< s, where runs end
  std::string words;                     ///< all this in a sentence
};

/// By how much two motions differ at each row, up to there; position over `length`.
std::vector<MotionDifference> motion_differences(const Trajectory& a, const Trajectory& b,
                                                 const std::vector<Eigen::Vector3d>& centres, double length);

/// The larger of both numbers.
double size_of(const MotionDifference& difference);

struct ReferenceRequest {
  int outputs;    ///< times of output, evenly spread over the motion
  double budget;  ///< s, of a run that it is to judge; making it may take a hundred times that
  bool anew;      ///< where fewer than a quarter of the outputs are left, as many are laid over what is left
  std::function<void(const std::string& what)> progress;  ///< told what is run
};

struct FoundReference {
  Reference reference;
  std::optional<Trajectory> motion;          ///< at the times of output; none: there is no reference
  std::size_t last_row = 0;                  ///< up to which it counts
  double end_time = 0, output_interval = 0;  ///< s, where outputs were laid in the end
};

/// Looks for the reference of a motion from the system's start; `how` says when it ends and all that does not
/// depend on the method, `centres` are the solids' of gravity, each in its own frame.
FoundReference find_reference(const System& system, const std::vector<Eigen::Vector3d>& centres,
                              const SimulationSettings& how, const ReferenceRequest& request);

}  // namespace borelli
