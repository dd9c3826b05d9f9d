// Drift of energy and momentum over a hundred thousand steps.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "pipeline/charts/plot.hpp"
#include "pipeline/charts/stability.hpp"

namespace borelli {

struct LongRunSettings {
  std::vector<std::string> methods = {};  ///< of integrator_names(); empty: all
  Equations equations = Equations::recursive;
  long steps = 100000;   ///< fixed methods; adaptive methods run for the same time, in as many steps at most
  double step = 0;       ///< s; 0: the scene's
  double tolerance = 0;  ///< 0: the scene's
};

/// One method's run, recorded at a thousand times.
struct LongRun {
  std::string method;
  std::string reason = {};         ///< why the run did not finish; empty: it finished
  std::vector<double> times = {};  ///< s
  std::vector<double> energy =
      {};  ///< change of kinetic + potential - work since the start, over the turnover
  /// Error of the conserved momentum that is farthest off, over its size; empty: the scene conserves none.
  std::vector<double> momentum = {};
  double swing = 0;      ///< oscillation of the energy: largest minus smallest in the first quarter
  double drift = 0;      ///< systematic drift: above the swing over the run, or monotone over its eighths
  bool secular = false;  ///< the drift is systematic: it exceeds the swing over the run, or keeps one sign
  long evaluations = 0;

  /// Whether the energy error exceeds a tenth of the turnover. Such an energy deserves no praise for merely
  /// oscillating.
  bool large() const {
    return std::any_of(energy.begin(), energy.end(), [](double x) { return std::abs(x) > 0.1; });
  }
};

struct LongRuns {
  std::string scene;
  double step = 0, end = 0;  ///< s
  std::vector<LongRun> runs;
};

/// Errors: the scene does not compile, or settings make no sense. A method that fails gives a run with a
/// reason.
Result<LongRuns> long_runs(
    const Scene& scene, const LongRunSettings& settings,
    const std::function<void(double)>& progress = [](double) {});

/// File name and drawing: energy of methods with secular drift, energy of those without, momentum.
std::vector<std::pair<std::string, Plot>> long_run_plots(const LongRuns& runs);
inline std::vector<std::string> long_run_plot_names() {
  return {"energy_secular", "energy_bounded", "momentum"};
}

std::string long_runs_page(const LongRuns& runs, const std::vector<std::string>& warnings = {});

/// One line per method: swing, drift, verdict.
std::string long_runs_csv(const LongRuns& runs);

}  // namespace borelli
