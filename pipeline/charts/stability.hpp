// Where methods fail: every method on a scene, over steps (tolerances) and over a number of the scene, or
// over several scenes, and the limit up to which each is stable.
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

/// The scenes of a map, one a column. Where several scenes are swept rather than a number of one, `values`
/// count them from 1.
struct Sweep {
  std::string scene;           ///< what is swept, for a title
  std::string parameter = {};  ///< path of the number; empty: scenes
  Ladder values = {};
  std::vector<std::string> names = {};     ///< of the scenes
  std::vector<Result<Scene>> scenes = {};  ///< one that cannot be read is refused at every step
};

struct StabilitySettings {
  std::vector<std::string> methods = {};  ///< of integrator_names(); empty: all
  Equations equations = Equations::recursive;
  std::optional<ConstraintTreatment> constraints = {};  ///< the scenes' own where it is absent
  Ladder steps = {};       ///< s; empty: from a ten thousandth of the first scene's run to a tenth
  Ladder tolerances = {};  ///< empty: 1e-10 to 1e-2
  RunLengths lengths = {};
  double refinement = 1.005;  ///< limits are bisected until they lie between two runs no more apart than that
};

struct StabilityCell {
  std::size_t method, column;
  double setting;  ///< step (s) or tolerance
  Tried tried;
};

/// Of one method in one column: the largest setting that it is stable at with all smaller ones, too
/// (is_unstable tells); infinite: at all that were tried; NaN: at none, or it refuses the scene.
///
/// Runs that were not let come to the scene's end (unfinished) tell of `stable` only where they are compared
/// over equal times: where no run below the first unstable one came to its end, the steps are bisected by
/// runs of the length of the longest of those, provided that the unstable one is so within that time, too.
struct StabilityLimit {
  std::size_t method, column;
  double stable, trusted;             ///< the latter by certificate, from the ladder's own settings
  std::optional<double> linear = {};  ///< linear_limit, for stable
  double over = 0;                    ///< s: of the runs that tell of stable; 0: the scene's whole time
  /// The largest setting at or below `stable` of a run that was not let come to the scene's end, and so tells
  /// of nothing beyond where it came to; 0: there is none.
  double unseen = 0;
  bool known = true;  ///< false: no run that was let go on for long enough tells of stable, which is NaN
};

struct StabilityMap {
  Sweep sweep;
  std::vector<std::string> methods;
  Ladder steps, tolerances;
  RunLengths lengths;
  std::vector<StabilityCell> cells;    ///< by method, column, rising setting: the ladders' own, no others
  std::vector<StabilityLimit> limits;  ///< by method, column
  /// By column, of the scene's time: how many times small deviations from the start grow by themselves, as
  /// the natural logarithm (the largest real part of an eigenvalue times that time). 0: they do not, or it is
  /// not known.
  std::vector<double> own_growth = {};
  const Ladder& ladder_of(std::size_t method) const;
};

/// What a map that was broken off has found already, and who is told of each column of a method that ends.
struct StabilityObserver {
  std::function<void(double)> progress = [](double) {};  ///< the share that is done
  std::vector<StabilityCell> known_cells = {};
  std::vector<StabilityLimit> known_limits = {};  ///< of whole columns
  std::function<void(const StabilityMap&)> column_ends = [](const StabilityMap&) {};
};

/// Runs all of it but what is known. Fails where a setting makes no sense, or no scene of the sweep can be
/// read.
Result<StabilityMap> stability_map(Sweep sweep, const StabilitySettings& settings,
                                   const StabilityObserver& observer = {});

/// Of a scene's text (`file` names it): a column for each value of the numbers at `paths`, all set alike.
Result<Sweep> sweep_of_number(const std::string& text, const std::string& file,
                              const std::vector<std::string>& paths, const Ladder& values);

/// A column for each scene. Those that have one name are told apart by their files' (`files`: of all scenes;
/// empty: not known).
Sweep sweep_of_scenes(std::vector<Scene> scenes, const std::vector<std::string>& files = {});

}  // namespace borelli
