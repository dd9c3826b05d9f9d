// Interpolating cubic splines: twice continuously differentiable. The natural one minimises the integral of
// the squared second derivative (de Boor, A Practical Guide to Splines, 1978, chapter IV).
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "dynamics/numbers/scalar.hpp"

namespace borelli {

/// Boundary conditions at the first and the last value, and the extrapolation beyond them.
enum class SplineEnds {
  natural,   ///< zero second derivative; extrapolates linearly, twice continuously differentiable
  clamped,   ///< zero first derivative; extrapolates by the end value (the second derivative jumps there)
  periodic,  ///< first and second derivatives agree at both ends; repeats beyond them
  /// Third derivative of the cubic through the four end values (three values: a parabola; two: a line);
  /// extrapolates linearly (the second derivative jumps there). From Forsythe, Malcolm, Moler, Computer
  /// Methods for Mathematical Computations, 1977, section 4.4, "spline"; OpenSim's SimmSpline.
  forsythe
};

/// Names in files, in the order of SplineEnds.
inline constexpr std::string_view spline_ends_names[] = {"natural", "clamped", "periodic", "forsythe"};

/// Value, first and second derivative of a spline at one x.
template <class T>
struct SplineValue {
  T value, slope, curvature;
};

class CubicSpline {
 public:
  CubicSpline() = default;
  /// The spline through (x, y). Precondition: complaint(x, y, ends) is empty.
  CubicSpline(std::vector<double> x, std::vector<double> y, SplineEnds ends);

  /// Why the spline cannot be built; empty: it can. x must rise strictly, and all numbers must be finite. A
  /// spline needs at least two values; a periodic one at least four, the last equal to the first.
  static std::string complaint(const std::vector<double>& x, const std::vector<double>& y, SplineEnds ends);

  bool empty() const { return x_.empty(); }
  /// First and last knot.
  double first() const { return x_.front(); }
  double last() const { return x_.back(); }
  const std::vector<double>& knots() const { return x_; }

  template <class T>
  SplineValue<T> operator()(T x) const {
    const double end = value_of(x);
    if (ends_ == SplineEnds::periodic) {
      const double period = x_.back() - x_.front();
      x -= period * std::floor((end - x_.front()) / period);
    } else if (ends_ == SplineEnds::clamped && (end < x_.front() || end > x_.back())) {
      return {T(end < x_.front() ? y_.front() : y_.back()), T(0), T(0)};
    } else if (end < x_.front()) {
      const auto [value, slope, curvature] = within(0, T(x_.front()));
      return {value + slope * (x - x_.front()), slope, T(0)};
    } else if (end > x_.back()) {
      const auto [value, slope, curvature] = within(x_.size() - 2, T(x_.back()));
      return {value + slope * (x - x_.back()), slope, T(0)};
    }
    const auto above = std::upper_bound(x_.begin() + 1, x_.end() - 1, value_of(x));
    return within(std::size_t(above - x_.begin()) - 1, x);
  }

 private:
  template <class T>
  SplineValue<T> within(std::size_t i, const T& x) const {
    const double h = x_[i + 1] - x_[i], low = bend_[i], high = bend_[i + 1];
    const T a = (x_[i + 1] - x) / h, b = (x - x_[i]) / h;
    return {a * y_[i] + b * y_[i + 1] + (h * h / 6) * (low * (a * a * a - a) + high * (b * b * b - b)),
            (y_[i + 1] - y_[i]) / h + (h / 6) * (high * (3 * b * b - 1) - low * (3 * a * a - 1)),
            low * a + high * b};
  }

  std::vector<double> x_, y_;
  std::vector<double> bend_;  ///< second derivatives at x
  SplineEnds ends_ = SplineEnds::natural;
};

}  // namespace borelli
