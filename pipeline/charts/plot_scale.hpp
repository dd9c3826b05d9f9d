// The range of a drawing's axis, and the numbers that stand along it.
#pragma once

#include <cmath>
#include <limits>
#include <vector>

#include "pipeline/charts/plot.hpp"

namespace borelli {

struct PlotScale {
  double low = 0, high = 1;
  bool logarithmic = false;
  std::vector<double> ticks;

  /// Position in [0, 1] along the axis; not finite where the value has none.
  double at(double v) const {
    if (!logarithmic) return (v - low) / (high - low);
    if (!(v > 0)) return std::numeric_limits<double>::quiet_NaN();
    return std::log(v / low) / std::log(high / low);
  }
};

/// Of the values that curves have on an axis, a share `margin` added at either end (not beyond 0) and widened
/// to round numbers, unless the axis gives its bounds; with about `pieces` ticks.
PlotScale scale_of(const Axis& axis, const std::vector<Curve>& curves, std::vector<double> Curve::*values,
                   int pieces, double margin);

}  // namespace borelli
