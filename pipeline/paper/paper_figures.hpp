// Figures 2, 3, 4, 6, 7, 8 and 10 of the paper that the engine follows, drawn anew from our own runs.
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

/// How long the runs are. The standard is what the paper shows; tests take less.
struct PaperFigureSettings {
  double roundabout_end = 5;               ///< s, figures 2 to 4
  double shock_end = 5;                    ///< s, figures 6 to 8
  double shock_step = 1e-4;                ///< s, figure 6
  ShockRatioSettings shock_ratios;         ///< beside figures 6 to 8
  double bars_end = 10;                    ///< s, figure 10
  std::vector<int> counts{3, 4, 5, 6, 7};  ///< n, figure 10
  int repeats = 5;                         ///< figure 10: the median of so many
  double tolerance = 1e-6;                 ///< of the adaptive method
};

/// Runs the scenes and draws them; beside them two drawings of how far the total energy strays, which the
/// paper's scale hides. `begins` is told each figure's name before its runs. Fails where a scene cannot be
/// run to its end.
Result<std::vector<PaperFigure>> paper_figures(
    const PaperFigureSettings& settings = {},
    const std::function<void(const std::string& name)>& begins = [](const std::string&) {});

}  // namespace borelli
