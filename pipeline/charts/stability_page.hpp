// Output of a stability map: one map per method, the limits of all methods, a page, tables for other
// programs.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "pipeline/charts/plot.hpp"
#include "pipeline/charts/stability.hpp"

namespace borelli {

/// File name (without extension) and drawing: `limits` of all fixed-step methods if any has one,
/// `limits_tolerance` of adaptive ones, then one map per method. With a single column, `methods` and
/// `methods_tolerance` replace the limits, with one column per method.
std::vector<std::pair<std::string, Plot>> stability_plots(const StabilityMap& map);

/// One page that needs no network: drawings with tips, the table of limits, and each method's first failure.
/// `warnings`: from the reader of the model.
std::string stability_page(const StabilityMap& map, const std::vector<std::string>& warnings = {});

/// One line per run.
std::string stability_csv(const StabilityMap& map);

/// One line per method and column: the limits.
std::string stability_limits_csv(const StabilityMap& map);

/// "0.0141", "all" or "none".
std::string limit_words(double limit);

/// A sentence on motions that grow by themselves by a factor of a million or more in the scene's time, for
/// the scene that grows most; "" if none does.
std::string own_growth_words(const StabilityMap& map);

/// The limit of stability with the time it refers to: "0.0141", "2.8e-05 in 0.57 s", "none from 1e-4 on" (the
/// smallest tried setting), or "not known".
std::string stable_words(const StabilityMap& map, const StabilityLimit& limit);

/// File name and text of scenes that made a method fail. For each method and unstable outcome there is one,
/// nearest to the limit. Its [simulation] holds the failing method and step, its first line the outcome:
///     # fails: METHOD at SETTING by OUTCOME: REASON
std::vector<std::pair<std::string, std::string>> failing_scenes(const StabilityMap& map,
                                                                const StabilitySettings& settings);

}  // namespace borelli
