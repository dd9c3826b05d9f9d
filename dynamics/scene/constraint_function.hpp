// Holonomic constraint: a user-defined function of coordinates, points and time, in C++, with its
// derivatives.
#pragma once

#include <functional>
#include <string_view>
#include <vector>

#include "dynamics/numbers/scalar.hpp"
#include "dynamics/scene/site.hpp"

namespace borelli {

template <class T>
class ConstraintPass;

/// Output of a user-defined function h(x, t): value and derivatives at x and t. The engine sizes it, and sets
/// it to zero before each call.
struct FunctionDerivatives {
  double value = 0;               ///< h
  Eigen::VectorXd gradient;       ///< dh/dx
  Eigen::MatrixXd hessian;        ///< d2h/dx2
  double rate = 0;                ///< partial dh/dt
  Eigen::VectorXd gradient_rate;  ///< partial d2h/dxdt
  double acceleration = 0;        ///< partial d2h/dt2
};

/// h(x, t) = 0: one row. x holds the coordinates in the given order, then three world coordinates (m) of each
/// point. It cannot be written to scene files.
struct FunctionConstraint {
  static constexpr std::string_view kind = "function";
  static constexpr bool is_code = true;
  std::vector<CoordinateName> coordinates;
  std::vector<SolidPoint> points;
  std::function<void(double t, const Eigen::VectorXd& x, FunctionDerivatives& h)> function;

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("coordinates", self.coordinates);
    visit("points", self.points);
  }

  std::string complaint() const { return function ? "" : "has no function; set one in C++"; }

  static constexpr int rows = 1;
  static constexpr int length_rows = 0;  ///< number of leading rows in m

  template <class T>
  void evaluate(ConstraintPass<T>& pass) const {
    auto& s = pass.scratch();
    const int scalars = int(coordinates.size());
    for (int i = 0; i < scalars; ++i) {
      s.x[i] = pass.position(i);
      s.rate[i] = pass.rate(i);
    }
    for (int i = 0; i < int(points.size()); ++i) {
      const auto point = pass.point(i, points[i].point);
      s.x.template segment<3>(scalars + 3 * i) = point.p;
      s.rate.template segment<3>(scalars + 3 * i) = point.v;
    }
    for (Eigen::Index i = 0; i < s.x.size(); ++i) s.at[i] = value_of(s.x[i]);
    call(pass.time(), s.at, s.h);
    T value = s.h.value, partial = s.h.rate, bias = s.h.acceleration;
    for (Eigen::Index i = 0; i < s.x.size(); ++i) {
      s.gradient[i] = s.h.gradient[i];
      T sum = 2 * s.h.gradient_rate[i];
      for (Eigen::Index j = 0; j < s.x.size(); ++j) sum += s.h.hessian(i, j) * s.rate[j];
      bias += sum * s.rate[i];
    }
    if constexpr (!std::is_same_v<T, double>) differentiate(pass.time(), s, value, partial, bias);
    for (int i = 0; i < scalars; ++i) pass.coordinate(0, i, s.gradient[i]);
    for (int i = 0; i < int(points.size()); ++i)
      pass.along(0, i, s.x.template segment<3>(scalars + 3 * i),
                 s.gradient.template segment<3>(scalars + 3 * i));
    pass.residual(0, value, partial, bias);
  }

 private:
  void call(double t, const Eigen::VectorXd& x, FunctionDerivatives& h) const {
    h.value = h.rate = h.acceleration = 0;
    h.gradient.setZero();
    h.gradient_rate.setZero();
    h.hessian.setZero();
    function(t, x, h);
  }

  /// Adds the derivatives carried by x. Those of the bias by x need third derivatives of h, which the
  /// function does not give. They are the change of (hessian rate + gradient_rate) along the motion, by
  /// central differences.
  template <class Scratch, class T>
  void differentiate(double t, Scratch& s, T& value, T& partial, T& bias) const {
    double fastest = 1;
    for (Eigen::Index i = 0; i < s.x.size(); ++i) fastest = std::max(fastest, std::abs(value_of(s.rate[i])));
    const double step = 1e-5 / fastest;
    for (Eigen::Index i = 0; i < s.x.size(); ++i) s.moved[i] = s.at[i] + step * value_of(s.rate[i]);
    call(t + step, s.moved, s.ahead);
    for (Eigen::Index i = 0; i < s.x.size(); ++i) s.moved[i] = s.at[i] - step * value_of(s.rate[i]);
    call(t - step, s.moved, s.behind);
    for (Eigen::Index i = 0; i < s.x.size(); ++i) {
      const T dx = s.x[i] - s.at[i];  // its value is zero
      double third = s.ahead.gradient_rate[i] - s.behind.gradient_rate[i];
      for (Eigen::Index j = 0; j < s.x.size(); ++j) {
        third += (s.ahead.hessian(i, j) - s.behind.hessian(i, j)) * value_of(s.rate[j]);
        s.gradient[j] += s.h.hessian(j, i) * dx;
      }
      value += s.h.gradient[i] * dx;
      partial += s.h.gradient_rate[i] * dx;
      bias += third / (2 * step) * dx;
    }
  }
};

}  // namespace borelli
