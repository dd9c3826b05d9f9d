// Plots of a page: for the browser as data, which the page's program draws with uPlot, and as SVG for print
// and for readers without JavaScript.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "pipeline/charts/plot.hpp"

namespace borelli {

struct PagePlot {
  std::vector<std::pair<std::string, std::string>> choice;  ///< kind and value of the buttons that show it
  Plot plot;
};

/// A page shows at most this many curves of a plot before the reader asks for more.
inline constexpr std::size_t curves_at_first = 6;

/// By the plot's curves: whether a page shows it at first. One curve of each group is chosen, then a second
/// of each, and so on; faint curves are not, and broad ones always are.
std::vector<bool> shown_at_first(const Plot& plot);

/// One <figure class="plot"> for each plot, and their data as JSON in <script id="plots">.
std::string page_plots(const std::vector<PagePlot>& plots);

}  // namespace borelli
