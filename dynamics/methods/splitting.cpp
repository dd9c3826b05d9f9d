#include "dynamics/methods/splitting.hpp"

#include <cmath>

#include "dynamics/numbers/settling.hpp"

namespace borelli {

namespace {

/// Positions of `out` <- the positions after h from y with the velocities in `out`, by the trapezoidal rule
/// in the local coordinates (exact if they are centred on y). Returns false if no convergence.
bool move_positions(Flow& flow, double h, const Eigen::VectorXd& y, Eigen::VectorXd& slope,
                    Eigen::VectorXd& at_start, Eigen::VectorXd& out) {
  const Eigen::Index n = flow.positions();
  out.head(n) = y.head(n);
  slope.resize(y.size());
  flow.position_rate(out, slope);
  at_start = slope;
  for (Settling settling;;) {
    double worst = 0;
    for (Eigen::Index i = 0; i < n; ++i) {
      const double next = y[i] + 0.5 * h * (at_start[i] + slope[i]);
      worst = std::max(worst, std::abs(next - out[i]) / flow.error_scale()[i]);
      out[i] = next;
    }
    const auto verdict = settling.after(worst);
    if (verdict == Settling::Verdict::settled) return true;
    if (verdict == Settling::Verdict::failed) return false;
    flow.position_rate(out, slope);
  }
}

constexpr const char* turns_too_far =
    "the positions of a step could not be found, because it turns a ball too far; take smaller steps";

}  // namespace

Attempt SemiImplicitEuler::attempt(Flow& flow, double, double h, const Eigen::VectorXd& y,
                                   const Eigen::VectorXd& dy, Eigen::VectorXd& out) {
  out = y + h * dy;
  if (!move_positions(flow, h, y, slope_, at_start_, out))
    return {.evaluated = false, .next_step = h, .trouble = turns_too_far};
  return {.next_step = h};
}

Attempt VelocityVerlet::attempt(Flow& flow, double t, double h, const Eigen::VectorXd& y,
                                const Eigen::VectorXd& dy, Eigen::VectorXd& out) {
  const Eigen::Index n = flow.positions();
  Attempt failed{.evaluated = false, .next_step = h};
  half_ = y;
  first_ = dy;
  for (Settling settling;;) {
    double worst = 0;
    for (Eigen::Index i = n; i < 2 * n; ++i) {
      const double next = y[i] + 0.5 * h * first_[i];
      if (const double moved = std::abs(next - half_[i]) / flow.error_scale()[i]; !(moved <= worst)) {
        worst = moved;
        failed.worst = int(i);
      }
      half_[i] = next;
    }
    const auto verdict = settling.after(worst);
    if (verdict == Settling::Verdict::settled) break;
    // A diverging iteration may reach velocities at which f cannot be evaluated.
    if (verdict == Settling::Verdict::failed || !flow.derivative(t, half_, first_)) {
      failed.trouble =
          "the half step of the velocity did not converge, because forces depend on it too strongly; take "
          "smaller steps, or an implicit method";
      return failed;
    }
  }
  out = half_;
  if (!move_positions(flow, h, y, slope_, at_start_, out)) {
    failed.trouble = turns_too_far;
    return failed;
  }
  if (!flow.derivative(t + h, out, slope_)) return failed;
  out.tail(y.size() - n) = half_.tail(y.size() - n) + 0.5 * h * slope_.tail(y.size() - n);
  out.tail(y.size() - 2 * n) += 0.5 * h * first_.tail(y.size() - 2 * n);
  return {.next_step = h};
}

}  // namespace borelli
