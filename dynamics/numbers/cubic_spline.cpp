#include "dynamics/numbers/cubic_spline.hpp"

#include <fmt/format.h>

#include <cmath>

namespace borelli {

namespace {

/// Solves the tridiagonal system below[i] x[i-1] + diagonal[i] x[i] + above[i] x[i+1] = right[i] (Thomas
/// algorithm).
std::vector<double> solve_tridiagonal(const std::vector<double>& below, std::vector<double> diagonal,
                                      const std::vector<double>& above, std::vector<double> right) {
  const std::size_t n = right.size();
  for (std::size_t i = 1; i < n; ++i) {
    const double c = below[i] / diagonal[i - 1];
    diagonal[i] -= c * above[i - 1];
    right[i] -= c * right[i - 1];
  }
  for (std::size_t i = n; i-- > 0;) {
    if (i + 1 < n) right[i] -= above[i] * right[i + 1];
    right[i] /= diagonal[i];
  }
  return right;
}

/// Solves the same system with `corner` at the top right and bottom left of the matrix (Sherman-Morrison
/// formula).
std::vector<double> solve_cyclic(const std::vector<double>& below, std::vector<double> diagonal,
                                 const std::vector<double>& above, double corner,
                                 const std::vector<double>& right) {
  const std::size_t n = right.size();
  const double gamma = -diagonal[0];
  diagonal[0] -= gamma;
  diagonal[n - 1] -= corner * corner / gamma;
  std::vector<double> u(n, 0);
  u[0] = gamma;
  u[n - 1] = corner;
  std::vector<double> x = solve_tridiagonal(below, diagonal, above, right);
  const std::vector<double> z = solve_tridiagonal(below, diagonal, above, u);
  const double part = (x[0] + corner / gamma * x[n - 1]) / (1 + z[0] + corner / gamma * z[n - 1]);
  for (std::size_t i = 0; i < n; ++i) x[i] -= part * z[i];
  return x;
}

/// The third derivative of the cubic through (x, y) from index `first` to first + 3.
double third_derivative(const std::vector<double>& x, const std::vector<double>& y, std::size_t first) {
  double part[4];  // divided differences, of rising order from left to right
  for (std::size_t i = 0; i < 4; ++i) part[i] = y[first + i];
  for (std::size_t order = 1; order < 4; ++order)
    for (std::size_t i = 3; i >= order; --i)
      part[i] = (part[i] - part[i - 1]) / (x[first + i] - x[first + i - order]);
  return 6 * part[3];
}

/// Second derivatives at the knots, from the continuity of the slope between neighbouring pieces.
std::vector<double> bends(const std::vector<double>& x, const std::vector<double>& y, SplineEnds ends) {
  const std::size_t pieces = x.size() - 1;
  const auto width = [&](std::size_t i) { return x[i + 1] - x[i]; };
  const auto slope = [&](std::size_t i) { return (y[i + 1] - y[i]) / width(i); };
  const bool periodic = ends == SplineEnds::periodic, clamped = ends == SplineEnds::clamped;
  const bool forsythe = ends == SplineEnds::forsythe && pieces > 1;
  const std::size_t n = periodic ? pieces : pieces + 1;
  std::vector<double> below(n, 0), diagonal(n, 1), above(n, 0), right(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    if (forsythe && (i == 0 || i == pieces)) {  // the end piece's third derivative is given
      const std::size_t piece = i == 0 ? 0 : pieces - 1;
      const double third = pieces > 2 ? third_derivative(x, y, i == 0 ? 0 : pieces - 3) : 0;
      (i == 0 ? above : below)[i] = i == 0 ? 1 : -1;
      diagonal[i] = i == 0 ? -1 : 1;
      right[i] = third * width(piece);
      continue;
    }
    if (!periodic && !clamped && (i == 0 || i == pieces)) continue;  // zero second derivative
    const bool has_left = i > 0 || periodic, has_right = i < pieces;
    const std::size_t left = i > 0 ? i - 1 : pieces - 1;
    diagonal[i] = ((has_left ? width(left) : 0) + (has_right ? width(i) : 0)) / 3;
    right[i] = (has_right ? slope(i) : 0) - (has_left ? slope(left) : 0);
    if (has_left) below[i] = width(left) / 6;
    if (has_right) above[i] = width(i) / 6;
  }
  if (!periodic) return solve_tridiagonal(below, diagonal, above, right);
  std::vector<double> out = solve_cyclic(below, diagonal, above, width(pieces - 1) / 6, right);
  out.push_back(out.front());
  return out;
}

}  // namespace

CubicSpline::CubicSpline(std::vector<double> x, std::vector<double> y, SplineEnds ends)
    : x_(std::move(x)), y_(std::move(y)), bend_(bends(x_, y_, ends)), ends_(ends) {}

std::string CubicSpline::complaint(const std::vector<double>& x, const std::vector<double>& y,
                                   SplineEnds ends) {
  const std::size_t least = ends == SplineEnds::periodic ? 4 : 2;
  if (x.size() != y.size()) return fmt::format("has {} times and {} values", x.size(), y.size());
  if (x.size() < least) return fmt::format("has {} values, expected at least {}", x.size(), least);
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (!std::isfinite(x[i]) || !std::isfinite(y[i])) return "contains a number that is not finite";
    if (i > 0 && !(x[i] > x[i - 1]))
      return fmt::format("its times must increase, but {} comes after {}", x[i], x[i - 1]);
  }
  if (ends == SplineEnds::periodic && y.front() != y.back())
    return fmt::format("is periodic, but begins with {} and ends with {}", y.front(), y.back());
  return "";
}

}  // namespace borelli
