#include "dynamics/inverse/low_pass.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "dynamics/inverse/quintic_spline.hpp"

namespace borelli {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Adds `count` samples at both ends, reflected about the end points in time and value.
SampledSignal padded(const SampledSignal& signal, Eigen::Index count) {
  const Eigen::Index n = signal.values.rows();
  SampledSignal out{std::vector<double>(std::size_t(n + 2 * count)),
                    MatrixXd(n + 2 * count, signal.values.cols())};
  const auto time = [&](Eigen::Index i) { return signal.times[std::size_t(i)]; };
  for (Eigen::Index i = 0; i < n + 2 * count; ++i) {
    const Eigen::Index from = i - count;
    const Eigen::Index inside = from < 0 ? -from : from >= n ? 2 * (n - 1) - from : from;
    const Eigen::Index end = from < 0 ? 0 : n - 1;
    const bool reflected = inside != from;
    out.times[std::size_t(i)] = reflected ? 2 * time(end) - time(inside) : time(inside);
    if (reflected)
      out.values.row(i) = 2 * signal.values.row(end) - signal.values.row(inside);
    else
      out.values.row(i) = signal.values.row(inside);
  }
  return out;
}

/// Even times at the smallest step, where the steps differ.
Result<SampledSignal> evenly_spaced(SampledSignal signal) {
  const std::vector<double>& times = signal.times;
  double least = times.back() - times.front();
  for (std::size_t i = 1; i < times.size(); ++i) least = std::min(least, times[i] - times[i - 1]);
  const double mean = (times.back() - times.front()) / double(times.size() - 1);
  if (mean - least <= 1e-12 * mean) return signal;
  const double longest = 1e7;
  if ((times.back() - times.front()) / least > longest)
    return bad_use("low-pass filter", "the smallest step of time is too small for the whole duration");
  auto spline = QuinticSpline::through(times, signal.values);
  if (!spline) return tl::unexpected(spline.error());
  const auto count = Eigen::Index(std::floor((times.back() - times.front()) / least * (1 + 1e-12))) + 1;
  SampledSignal out{std::vector<double>(std::size_t(count)), MatrixXd(count, signal.values.cols())};
  VectorXd value, rate, second;
  for (Eigen::Index i = 0; i < count; ++i) {
    out.times[std::size_t(i)] = times.front() + double(i) * least;
    spline->at(out.times[std::size_t(i)], value, rate, second);
    out.values.row(i) = value.transpose();
  }
  return out;
}

/// One run of the filter down the rows. The first three rows stay unfiltered. The transient that this starts
/// decays within the padding.
void run_down(const double (&a)[4], const double (&b)[4], MatrixXd& values) {
  const MatrixXd in = values;
  for (Eigen::Index i = 3; i < values.rows(); ++i)
    values.row(i) = a[0] * in.row(i) + a[1] * in.row(i - 1) + a[2] * in.row(i - 2) + a[3] * in.row(i - 3) -
                    b[1] * values.row(i - 1) - b[2] * values.row(i - 2) - b[3] * values.row(i - 3);
}

}  // namespace

Result<SampledSignal> low_pass(const SampledSignal& signal, double cutoff) {
  const std::string where = "low-pass filter";
  const auto n = Eigen::Index(signal.times.size());
  if (n < 5) return bad_use(where, fmt::format("needs at least 5 samples, has {}", n));
  if (signal.values.rows() != n) return bad_use(where, "the numbers of times and of rows differ");
  for (std::size_t i = 1; i < signal.times.size(); ++i)
    if (!(signal.times[i] > signal.times[i - 1]))
      return bad_use(
          where, fmt::format("time {} of row {} is not after the time before it", signal.times[i], i + 1));
  auto even = evenly_spaced(padded(signal, n / 2));
  if (!even) return even;
  const double step = (even->times.back() - even->times.front()) / double(even->times.size() - 1);
  if (!(cutoff > 0) || !(cutoff * step < 0.5))
    return bad_use(
        where, fmt::format("the cut-off of {} Hz is not between 0 and half of the sampling rate, {:.6g} Hz",
                           cutoff, 0.5 / step));
  // the analogue filter 1 / ((s + 1)(s^2 + s + 1)) by the bilinear transformation, its cut-off warped
  const double w = std::tan(std::numbers::pi * cutoff * step), w2 = w * w, w3 = w2 * w;
  const double unit = (w + 1) * (w2 + w + 1);
  const double a[4] = {w3 / unit, 3 * w3 / unit, 3 * w3 / unit, w3 / unit};
  const double b[4] = {1, (3 * w3 + 2 * w2 - 2 * w - 3) / unit, (3 * w3 - 2 * w2 - 2 * w + 3) / unit,
                       (w - 1) * (w2 - w + 1) / unit};
  for (int run = 0; run < 2; ++run) {
    run_down(a, b, even->values);
    even->values = even->values.colwise().reverse().eval();
  }
  return even;
}

}  // namespace borelli
