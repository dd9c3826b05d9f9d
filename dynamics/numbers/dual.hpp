// A dual number: a value with its derivatives along N directions (forward-mode automatic differentiation;
// Griewank, Walther, Evaluating Derivatives, 2nd edition, 2008, chapter 3). The engine evaluated on dual
// numbers gives exact derivatives.
#pragma once

#include <array>
#include <limits>

#include "dynamics/numbers/scalar.hpp"

namespace borelli {

template <int N>
struct Dual {
  double value = 0;
  std::array<double, N> d{};  ///< its derivative along each direction

  Dual() = default;
  Dual(double constant) : value(constant) {}  // NOLINT: a constant is a number without derivatives

  Dual& operator+=(const Dual& b) {
    value += b.value;
    for (int i = 0; i < N; ++i) d[i] += b.d[i];
    return *this;
  }
  Dual& operator-=(const Dual& b) {
    value -= b.value;
    for (int i = 0; i < N; ++i) d[i] -= b.d[i];
    return *this;
  }
  Dual& operator*=(const Dual& b) {
    for (int i = 0; i < N; ++i) d[i] = d[i] * b.value + value * b.d[i];
    value *= b.value;
    return *this;
  }
  Dual& operator/=(const Dual& b) {
    const double inverse = 1 / b.value;
    value *= inverse;
    for (int i = 0; i < N; ++i) d[i] = (d[i] - value * b.d[i]) * inverse;
    return *this;
  }
  Dual& operator+=(double b) { return value += b, *this; }
  Dual& operator-=(double b) { return value -= b, *this; }
  Dual& operator*=(double b) {
    value *= b;
    for (double& x : d) x *= b;
    return *this;
  }
  Dual& operator/=(double b) { return *this *= 1 / b; }

  Dual operator-() const {
    Dual out;
    out.value = -value;
    for (int i = 0; i < N; ++i) out.d[i] = -d[i];
    return out;
  }
  friend Dual operator+(Dual a, const Dual& b) { return a += b; }
  friend Dual operator-(Dual a, const Dual& b) { return a -= b; }
  friend Dual operator*(Dual a, const Dual& b) { return a *= b; }
  friend Dual operator/(Dual a, const Dual& b) { return a /= b; }
  friend Dual operator+(Dual a, double b) { return a += b; }
  friend Dual operator-(Dual a, double b) { return a -= b; }
  friend Dual operator*(Dual a, double b) { return a *= b; }
  friend Dual operator/(Dual a, double b) { return a /= b; }
  friend Dual operator+(double a, Dual b) { return b += a; }
  friend Dual operator-(double a, const Dual& b) { return -b += a; }
  friend Dual operator*(double a, Dual b) { return b *= a; }
  friend Dual operator/(double a, const Dual& b) { return Dual(a) /= b; }

  // Comparisons use the values alone.
  friend bool operator==(const Dual& a, const Dual& b) { return a.value == b.value; }
  friend auto operator<=>(const Dual& a, const Dual& b) { return a.value <=> b.value; }
  friend bool operator==(const Dual& a, double b) { return a.value == b; }
  friend auto operator<=>(const Dual& a, double b) { return a.value <=> b; }

  /// Chain rule: value `f`, and derivatives `slope` * d, with `slope` the derivative of f at the value.
  Dual mapped(double f, double slope) const {
    Dual out;
    out.value = f;
    for (int i = 0; i < N; ++i) out.d[i] = slope * d[i];
    return out;
  }
};

template <int N>
double value_of(const Dual<N>& x) {
  return x.value;
}

template <int N>
Dual<N> sin(const Dual<N>& x) {
  return x.mapped(std::sin(x.value), std::cos(x.value));
}
template <int N>
Dual<N> cos(const Dual<N>& x) {
  return x.mapped(std::cos(x.value), -std::sin(x.value));
}
/// The square root. At zero it has no derivative; 0 is used, which suits a length: there it has its minimum.
template <int N>
Dual<N> sqrt(const Dual<N>& x) {
  const double root = std::sqrt(x.value);
  return x.mapped(root, root > 0 ? 0.5 / root : 0);
}
template <int N>
Dual<N> atan2(const Dual<N>& y, const Dual<N>& x) {
  const double size2 = x.value * x.value + y.value * y.value;
  Dual<N> out;
  out.value = std::atan2(y.value, x.value);
  for (int i = 0; i < N; ++i) out.d[i] = (x.value * y.d[i] - y.value * x.d[i]) / size2;
  return out;
}
template <int N>
Dual<N> abs(const Dual<N>& x) {
  return x.value < 0 ? -x : x;
}

/// The engine is compiled for this width: one pass differentiates by the ten inertial numbers of a solid, or
/// by ten coordinates.
using DualNumber = Dual<10>;

}  // namespace borelli

template <int N>
struct Eigen::NumTraits<borelli::Dual<N>> : Eigen::NumTraits<double> {
  using Real = borelli::Dual<N>;
  using NonInteger = borelli::Dual<N>;
  using Nested = borelli::Dual<N>;
  using Literal = double;
  enum { RequireInitialization = 1, ReadCost = N, AddCost = N, MulCost = 3 * N };
};
template <int N, class Operation>
struct Eigen::ScalarBinaryOpTraits<borelli::Dual<N>, double, Operation> {
  using ReturnType = borelli::Dual<N>;
};
template <int N, class Operation>
struct Eigen::ScalarBinaryOpTraits<double, borelli::Dual<N>, Operation> {
  using ReturnType = borelli::Dual<N>;
};
