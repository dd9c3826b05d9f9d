// Output of the search for a smaller model: drawings, a page, a table.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "pipeline/charts/economy.hpp"
#include "pipeline/charts/plot.hpp"

namespace borelli {

/// File name and drawing of error and of processor time, each against the number of remaining coordinates.
std::vector<std::pair<std::string, Plot>> economy_plots(const Economy& economy);
inline std::vector<std::string> economy_plot_names() { return {"error", "time"}; }

/// `warnings`: from the reader of the model.
std::string economy_page(const Economy& economy, const std::vector<std::string>& warnings = {});

/// One line per model.
std::string economy_csv(const Economy& economy);

/// "10 of 16 coordinates and 4 of 6 solids do within 0.01, in 0.4 of the time".
std::string in_words(const Economy& economy);

}  // namespace borelli
