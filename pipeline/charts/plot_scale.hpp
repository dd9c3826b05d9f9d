// Range and tick values of a drawing's axis.
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

  /// Position in [0, 1] along the axis; not finite if the value has none.
  double at(double v) const {
    if (!logarithmic) return (v - low) / (high - low);
    if (!(v > 0)) return std::numeric_limits<double>::quiet_NaN();
    return std::log(v / low) / std::log(high / low);
  }
};

/// Scale for the curves' values on an axis, with a share `margin` added at either end (not beyond 0), widened
/// to round numbers unless the axis gives bounds; about `pieces` ticks.
PlotScale scale_of(const Axis& axis, const std::vector<Curve>& curves, std::vector<double> Curve::*values,
                   int pieces, double margin);

}  // namespace borelli
