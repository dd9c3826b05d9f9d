// Finds where methods fail: runs every method on a scene, over steps (tolerances) and over a number of the
// scene or over several scenes, and finds each method's limit of stability.
//
// Outcomes, evaluations and limits are the same, bit for bit, from one call to the next on one machine.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/charts/ladder.hpp"
#include "pipeline/charts/outcome.hpp"

namespace borelli {

/// The scenes of a map, one per column. If several scenes are swept instead of a number, `values` are 1, 2, 3
/// ...
struct Sweep {
  std::string scene;           ///< name of the swept scene, for titles
  std::string parameter = {};  ///< path of the swept number; empty: several scenes
  Ladder values = {};
  std::vector<std::string> names = {};     ///< of the scenes
  std::vector<Result<Scene>> scenes = {};  ///< a scene that cannot be read is refused at every step
};

struct StabilitySettings {
  std::vector<std::string> methods = {};  ///< of integrator_names(); empty: all
  Equations equations = Equations::recursive;
  std::optional<ConstraintTreatment> constraints = {};  ///< empty: the scenes' own
  Ladder steps = {};       ///< s; empty: from 1e-4 to 1e-1 of the first scene's run
  Ladder tolerances = {};  ///< empty: 1e-10 to 1e-2
  RunLengths lengths = {};
  double refinement = 1.005;  ///< limits are bisected until their two enclosing runs are within this ratio
};

struct StabilityCell {
  std::size_t method, column;
  double setting;  ///< step (s) or tolerance
  Tried tried;
};

/// The limit of one method in one column: the largest setting at which it and all smaller settings are stable
/// (see is_unstable). Infinite: all tried settings are stable; NaN: none is, or the method refuses the scene.
///
/// Unfinished runs (ended by the step limit) count for `stable` only when compared over equal times. If no
/// run below the first unstable one finished, the steps are bisected by runs as long as the longest of those,
/// provided that the unstable run fails within that time too.
struct StabilityLimit {
  std::size_t method, column;
  double stable, trusted;             ///< `trusted`: by certificate, among the ladder's own settings
  std::optional<double> linear = {};  ///< linear_limit, to compare with `stable`
  double over = 0;  ///< s: length of the runs that determine `stable`; 0: the scene's whole time
  /// The largest setting at or below `stable` whose run is unfinished, so that its later outcome is unknown;
  /// 0: none.
  double unseen = 0;
  bool known = true;  ///< false: no run was long enough to determine `stable`, which is NaN
};

struct StabilityMap {
  Sweep sweep;
  std::vector<std::string> methods;
  Ladder steps, tolerances;
  RunLengths lengths;
  std::vector<StabilityCell> cells;    ///< by method, column, rising setting: only the ladders' settings
  std::vector<StabilityLimit> limits;  ///< by method, column
  /// By column: growth exponent of small deviations from the start over the scene's time (the largest real
  /// part of an eigenvalue times that time). 0: no growth, or not known.
  std::vector<double> own_growth = {};
  const Ladder& ladder_of(std::size_t method) const;
};

/// Earlier results of an interrupted map, and the callback for each finished column of a method.
struct StabilityObserver {
  std::function<void(double)> progress = [](double) {};  ///< share done, 0 to 1
  std::vector<StabilityCell> known_cells = {};
  std::vector<StabilityLimit> known_limits = {};  ///< of whole columns
  /// An error that it returns ends the map.
  std::function<Result<void>(const StabilityMap&)> column_ends = [](const StabilityMap&) {
    return Result<void>();
  };
};

/// Runs everything that is not known yet. Errors: a setting makes no sense, or no scene of the sweep can be
/// read.
Result<StabilityMap> stability_map(Sweep sweep, const StabilitySettings& settings,
                                   const StabilityObserver& observer = {});

/// From a scene's text (`file` names it): one column per value; all numbers at `paths` get the same value.
Result<Sweep> sweep_of_number(const std::string& text, const std::string& file,
                              const std::vector<std::string>& paths, const Ladder& values);

/// One column per scene. Scenes of the same name are distinguished by their files' names (`files`: of all
/// scenes; empty: not known).
Sweep sweep_of_scenes(std::vector<Scene> scenes, const std::vector<std::string>& files = {});

}  // namespace borelli
