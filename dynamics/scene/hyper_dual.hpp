// Exact first and second derivatives of a function from its own code, for FunctionConstraint: hyper-dual
// numbers (Fike, Alonso, The Development of Hyper-Dual Numbers for Exact Second-Derivative Calculations, AIAA
// 2011-886).
#pragma once

#include <cmath>
#include <vector>

#include "dynamics/scene/constraint_function.hpp"

namespace borelli {

/// A value with its derivatives along two directions and the mixed second derivative.
struct HyperDual {
  double value = 0, d1 = 0, d2 = 0, d12 = 0;

  HyperDual() = default;
  HyperDual(double constant) : value(constant) {}  // NOLINT: a constant is a number without derivatives
  HyperDual(double v, double a, double b, double ab) : value(v), d1(a), d2(b), d12(ab) {}

  friend HyperDual operator+(const HyperDual& a, const HyperDual& b) {
    return {a.value + b.value, a.d1 + b.d1, a.d2 + b.d2, a.d12 + b.d12};
  }
  HyperDual operator-() const { return {-value, -d1, -d2, -d12}; }
  friend HyperDual operator-(const HyperDual& a, const HyperDual& b) { return a + -b; }
  friend HyperDual operator*(const HyperDual& a, const HyperDual& b) {
    return {a.value * b.value, a.d1 * b.value + a.value * b.d1, a.d2 * b.value + a.value * b.d2,
            a.d12 * b.value + a.d1 * b.d2 + a.d2 * b.d1 + a.value * b.d12};
  }
  friend HyperDual operator/(const HyperDual& a, const HyperDual& b) {
    const double inverse = 1 / b.value;
    return a * b.mapped(inverse, -inverse * inverse, 2 * inverse * inverse * inverse);
  }
  HyperDual& operator+=(const HyperDual& b) { return *this = *this + b; }
  HyperDual& operator-=(const HyperDual& b) { return *this = *this - b; }
  HyperDual& operator*=(const HyperDual& b) { return *this = *this * b; }
  HyperDual& operator/=(const HyperDual& b) { return *this = *this / b; }

  // Comparisons use the values alone.
  friend bool operator==(const HyperDual& a, const HyperDual& b) { return a.value == b.value; }
  friend auto operator<=>(const HyperDual& a, const HyperDual& b) { return a.value <=> b.value; }

  /// Chain rule: value `f`, with `slope` and `curvature` the first and second derivatives of f at the value.
  HyperDual mapped(double f, double slope, double curvature) const {
    return {f, slope * d1, slope * d2, slope * d12 + curvature * d1 * d2};
  }
};

inline HyperDual sin(const HyperDual& x) {
  const double s = std::sin(x.value);
  return x.mapped(s, std::cos(x.value), -s);
}
inline HyperDual cos(const HyperDual& x) {
  const double c = std::cos(x.value);
  return x.mapped(c, -std::sin(x.value), -c);
}
inline HyperDual exp(const HyperDual& x) {
  const double e = std::exp(x.value);
  return x.mapped(e, e, e);
}
inline HyperDual log(const HyperDual& x) {
  return x.mapped(std::log(x.value), 1 / x.value, -1 / (x.value * x.value));
}
inline HyperDual sqrt(const HyperDual& x) {
  const double root = std::sqrt(x.value);
  return x.mapped(root, 0.5 / root, -0.25 / (root * x.value));
}
inline HyperDual pow(const HyperDual& x, double n) {
  return x.mapped(std::pow(x.value, n), n * std::pow(x.value, n - 1), n * (n - 1) * std::pow(x.value, n - 2));
}
inline HyperDual atan(const HyperDual& x) {
  const double d = 1 / (1 + x.value * x.value);
  return x.mapped(std::atan(x.value), d, -2 * x.value * d * d);
}
inline HyperDual abs(const HyperDual& x) { return x.value < 0 ? -x : x; }

/// Makes the function of a FunctionConstraint from h(t, x) alone. `h` takes the time and a std::vector, both
/// of HyperDual, and returns a HyperDual. It is called once for each pair of its variables (time is one).
/// With many variables, a function with hand-written derivatives is faster.
template <class Function>
auto with_derivatives(Function h) {
  return [h](double t, const Eigen::VectorXd& x, FunctionDerivatives& out) {
    const int n = int(x.size());
    thread_local std::vector<HyperDual> y;
    const auto along = [&](int i, int j) {  // -1: time
      y.assign(std::size_t(n), HyperDual());
      HyperDual time(t);
      for (int k = 0; k < n; ++k) y[std::size_t(k)] = x[k];
      (i < 0 ? time : y[std::size_t(i)]).d1 = 1;
      (j < 0 ? time : y[std::size_t(j)]).d2 = 1;
      return HyperDual(h(time, y));
    };
    const HyperDual in_time = along(-1, -1);
    out.value = in_time.value;
    out.rate = in_time.d1;
    out.acceleration = in_time.d12;
    for (int i = 0; i < n; ++i) {
      out.gradient_rate[i] = along(i, -1).d12;
      for (int j = 0; j <= i; ++j) {
        const HyperDual one = along(i, j);
        out.gradient[i] = one.d1;
        out.hessian(i, j) = out.hessian(j, i) = one.d12;
      }
    }
  };
}

}  // namespace borelli
