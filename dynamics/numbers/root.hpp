// Root of a scalar function within a bracket.
#pragma once

#include <cmath>

namespace borelli {

/// The final bracket of a sign change.
struct Root {
  double before, after;  ///< f has the sign of f(a) at `before`, and not at `after`
  double value_before, value_after;
};

/// Chandrupatla's method (A new hybrid quadratic-bisection algorithm, Advances in Engineering Software 28,
/// 1997): inverse quadratic interpolation where it is safe, otherwise bisection. It takes at most a few steps
/// more than bisection. `f(x, y)` stores the value in y; it returns false if it has none, and find_root then
/// returns false too. f(a) and f(b) must differ in sign (zero counts as the sign that f(a) has not). The
/// bracket shrinks to `resolution`.
template <class Function>
bool find_root(Function&& f, double a, double fa, double b, double fb, double resolution, Root& root) {
  // x1: newest end; x2: other end; x3: previous end
  double x1 = b, f1 = fb, x2 = a, f2 = fa, x3 = a, f3 = fa, t = 0.5;
  const auto as_at_a = [fa](double y) { return y != 0 && (y > 0) == (fa > 0); };
  while (std::abs(x1 - x2) > resolution) {
    const double x = x1 + t * (x2 - x1);
    double y;
    if (x == x1 || x == x2) break;  // no number between them
    if (!f(x, y)) return false;
    if (as_at_a(y) == as_at_a(f1)) {
      x3 = x1;
      f3 = f1;
    } else {
      x3 = x2;
      f3 = f2;
      x2 = x1;
      f2 = f1;
    }
    x1 = x;
    f1 = y;
    const double xi = (x1 - x2) / (x3 - x2), phi = (f1 - f2) / (f3 - f2);
    t = phi * phi < xi && (1 - phi) * (1 - phi) < 1 - xi
            ? f1 / (f2 - f1) * f3 / (f2 - f3) + (x3 - x1) / (x2 - x1) * f1 / (f3 - f1) * f2 / (f3 - f2)
            : 0.5;
    const double least = 0.5 * resolution / std::abs(x1 - x2);
    t = std::min(std::max(t, std::min(least, 0.5)), std::max(1 - least, 0.5));
  }
  root = as_at_a(f1) ? Root{x1, x2, f1, f2} : Root{x2, x1, f2, f1};
  return true;
}

}  // namespace borelli
