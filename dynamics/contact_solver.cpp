#include "dynamics/contact_solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "dynamics/impact.hpp"
#include "dynamics/processor.hpp"

namespace borelli {

using Eigen::Vector2d;
using Eigen::VectorXd;

namespace {

// Newton's method may be sent from one mode to another and back: it has so many solves, and so many about
// each proximal point
constexpr int quick_solves = 5, most_solves = 10, free_solves = 3, most_idle = 2, sweeps_between = 300;
constexpr double rounding = 1e-14;  // a part of the velocities

// The projection's step r, in parts of what one contact alone would take: any of them has the same solution,
// but Newton's method takes another way to it.
constexpr double projection_steps[] = {1, 10, 0.1, 100};

// In parts of a row's own response: what keeps the impulses of dependent contacts near what they were. The
// equations are off by it times the change of the impulses, so after the last solve by nothing. Where a full
// step leads away it grows (Levenberg, Marquardt).
constexpr double least_damping = 1e-9, most_damping = 100;

// The same, of proximal points.
constexpr double first_proximal = 1e-3, least_proximal = 1e-6, most_proximal = 10;
constexpr int most_points = 30;

constexpr int width = 8;  // numbers gone over at once

/// Gauss' elimination with pivots of the column, of n rows of `stride` numbers each (a multiple of `width`,
/// what is behind column n being zeros), right side in column n, where the solution comes to stand. Two
/// columns at a time, each row being gone over half as often; what is left of the diagonal is not looked at
/// again, and may be written over. False: singular.
BORELLI_LANES_FOR_PROCESSOR
bool eliminate(double* __restrict a, int n, int stride) {
  const auto pivot_to = [&](int k, int from) {  // rows from k on, columns from `from` on
    int pivot = k;
    for (int i = k + 1; i < n; ++i)
      if (std::abs(a[i * stride + k]) > std::abs(a[pivot * stride + k])) pivot = i;
    if (pivot != k) std::swap_ranges(a + k * stride + from, a + (k + 1) * stride, a + pivot * stride + from);
    return a[k * stride + k] != 0 && std::isfinite(a[k * stride + k]);
  };
  for (int k = 0; k < n; k += 2) {
    if (!pivot_to(k, k)) return false;
    if (k + 1 == n) break;
    const double* __restrict first = a + k * stride;
    const double inverse = 1 / first[k];
    for (int i = k + 1; i < n; ++i) {  // the next column, before its pivot is chosen
      double* other = a + i * stride;
      other[k] *= inverse;
      other[k + 1] -= other[k] * first[k + 1];
    }
    if (!pivot_to(k + 1, k)) return false;
    double* __restrict second = a + (k + 1) * stride;
    for (int j = k + 2; j <= n; ++j) second[j] -= second[k] * first[j];
    const double next_inverse = 1 / second[k + 1];
    const int begin = (k + 2) & ~(width - 1);
    for (int i = k + 2; i < n; ++i) {
      double* __restrict other = a + i * stride;
      const double c = other[k], d = other[k + 1] * next_inverse;
      if (c == 0 && d == 0) continue;
      for (int j = begin; j < stride; j += width)
        for (int l = j; l < j + width; ++l) other[l] -= c * first[l] + d * second[l];
    }
  }
  for (int k = n - 1; k >= 0; --k) {
    double sum = a[k * stride + n];
    for (int j = k + 1; j < n; ++j) sum -= a[k * stride + j] * a[j * stride + n];
    a[k * stride + n] = sum / a[k * stride + k];
  }
  return true;
}

/// u += by * G.row(r): a sum over n numbers.
BORELLI_LANES_FOR_PROCESSOR
void add_row(const double* row, double by, int n, double* u) {
  for (int i = 0; i < n; ++i) u[i] += by * row[i];
}

}  // namespace

void ContactSolver::update_velocity(const ContactProblem& c, const VectorXd& p) {
  const int n = 3 * c.count;
  u_.head(n) = c.free.head(n);
  for (int r = 0; r < n; ++r)
    if (p[r] != 0) add_row(c.G.row(r).data(), p[r], n, u_.data());
}

double ContactSolver::residual(const ContactProblem& c, const VectorXd& p, const VectorXd& u) {
  double most = 0;
  squares_ = 0;
  for (int i = 0; i < c.count; ++i) {
    const int row = 3 * i;
    const double own = c.G(row, row), across = std::max(c.G(row + 1, row + 1), c.G(row + 2, row + 2));
    if (own <= 0) continue;
    const double normal = std::max(0., p[row] - step_ * (u[row] - c.target[i]) / own);
    double off = std::abs(normal - p[row]) * own;
    squares_ += off * off;
    if (across > 0) {
      const Vector2d t = on_friction_cone(p.segment<2>(row + 1) - step_ * u.segment<2>(row + 1) / across,
                                          c.friction[i] * normal);
      const double friction_off = (t - p.segment<2>(row + 1)).norm() * across;
      squares_ += friction_off * friction_off;
      off = std::max(off, friction_off);
    }
    if (off > most) {
      most = off;
      worst_ = i;
    }
  }
  return most;
}

/// Projected Gauss-Seidel.
void ContactSolver::sweep(const ContactProblem& c, int times, VectorXd& p) {
  const int n = 3 * c.count;
  update_velocity(c, p);
  const auto move = [&](int row, double to) {
    const double by = to - p[row];
    if (by == 0) return;
    p[row] = to;
    add_row(c.G.row(row).data(), by, n, u_.data());
  };
  for (int pass = 0; pass < times; ++pass) {
    for (int i = 0; i < c.count; ++i) {
      const int row = 3 * i;
      if (c.G(row, row) <= 0) continue;
      move(row, std::max(0., p[row] - (u_[row] - c.target[i]) / c.G(row, row)));
      const double across = std::max(c.G(row + 1, row + 1), c.G(row + 2, row + 2));
      if (across <= 0) continue;
      const Vector2d t =
          on_friction_cone(p.segment<2>(row + 1) - u_.segment<2>(row + 1) / across, c.friction[i] * p[row]);
      move(row + 1, t[0]);
      move(row + 2, t[1]);
    }
  }
}

/// change_: from p to the solution of what the modes of p make linear. A contact that opens has none; of one
/// that touches u_n = target, of one that sticks u_t = 0, and of one that slides, with d = p_t - r u_t and a
/// = d / |d|,  p_t = mu p_n a + mu p_n / |d| (1 - a a^T) d.
bool ContactSolver::find_direction(const ContactProblem& c, const VectorXd& p, double damping) {
  const int n = 3 * c.count;
  rows_.clear();
  change_.head(n) = -p.head(n);
  struct Slide {
    double share, x, y;
  };
  const auto mode = [&](int i, double& limit, Vector2d& d) {
    const int row = 3 * i;
    const double own = c.G(row, row), across = std::max(c.G(row + 1, row + 1), c.G(row + 2, row + 2));
    const double normal = own > 0 ? p[row] - step_ * (u_[row] - c.target[i]) / own : 0;
    if (normal <= 0) return 0;
    if (across <= 0 || c.friction[i] == 0) return 1;
    limit = c.friction[i] * normal;
    d = p.segment<2>(row + 1) - step_ * u_.segment<2>(row + 1) / across;
    return d.squaredNorm() <= limit * limit ? 2 : 3;
  };
  double limit = 0;
  Vector2d d = Vector2d::Zero();
  for (int i = 0; i < c.count; ++i) {
    const int how = mode(i, limit, d);
    if (how == 0) continue;
    rows_.push_back(3 * i);
    for (int k = 1; k < 3 && how > 1; ++k)
      if (c.G(3 * i + k, 3 * i + k) > 0) rows_.push_back(3 * i + k);
  }
  const int m = int(rows_.size()), stride = (m + width) & ~(width - 1);
  if (m == 0) return true;
  numbers_.resize(std::size_t(m) * stride);
  ++solves_;
  const auto fill = [&](int k, double factor, int row) {  // factor * G.row(row)
    for (int j = 0; j < m; ++j) numbers_[k * stride + j] += factor * c.G(row, rows_[j]);
  };
  std::fill(numbers_.begin(), numbers_.end(), 0.);
  for (int k = 0; k < m; ++k) {
    const int row = rows_[k], i = row / 3;
    double& right = numbers_[k * stride + m];
    const double own = c.G(row, row);
    if (row % 3 == 0 || mode(i, limit, d) == 2) {
      fill(k, 1, row);
      numbers_[k * stride + k] += damping * own;
      right = (row % 3 == 0 ? c.target[i] : 0) - c.free[row] + damping * own * p[row];
      continue;
    }
    const double across = std::max(c.G(3 * i + 1, 3 * i + 1), c.G(3 * i + 2, 3 * i + 2));
    const double size = d.norm(), share = limit / size;
    const Vector2d a = d / size;
    const int here = row % 3 - 1;
    for (int j = 0; j < 2; ++j) {
      const int other = 3 * i + 1 + j;
      const double turn = share * ((here == j) - a[here] * a[j]);  // of share (1 - a a^T)
      if (turn != 0) {
        fill(k, turn, other);
        right -= turn * c.free[other];
      }
      const double own_part = across / step_ * ((here == j) - turn);
      for (int l = std::max(0, k - 1); l <= std::min(m - 1, k + 1); ++l)
        if (rows_[l] == other) numbers_[k * stride + l] += own_part;
    }
    for (int l = k - 1; l >= std::max(0, k - 2); --l)
      if (rows_[l] == 3 * i) numbers_[k * stride + l] -= across / step_ * c.friction[i] * a[here];
  }
  if (!eliminate(numbers_.data(), m, stride)) return false;
  for (int k = 0; k < m; ++k) {
    const double to = numbers_[k * stride + m];
    if (!std::isfinite(to)) return false;
    change_[rows_[k]] = to - p[rows_[k]];
  }
  return true;
}

/// What is left of the best that it came to, m/s; `p` is that.
double ContactSolver::newton(const ContactProblem& c, double scale, int most, VectorXd& p) {
  const double enough = settled * scale;
  const int n = 3 * c.count;
  update_velocity(c, p);
  double best = residual(c, p, u_), size = squares_;
  best_.head(n) = p.head(n);
  double damping = least_damping;
  // (one solve in any case, so that what rests is left no impulses but its own)
  for (int pass = 0, idle = 0;
       pass < most && best > (pass == 0 ? rounding * scale : enough) && damping < most_damping; ++pass) {
    if (best <= nearly * scale && ++idle > most_idle) break;
    if (!find_direction(c, p, damping)) break;
    change_velocity_.head(n).setZero();
    for (int r = 0; r < n; ++r)
      if (change_[r] != 0) add_row(c.G.row(r).data(), change_[r], n, change_velocity_.data());
    // (the first solves find the modes, and may lead away)
    double taken = 0, taken_size = pass < free_solves ? std::numeric_limits<double>::infinity() : size;
    for (double share = 1; share > 0.1 && taken == 0; share /= 2) {
      trial_.head(n) = p.head(n) + share * change_.head(n);
      trial_velocity_.head(n) = u_.head(n) + share * change_velocity_.head(n);
      residual(c, trial_, trial_velocity_);
      if (squares_ < taken_size) taken = share;
    }
    damping = taken < 1 ? 10 * damping : std::max(least_damping, damping / 100);
    if (taken == 0) continue;
    p.head(n) += taken * change_.head(n);
    update_velocity(c, p);
    const double left = residual(c, p, u_);
    size = squares_;
    if (left >= best) continue;
    if (left < 0.5 * best) idle = 0;
    best = left;
    best_.head(n) = p.head(n);
  }
  p.head(n) = best_.head(n);
  return best;
}

/// Each point solves the problem in which contacts also give way by a part alpha of their own response to
/// what their impulses differ from the point before; alpha falls while that succeeds. `p` ends at the best.
void ContactSolver::proximal_points(const ContactProblem& c, double scale, VectorXd& p) {
  const int n = 3 * c.count;
  soft_.count = c.count;
  if (soft_.free.size() < n) {
    soft_.G.resize(n, n);
    soft_.free.resize(n);
    soft_.target.resize(c.count);
  }
  soft_.G.topLeftCorner(n, n) = c.G.topLeftCorner(n, n);
  soft_.target.head(c.count) = c.target.head(c.count);
  soft_.friction.assign(c.friction.begin(), c.friction.begin() + c.count);
  double alpha = first_proximal, best = std::numeric_limits<double>::infinity();
  for (int point = 0, idle = 0; point < most_points; ++point) {
    for (int r = 0; r < n; ++r) {
      soft_.G(r, r) = (1 + alpha) * c.G(r, r);
      soft_.free[r] = c.free[r] - alpha * c.G(r, r) * p[r];
    }
    point_.head(n) = p.head(n);
    const bool solved = newton(soft_, scale, most_solves, p) <= nearly * scale;
    update_velocity(c, p);
    const double left = residual(c, p, u_);
    if (left < best) {
      if (left < 0.5 * best) idle = 0;
      best = left;
      best_point_.head(n) = p.head(n);
    }
    if (best <= settled * scale || (best <= nearly * scale && ++idle > most_idle)) break;
    if (!solved) p.head(n) = point_.head(n);
    alpha = solved ? std::max(alpha / 10, least_proximal) : std::min(10 * alpha, most_proximal);
  }
  p.head(n) = best_point_.head(n);
}

double ContactSolver::solve(const ContactProblem& c, double scale, VectorXd& p) {
  const Eigen::Index n = 3 * Eigen::Index(c.count);
  if (u_.size() < n)
    for (VectorXd* x : {&u_, &change_, &change_velocity_, &trial_, &trial_velocity_, &best_, &start_, &point_,
                        &best_point_})
      x->resize(n);
  start_.head(n) = p.head(n);
  double left = newton(c, scale, quick_solves, p), best = std::numeric_limits<double>::infinity();
  if (left > nearly * scale) p.head(n) = start_.head(n);
  for (const double step : projection_steps) {
    if (left <= nearly * scale) break;
    if (step != 1) sweep(c, sweeps_between, p);
    step_ = step;
    proximal_points(c, scale, p);
    step_ = 1;
    update_velocity(c, p);
    left = residual(c, p, u_);
    if (left < best) {
      best = left;
      start_.head(n) = p.head(n);  // (the start has served)
    }
  }
  if (best < left) p.head(n) = start_.head(n);
  for (int i = 0; i < c.count; ++i) {  // what Newton's method leaves of rounding outside of the laws' bounds
    p[3 * i] = std::max(0., p[3 * i]);
    p.segment<2>(3 * i + 1) = on_friction_cone(p.segment<2>(3 * i + 1), c.friction[i] * p[3 * i]);
  }
  update_velocity(c, p);
  left = residual(c, p, u_);
  return left / scale;
}

}  // namespace borelli
