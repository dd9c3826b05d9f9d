// Holonomic constraint: a user's own function of coordinates, points and time, in C++, with its derivatives.
#pragma once

#include <functional>
#include <string_view>
#include <vector>

#include "dynamics/site.hpp"

namespace borelli {

class ConstraintScan;

/// What a user's function h(x, t) fills in, at the given x and t. Sized by the engine; zero before each call.
struct FunctionDerivatives {
  double value = 0;               ///< h
  Eigen::VectorXd gradient;       ///< dh/dx
  Eigen::MatrixXd hessian;        ///< d2h/dx2
  double rate = 0;                ///< partial dh/dt
  Eigen::VectorXd gradient_rate;  ///< partial d2h/dxdt
  double acceleration = 0;        ///< partial d2h/dt2
};

/// h(x, t) = 0: one row. x holds the coordinates in the order given, then three world coordinates (m) of each
/// point. Not written to scene files.
struct FunctionConstraint {
  static constexpr std::string_view kind = "function";
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
  static constexpr int length_rows = 0;  ///< the first ones, which are in m
  void evaluate(ConstraintScan& scan) const;
};

}  // namespace borelli
