// What becomes of energy and momentum over a hundred thousand steps.
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
  long steps = 100000;   ///< of fixed methods; adaptive ones run as long in time, in as many steps at most
  double step = 0;       ///< s; 0: the scene's
  double tolerance = 0;  ///< 0: the scene's
};

/// One method's run, at a thousand times.
struct LongRun {
  std::string method;
  std::string reason = {};          ///< why it did not come to its end; empty: it did
  std::vector<double> times = {};   ///< s
  std::vector<double> energy = {};  ///< kinetic + potential - work, less its start, over what was turned over
  /// Of all momenta that the scene conserves, the one farthest off, over its size; empty: it conserves none.
  std::vector<double> momentum = {};
  double swing = 0;      ///< of energy to and fro, over the first quarter: its largest less its least
  double drift = 0;      ///< 1/s: from the mean of the first quarter to that of the last
  bool secular = false;  ///< what it drifts by over the run exceeds the swing, or goes on and on: it adds up
  long evaluations = 0;

  /// Whether the energy is off by more than a tenth of what was turned over: that it goes to and fro is then
  /// no merit.
  bool large() const {
    return std::any_of(energy.begin(), energy.end(), [](double x) { return std::abs(x) > 0.1; });
  }
};

struct LongRuns {
  std::string scene;
  double step = 0, end = 0;  ///< s
  std::vector<LongRun> runs;
};

/// Fails where the scene does not compile or settings make no sense; a method that fails says so in its run.
Result<LongRuns> long_runs(
    const Scene& scene, const LongRunSettings& settings,
    const std::function<void(double)>& progress = [](double) {});

/// Energy over time of methods that add up errors and of those that do not, then momentum: file name and
/// drawing.
std::vector<std::pair<std::string, Plot>> long_run_plots(const LongRuns& runs);
inline std::vector<std::string> long_run_plot_names() {
  return {"energy_secular", "energy_bounded", "momentum"};
}

std::string long_runs_page(const LongRuns& runs, const std::vector<std::string>& warnings = {});

/// A line per method: swing, drift, verdict.
std::string long_runs_csv(const LongRuns& runs);

}  // namespace borelli
