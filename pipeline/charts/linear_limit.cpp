#include "pipeline/charts/linear_limit.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <limits>

#include "dynamics/equations/derivatives.hpp"

namespace borelli {
namespace {

using Complex = std::complex<double>;

constexpr double unbounded = std::numeric_limits<double>::infinity();

// real parts below this share of the eigenvalue's size count as zero: rounding leaves that much on undamped
// oscillations
constexpr double no_damping = 1e-7;

// eigenvalues below this count as zero, 1/s: the square root of the rounding error of balanced forces
constexpr double no_change = 1e-6;

/// Stability polynomial 1 + z + ... + z^order / order! of Runge-Kutta methods with as many stages as their
/// order.
Complex amplification(int order, Complex z) {
  Complex sum = 1, term = 1;
  for (int k = 1; k <= order; ++k) {
    term *= z / double(k);
    sum += term;
  }
  return sum;
}

/// The largest y such that |R(y direction)| <= 1 on all of [0, y]. (For order 4 or less, y is below 4.)
double boundary(int order, Complex direction) {
  const auto grows = [&](double y) { return std::abs(amplification(order, y * direction)) > 1 + 1e-12; };
  double low = 0, high = 0;
  for (int i = 1; i <= 4000 && high == 0; ++i) (grows(i * 1e-3) ? high : low) = i * 1e-3;
  // growth at the shortest tried steps is below rounding, so a method that grows at every step ends here
  if (low < 0.003) return 0;
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    (grows(middle) ? high : low) = middle;
  }
  return low;
}

}  // namespace

std::optional<SmallDeviations> deviations_from_start(const System& system) {
  const int n = system.nv;
  const auto by = forward_derivatives(system, system.initial);
  if (!by || n == 0) return std::nullopt;
  Eigen::MatrixXd slope = Eigen::MatrixXd::Zero(2 * n, 2 * n);
  slope.topRightCorner(n, n).setIdentity();
  slope.bottomLeftCorner(n, n) = by->acceleration_by_q;
  slope.bottomRightCorner(n, n) = by->acceleration_by_v;
  if (!slope.allFinite()) return std::nullopt;
  const Eigen::VectorXcd values = slope.eigenvalues();
  return SmallDeviations{{values.begin(), values.end()}, by->acceleration_by_v.cwiseAbs().maxCoeff() > 0};
}

// real parts below this share of the eigenvalue's size may be rounding, which multiple eigenvalues amplify
constexpr double no_growth = 1e-3;

double growth_rate(const SmallDeviations& deviations) {
  double most = 0;
  for (const Complex& lambda : deviations.eigenvalues)
    if (lambda.real() > std::max(no_change, no_growth * std::abs(lambda)))
      most = std::max(most, lambda.real());
  return most;
}

std::optional<double> linear_limit(const std::string& method, const SmallDeviations& deviations) {
  for (const char* a_stable : {"implicit_midpoint", "gauss4", "gauss6", "generalized_alpha"})
    if (method == a_stable) return unbounded;
  const int order = method == "euler" ? 1 : method == "rk2" ? 2 : method == "rk4" ? 4 : 0;
  const bool leaps = method == "semi_implicit_euler" || method == "verlet";
  if (order == 0 && (!leaps || deviations.by_velocity)) return std::nullopt;
  double largest = 0, limit = unbounded;
  for (const Complex& value : deviations.eigenvalues) largest = std::max(largest, std::abs(value));
  for (const Complex& value : deviations.eigenvalues) {
    const double size = std::abs(value);
    if (size <= std::max(no_damping * largest, no_change) || value.real() > no_damping * size) continue;
    const bool swings = std::abs(value.real()) <= no_damping * size;
    const Complex direction = swings ? Complex(0, 1) : value / size;
    limit = std::min(limit, (leaps ? 2 : boundary(order, direction)) / size);
  }
  return limit;
}

}  // namespace borelli
