#include "dynamics/contacts/contact_solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "dynamics/contacts/impact.hpp"
#include "dynamics/contacts/mixed_elimination.hpp"
#include "dynamics/numbers/lanes.hpp"
#include "dynamics/numbers/processor.hpp"

namespace borelli {

using Eigen::Vector2d;
using Eigen::VectorXd;

namespace {

// Newton's method may cycle between modes, so the number of solves is limited, per call and per proximal
// point. `most_idle`: consecutive solves that may fail to halve the residual; fewer once it is near enough.
constexpr int most_solves = 20, most_idle = 6, most_idle_near = 1;
// Sweeps before the first proximal point, and between restarts with another projection step.
constexpr int first_sweeps = 5, sweeps_between = 300;
constexpr double solver_rounding = 1e-14;  // relative to the velocities
// Iterations stop at a third of the accepted residual: the final projection onto the cones may add the rest.
constexpr double before_cones = 1. / 3;

// Step r of the projection, relative to that of one contact alone. The solution does not depend on r, but the
// path of Newton's method does.
constexpr double projection_steps[] = {1, 10, 0.1, 100};

// Damping of Newton's rows towards the current impulses, relative to a row's own response. The equations are
// off by the damping times the change of impulse, so converged impulses are exact. The first solves, which
// find the modes, use more: dependent contacts that contradict each other slightly then cannot drive each
// other far away.
constexpr double first_damping = 1e-2, damping_falls = 0.1, least_damping = 1e-5;

// The same for proximal points.
constexpr double first_proximal = 1e-2, least_proximal = 1e-6, most_proximal = 10;
constexpr double proximal_falls = 0.3, proximal_grows = 10;
constexpr int most_points = 60;

constexpr int block = Lanes::count;  // columns per block

/// Gathers chosen columns, in ascending order, from rows of n numbers, eight at a time.
template <int width>
class Columns {
 public:
  /// `picks`: scratch.
  Columns(const int* columns, int count, int n, std::vector<ColumnPick>& picks)
      : columns_(columns), count_(count), picks_(picks) {
    picks_.clear();
    for (int j = 0; j < count; j += block) {
      ColumnPick& pick = picks_.emplace_back();
      pick.first = std::min(columns[j], n - 2 * block);
      const int last = std::min(j + block, count) - 1;
      if (!in_registers_of_block || pick.first < 0 || columns[last] >= pick.first + 2 * block)
        pick.first = -1;
      else
        for (int i = j; i <= last; ++i) pick.each[i - j] = columns[i] - pick.first;
    }
  }

  /// Copies the chosen columns of a row, from number `begin` (a multiple of eight) on. Up to `block` - 1
  /// numbers behind the last may be overwritten.
  void copy(const double* from, int begin, double* to) const {
    for (int j = begin; j < count_; j += block) {
      const ColumnPick& pick = picks_[std::size_t(j / block)];
      if (pick.first < 0) {
        for (int i = j; i < std::min(j + block, count_); ++i) to[i] = from[columns_[i]];
        continue;
      }
      if constexpr (in_registers_of_block) {
        typename Register<width>::Words each;
        __builtin_memcpy(&each, pick.each, sizeof each);
        using Tile = LanesOf<width, width>;
        const double* const first = from + pick.first;
        Tile(__builtin_shuffle(Tile::load(first).vector(), Tile::load(first + block).vector(), each))
            .store(to + j);
      }
    }
  }

 private:
#ifdef BORELLI_REGISTERS
  static constexpr bool in_registers_of_block = width == block;  // one permutation per block
#else
  static constexpr bool in_registers_of_block = false;
#endif
  const int* columns_;
  int count_;
  std::vector<ColumnPick>& picks_;
};

/// Row length for n numbers that Columns can read in full blocks.
int row_room(int n) { return std::max(2 * block, n); }

/// u += by * row, n numbers.
BORELLI_INLINED_FOR_PROCESSOR
void add_row(const double* row, double by, int n, double* u) {
  for (int i = 0; i < n; ++i) u[i] += by * row[i];
}

/// u += G p for `tiles` registers of columns from `begin` on; the last register ends at column n at most.
template <int tiles, int width>
void add_tiles(const double* G, Eigen::Index stride, const double* p, int begin, int n, double* u) {
  using Tile = LanesOf<width, width>;
  int first[tiles];
  Tile sums[tiles];
  for (int t = 0; t < tiles; ++t) {
    first[t] = std::min(begin + t * width, n - width);
    sums[t] = Tile::load(u + first[t]);
  }
  for (int r = 0; r < n; ++r, G += stride)
    for (int t = 0; t < tiles; ++t) sums[t] += p[r] * Tile::load(G + first[t]);
  for (int t = 0; t < tiles; ++t) sums[t].store(u + first[t]);
}

/// u += G p, with G symmetric, n x n, in rows of `stride` numbers.
template <int width>
void add_product(const double* G, Eigen::Index stride, const double* p, int n, double* u) {
  constexpr int most = 8;  // registers at once
  if (n < width) {
    for (int r = 0; r < n; ++r)
      for (int i = 0; i < n; ++i) u[i] += p[r] * G[r * stride + i];
    return;
  }
  int begin = 0;
  // (Groups are of even size, so that the last holds a whole register and overwrites no earlier column.)
  for (int left = (n + width - 1) / width, groups = (left + most - 1) / most; groups > 0; --groups) {
    const int tiles = (left + groups - 1) / groups;
    [&]<int... count>(std::integer_sequence<int, count...>) {
      ((tiles == count + 1 ? add_tiles<count + 1, width>(G, stride, p, begin, n, u) : void()), ...);
    }
    (std::make_integer_sequence<int, most>());
    begin += tiles * width;
    left -= tiles;
  }
}

}  // namespace

/// u_ += G p.
void ContactSolver::add_impulses(const ContactProblem& c, const VectorXd& p) {
  in_registers(
      [&]<int width>() { add_product<width>(c.G.data(), c.G.cols(), p.data(), 3 * c.count, u_.data()); });
}

void ContactSolver::update_velocity(const ContactProblem& c, const VectorXd& p) {
  const int n = 3 * c.count;
  u_.head(n) = c.free.head(n);
  add_impulses(c, p);
}

void ContactSolver::find_responses(const ContactProblem& c) {
  responses_.clear();
  for (int i = 0; i < c.count; ++i) {
    const int row = 3 * i;
    const double own = c.G(row, row), x = c.G(row + 1, row + 1), y = c.G(row + 2, row + 2);
    const double across = std::max(x, y);
    responses_.push_back({{own, x, y}, across, step_ / own, step_ / across});
  }
}

/// Call find_responses first, as for find_direction.
double ContactSolver::residual(const ContactProblem& c, const VectorXd& p, const VectorXd& u) {
  double most = 0;  // squared
  worst_ = 0;
  for (int i = 0; i < c.count; ++i) {
    const int row = 3 * i;
    const Response& response = responses_[i];
    if (response.own[0] <= 0) continue;
    const double normal = std::max(0., p[row] - response.normal_step * (u[row] - c.target[i]));
    const double closes = (normal - p[row]) * response.own[0];
    double off = closes * closes;
    if (response.across > 0) {
      const Vector2d before(p[row + 1], p[row + 2]);
      const Vector2d to = on_friction_cone(before - response.across_step * Vector2d(u[row + 1], u[row + 2]),
                                           c.friction[i] * normal);
      off = std::max(off, (response.across * (to - before)).squaredNorm());
    }
    if (off > most) {
      most = off;
      worst_ = i;
    }
  }
  return std::sqrt(most);
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

/// Assembles and solves the equations of the current modes.
template <int width>
bool ContactSolver::solve_modes(const ContactProblem& c, int symmetric, int stride) {
  const int n = 3 * c.count, m = int(equations_.size()), slides = int(slides_.size());
  for (int i = 0; i < slides; ++i) {
    const Slide& slide = slides_[i];
    const double *x = c.G.row(slide.row + 1).data(), *y = c.G.row(slide.row + 2).data();
    double* __restrict across = turned_.row(i).data();
    for (int r = 0; r < n; ++r) across[r] = slide.x * x[r] + slide.y * y[r];
  }
  const Columns<width> columns(rows_.data(), symmetric, int(std::min(c.G.cols(), turned_.cols())), picks_);
  double* const numbers = numbers_.data()->each;
  const auto bring = [&](int k, double* row) __attribute__((always_inline)) {
    const Equation& equation = equations_[k];
    const double* const from =
        equation.slide < 0 ? c.G.row(rows_[k]).data() : turned_.row(equation.slide).data();
    if (k < symmetric) columns.copy(from, k & ~(block - 1), row);
    for (int i = 0; i < slides; ++i) {
      const Slide& slide = slides_[i];
      const double normal = from[slide.row], x = from[slide.row + 1], y = from[slide.row + 2];
      row[slide.unknown] = slide.x * x + slide.y * y;
      row[symmetric + i] = normal + slide.with_x * x + slide.with_y * y;
      row[m + 1 + i] = normal;
    }
    LanesOf<block, width>(0.).store(row + m + 1 + slides);
    row[k] += equation.gives;
    row[m] = equation.right;
  };
  double* const solution = numbers + m * stride;
  return eliminate_mixed<width>(numbers, symmetric, m, stride, solution + stride, solution, bring);
}

/// change_ <- Newton's step from p, linearised in the current modes. An open contact has no impulse. A closed
/// one has u_n = target, a sticking one also u_t = 0. A sliding one has, with d = p_t - r u_t and a = d /
/// |d|, p_t = mu p_n a + mu p_n / |d| (1 - a a^T) d. So a sliding contact has two unknowns: p_n, which
/// carries the friction mu p_n a, and the friction perpendicular to a.
bool ContactSolver::find_direction(const ContactProblem& c, const VectorXd& p, double damping) {
  const int n = 3 * c.count;
  rows_.clear();
  equations_.clear();
  slides_.clear();
  change_.head(n) = -p.head(n);
  const auto hold = [&](int row, double own, double target) {
    const double gives = damping * own;
    rows_.push_back(row);
    equations_.push_back({gives, target - c.free[row] + gives * p[row]});
  };
  for (int i = 0; i < c.count; ++i) {
    const int row = 3 * i;
    const Response& response = responses_[i];
    const double across = response.across;
    const double normal = response.own[0] > 0 ? p[row] - response.normal_step * (u_[row] - c.target[i]) : 0;
    if (normal <= 0) continue;
    const double limit = c.friction[i] * normal;
    if (limit > 0 && across > 0) {
      const Vector2d d(p[row + 1] - response.across_step * u_[row + 1],
                       p[row + 2] - response.across_step * u_[row + 2]);
      if (const double squared = d.squaredNorm(); squared > limit * limit) {
        const double size = std::sqrt(squared), x = d[0] / size, y = d[1] / size, near = damping * across;
        rows_.push_back(row + 1);
        equations_.push_back(
            {across / step_ * std::max(0., size - limit) / limit + near,
             y * (c.free[row + 1] - near * p[row + 1]) - x * (c.free[row + 2] - near * p[row + 2]),
             int(slides_.size())});
        slides_.push_back({row, int(rows_.size()) - 1, c.friction[i] * x, c.friction[i] * y, -y, x});
        continue;
      }
    }
    hold(row, response.own[0], c.target[i]);
    for (int r : {1, 2})
      if (limit > 0 && response.own[r] > 0) hold(row + r, response.own[r], 0);
  }
  const int symmetric = int(rows_.size());
  for (const Slide& slide : slides_)
    hold(slide.row, responses_[slide.row / 3].own[0], c.target[slide.row / 3]);
  const int m = int(rows_.size()), stride = (m + int(slides_.size()) + block) & ~(block - 1);
  if (m == 0) return true;
  static_assert(sizeof(Line) == block * sizeof(double));
  if (const std::size_t room = std::size_t(m + 2) * stride / block + symmetric + 1; numbers_.size() < room)
    numbers_.resize(room);
  ++solves_;
  if (turned_.rows() < int(slides_.size()) || turned_.cols() < n) turned_.resize(c.count, row_room(n));
  if (!in_registers([&]<int width>() { return solve_modes<width>(c, symmetric, stride); })) return false;
  const double* const solution = numbers_.data()->each + m * stride;
  for (int k = 0; k < m; ++k) {
    if (!std::isfinite(solution[k])) return false;
    const int slide = equations_[k].slide;
    change_[rows_[k]] += (slide < 0 ? 1 : slides_[slide].x) * solution[k];
    if (slide >= 0) change_[rows_[k] + 1] += slides_[slide].y * solution[k];
  }
  for (std::size_t k = 0; k < slides_.size(); ++k) {
    change_[slides_[k].row + 1] += slides_[k].with_x * solution[symmetric + int(k)];
    change_[slides_[k].row + 2] += slides_[k].with_y * solution[symmetric + int(k)];
  }
  return true;
}

/// Newton's method, down to a residual of `enough` (m/s). `p` becomes the best iterate; returns its residual,
/// m/s.
double ContactSolver::newton(const ContactProblem& c, double scale, double enough, double damping,
                             VectorXd& p) {
  const int n = 3 * c.count;
  find_responses(c);
  update_velocity(c, p);
  double best = residual(c, p, u_);
  best_.head(n) = p.head(n);
  // (At least one solve unless the residual is rounding, so that contacts at rest get exact impulses.)
  for (int pass = 0, idle = 0; pass < most_solves && best > (pass == 0 ? solver_rounding * scale : enough);
       ++pass) {
    if (++idle > (best <= near_ ? most_idle_near : most_idle)) break;
    if (!find_direction(c, p, damping)) break;
    damping = std::max(std::min(least_damping, damping), damping_falls * damping);
    p.head(n) += change_.head(n);
    add_impulses(c, change_);
    const double left = residual(c, p, u_);
    if (left >= best) continue;
    if (left < 0.5 * best) idle = 0;
    best = left;
    best_.head(n) = p.head(n);
  }
  p.head(n) = best_.head(n);
  return best;
}

/// Each proximal point solves a regularised problem: every row yields by alpha times its own response to its
/// change of impulse since the previous point. alpha falls while this succeeds. `p` becomes the best point.
void ContactSolver::proximal_points(const ContactProblem& c, double scale, VectorXd& p) {
  const int n = 3 * c.count;
  soft_.count = c.count;
  if (soft_.free.size() < n) {
    soft_.G.resize(n, row_room(n));
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
    if (point == 0) sweep(soft_, first_sweeps, p);
    // (Solve each point to two thirds of the best residual so far, no further.)
    const double enough = std::max(2. / 3 * std::min(best, scale), settled * scale);
    const bool solved = newton(soft_, scale, enough, 0, p) <= std::max(enough, near_);
    find_responses(c);
    update_velocity(c, p);
    const double left = residual(c, p, u_);
    if (left < best) {
      if (left < 0.5 * best) idle = 0;
      best = left;
      best_point_.head(n) = p.head(n);
    }
    if (best <= settled * scale || (best <= near_ && ++idle > most_idle_near)) break;
    if (!solved) p.head(n) = point_.head(n);
    alpha = solved ? std::max(proximal_falls * alpha, least_proximal)
                   : std::min(proximal_grows * alpha, most_proximal);
  }
  p.head(n) = best_point_.head(n);
}

double ContactSolver::solve(const ContactProblem& c, double scale, VectorXd& p, double enough) {
  const Eigen::Index n = 3 * Eigen::Index(c.count);
  near_ = before_cones * enough * scale;
  if (u_.size() < n)
    for (VectorXd* x : {&u_, &change_, &best_, &best_of_all_, &point_, &best_point_}) x->resize(n);
  double left = newton(c, scale, settled * scale, first_damping, p), best = left;
  if (left > near_) best_of_all_.head(n) = p.head(n);
  for (const double step : projection_steps) {
    if (left <= near_) break;
    if (step != 1) sweep(c, sweeps_between, p);
    step_ = step;
    proximal_points(c, scale, p);
    step_ = 1;
    find_responses(c);
    update_velocity(c, p);
    left = residual(c, p, u_);
    if (left < best) {
      best = left;
      best_of_all_.head(n) = p.head(n);
    }
  }
  if (best < left) p.head(n) = best_of_all_.head(n);
  for (int i = 0; i < c.count; ++i) {  // remove Newton's rounding outside the cones
    p[3 * i] = std::max(0., p[3 * i]);
    p.segment<2>(3 * i + 1) = on_friction_cone(p.segment<2>(3 * i + 1), c.friction[i] * p[3 * i]);
  }
  update_velocity(c, p);
  left = residual(c, p, u_);
  return left / scale;
}

}  // namespace borelli
