// What a stability map has to show: a map a method, the limits of all, a page, tables for other programs.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "pipeline/charts/plot.hpp"
#include "pipeline/charts/stability.hpp"

namespace borelli {

/// File name (without ending) and drawing: `limits` of all methods of fixed steps where any has one, likewise
/// `limits_tolerance` of adaptive ones, then a map a method. Where there is one column alone, `methods` and
/// `methods_tolerance` stand for the limits: a column a method.
std::vector<std::pair<std::string, Plot>> stability_plots(const StabilityMap& map);

/// All of it on one page that needs no network: drawings with tips, the table of limits, and how each method
/// failed first. `warnings`: the model reader's.
std::string stability_page(const StabilityMap& map, const std::vector<std::string>& warnings = {});

/// A line per run.
std::string stability_csv(const StabilityMap& map);

/// A line per method and column: the limits.
std::string stability_limits_csv(const StabilityMap& map);

/// "0.0141", "all" or "none".
std::string limit_words(double limit);

/// Where motions grow by themselves, by a million times and more in the scene's time: in words, for the scene
/// of the most. Empty: none does.
std::string own_growth_words(const StabilityMap& map);

/// That of stability, with the time that it is of: "0.0141", "2.8e-05 in 0.57 s", "none from 1e-4 on" (the
/// smallest setting tried), or "not known".
std::string stable_words(const StabilityMap& map, const StabilityLimit& limit);

/// Scenes that made a method fail, nearest to its limit: for each method and unstable outcome one, with the
/// method and step that it fails by in its [simulation], and how in its first line:
///     # fails: METHOD at SETTING by OUTCOME: REASON
/// File name and text.
std::vector<std::pair<std::string, std::string>> failing_scenes(const StabilityMap& map,
                                                                const StabilitySettings& settings);

}  // namespace borelli
