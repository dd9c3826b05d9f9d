#include "pipeline/charts/plot_scale.hpp"

#include <algorithm>

namespace borelli {
namespace {

// A round step (1, 2 or 5 times a power of ten) that divides a range into about `pieces`.
double round_step(double range, int pieces) {
  const double rough = range / pieces, power = std::pow(10, std::floor(std::log10(rough)));
  const double factor = rough / power;
  return power * (factor < 1.5 ? 1 : factor < 3.5 ? 2 : factor < 7.5 ? 5 : 10);
}

void set_linear(PlotScale& scale, const Axis& axis, int pieces) {
  if (scale.high == scale.low) {
    const double half = scale.low == 0 ? 1 : 0.1 * std::abs(scale.low);
    scale.low -= half, scale.high += half;
  }
  double step = round_step(scale.high - scale.low, pieces);
  if (axis.whole_numbers) {  // a margin keeps the first and last marks away from the frame
    step = std::max(1., std::round(step));
    if (!axis.low) scale.low -= 0.3 * step;
    if (!axis.high) scale.high += 0.3 * step;
  } else {
    if (!axis.low) scale.low = step * std::floor(scale.low / step + 1e-9);
    if (!axis.high) scale.high = step * std::ceil(scale.high / step - 1e-9);
  }
  for (double t = std::ceil(scale.low / step - 1e-9); t * step <= scale.high + 1e-9 * step; ++t)
    scale.ticks.push_back(t * step);
}

// The nearest 1, 2 or 5 times a power of ten at or below (above) a value.
double round_below(double value) {
  const double power = std::pow(10, std::floor(std::log10(value) + 1e-9)), factor = value / power;
  return power * (factor < 2 - 1e-9 ? 1 : factor < 5 - 1e-9 ? 2 : 5);
}

double round_above(double value) {
  const double below = round_below(value);
  return below >= value * (1 - 1e-9) ? below : round_below(below * 2.6);  // 1 -> 2, 2 -> 5, 5 -> 10
}

void set_logarithmic(PlotScale& scale, const Axis& axis) {
  if (!axis.low) scale.low = round_below(scale.low);
  if (!axis.high) scale.high = round_above(scale.high);
  if (scale.low == scale.high) scale.low /= 10, scale.high *= 10;
  const int first = static_cast<int>(std::floor(std::log10(scale.low) + 1e-9));
  const int last = static_cast<int>(std::ceil(std::log10(scale.high) - 1e-9));
  const int every = std::max(1, (last - first + 7) / 8);
  const bool few = std::log10(scale.high / scale.low) < 2.5;
  for (int e = first; e <= last; ++e) {
    if ((e - first) % every != 0) continue;
    for (const double factor : few ? std::vector<double>{1, 2, 5} : std::vector<double>{1}) {
      const double tick = factor * std::pow(10, e);
      if (tick >= scale.low * (1 - 1e-9) && tick <= scale.high * (1 + 1e-9)) scale.ticks.push_back(tick);
    }
  }
}

}  // namespace

PlotScale scale_of(const Axis& axis, const std::vector<Curve>& curves, std::vector<double> Curve::*values,
                   int pieces, double margin) {
  PlotScale scale;
  scale.logarithmic = axis.logarithmic;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Curve& curve : curves)
    for (const double v : curve.*values)
      if (std::isfinite(v) && (!axis.logarithmic || v > 0)) low = std::min(low, v), high = std::max(high, v);
  if (!(low <= high)) low = axis.logarithmic ? 0.1 : 0, high = 1;
  if (margin > 0 && axis.logarithmic) {
    const double factor = std::pow(high / low, margin);
    low /= factor, high *= factor;
  } else if (margin > 0) {
    const double more = margin * (high - low);
    low = low < 0 ? low - more : std::max(0., low - more), high += more;
  }
  scale.low = axis.low.value_or(low), scale.high = axis.high.value_or(high);
  if (axis.logarithmic)
    set_logarithmic(scale, axis);
  else
    set_linear(scale, axis, pieces);
  if (!axis.ticks.empty()) scale.ticks = axis.ticks;
  return scale;
}

}  // namespace borelli
