// Figures 2, 3, 4, 6, 7, 8 and 10 of the paper that the engine follows, drawn from our own runs.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "error/error.hpp"
#include "pipeline/charts/plot.hpp"
#include "pipeline/paper/shock_ratios.hpp"

namespace borelli {

struct PaperFigure {
  std::string name;  ///< "figure_2" ...
  Plot plot;
};

/// Lengths of the runs. The defaults match the paper; tests use shorter runs.
struct PaperFigureSettings {
  double roundabout_end = 5;               ///< s, figures 2 to 4
  double shock_end = 5;                    ///< s, figures 6 to 8
  double shock_step = 1e-4;                ///< s, figure 6
  ShockRatioSettings shock_ratios;         ///< drawn beside figures 6 to 8
  double bars_end = 10;                    ///< s, figure 10
  std::vector<int> counts{3, 4, 5, 6, 7};  ///< n, figure 10
  int repeats = 5;                         ///< figure 10: runs per point, of which the median counts
  double tolerance = 1e-6;                 ///< of the adaptive method
};

/// Runs the scenes and draws the figures. Two more drawings show the drift of the total energy, which the
/// paper's scale hides. `begins` receives each figure's name before its runs. Errors: a scene that does not
/// run to its end.
Result<std::vector<PaperFigure>> paper_figures(
    const PaperFigureSettings& settings = {},
    const std::function<void(const std::string& name)>& begins = [](const std::string&) {});

}  // namespace borelli
