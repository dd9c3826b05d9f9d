// Compares the cost of fixed and adaptive steps in the paper's shock scene, over the mass ratio of the cube
// to the bar that stops it.
#pragma once

#include <string>
#include <vector>

#include "error/error.hpp"

namespace borelli {

struct ShockRatioSettings {
  std::vector<double> mass_ratios{1, 2, 5, 10, 20, 50, 100, 200, 500, 1000};  ///< cube over bar (1 kg)
  double end = 5;                                                             ///< s
  /// Largest error of the total energy, over the energy of the cube's fall through the bar's length.
  double energy_error = 1e-5;
};

/// The compared methods: the first has fixed steps, the second is the paper's adaptive one.
inline constexpr const char* shock_methods[] = {"rk4", "rk4_adaptive", "dopri5", "dop853", "gbs"};

/// Evaluations of the equations that each method needs to keep the total energy, which the scene conserves,
/// within the allowed error over the whole run. Starting coarse, steps are halved (tolerances divided by
/// 10^(1/2)) until the error is small enough; between the last two runs the count is interpolated in
/// logarithms. NaN: not reached within 4e6 evaluations.
struct ShockRatio {
  double mass_ratio = 0;
  std::vector<double> evaluations;  ///< by shock_methods
};

/// Errors: a run that ends early; the error names its method and mass ratio.
Result<std::vector<ShockRatio>> shock_ratios(const ShockRatioSettings& settings = {});

}  // namespace borelli
