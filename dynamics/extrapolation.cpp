#include "dynamics/extrapolation.hpp"

#include <algorithm>
#include <cmath>

#include "dynamics/processor.hpp"

namespace borelli {

namespace {

// a slope bends so many times more over one substep than over any other where it leaps there
constexpr double leap = 8;

// what eight slopes side by side cost beside one: by measurement 1.4 for chains, 2.6 for a body with limbs
constexpr double cost_of_lanes = 2;

/// Readies the midpoint rule in every lane, by its own substep.
BORELLI_LANES_FOR_PROCESSOR
void begin_rows(const Eigen::VectorXd& y, const Eigen::VectorXd& dy, const Lanes& substep, Lanes* before,
                Lanes* now, Lanes* slope) {
  for (Eigen::Index i = 0; i < y.size(); ++i) {
    before[i] = y[i];
    now[i] = y[i] + substep * dy[i];
    slope[i] = dy[i];
  }
}

/// A substep of the midpoint rule in every lane, with the slope at `now`: before <- now's successor.
BORELLI_LANES_FOR_PROCESSOR
void go_on(Eigen::Index size, const Lanes& two_substeps, const Lanes* slope, Lanes* before) {
  for (Eigen::Index i = 0; i < size; ++i) before[i] += two_substeps * slope[i];
}

/// The second differences of the slope: the first ones, or the largest of the others.
BORELLI_LANES_FOR_PROCESSOR
void find_bends(Eigen::Index size, bool first, const Lanes* slope, const Lanes* before,
                const Lanes* before_that, Lanes* bend) {
  for (Eigen::Index i = 0; i < size; ++i) {
    const Lanes bends = abs(slope[i] - 2 * before[i] + before_that[i]);
    bend[i] = first ? bends : choose(bend[i] < bends, bends, bend[i]);
  }
}

}  // namespace

Extrapolation::Extrapolation(double tolerance) : Extrapolation(tolerance, 0) {}

Extrapolation::Extrapolation(double tolerance, int rows)
    : tolerance_(tolerance),
      fixed_rows_(rows),
      table_(most_rows),
      work_(most_rows + 1),
      step_(most_rows + 1),
      error_(most_rows + 1) {
  rows_.ends.resize(most_rows);
  work_side_by_side(false);
  reset();
}

/// Sets what rows take, with the slope at the start.
void Extrapolation::work_side_by_side(bool side_by_side) {
  side_by_side_ = side_by_side;
  work_[0] = 1;
  for (int row = 1; row <= most_rows; ++row)
    work_[row] = side_by_side ? 1 + cost_of_lanes * (substeps(row) - 1) : work_[row - 1] + substeps(row) - 1;
}

void Extrapolation::reset() {
  // a digit or two per row, as the book's program has it
  target_ = fixed_rows_ > 0 ? fixed_rows_
                            : std::clamp(int(1.5 - 0.6 * std::log10(tolerance_)), least_target, most_target);
  rejected_ = false;
}

/// now_ <- the midpoint rule with the row's substeps. False: not evaluable.
bool Extrapolation::make_row(Flow& flow, double t, double h, const Eigen::VectorXd& y,
                             const Eigen::VectorXd& dy, int row) {
  const int count = substeps(row);
  const double substep = h / count;
  before_ = y;
  now_ = y + substep * dy;
  slope_ = dy;
  bend_.setZero(y.size());
  for (int i = 1; i < count; ++i) {
    slope_before_that_.swap(slope_before_);
    slope_before_.swap(slope_);
    if (!flow.derivative(t + i * substep, now_, slope_)) return false;
    if (i == 2) first_bend_ = (slope_ - 2 * slope_before_ + slope_before_that_).cwiseAbs();
    if (i > 2) bend_ = bend_.cwiseMax((slope_ - 2 * slope_before_ + slope_before_that_).cwiseAbs());
    next_ = before_ + 2 * substep * slope_;
    before_.swap(now_);
    now_.swap(next_);
  }
  return true;
}

/// The midpoint rule with the substeps of `rows` rows at once. False: not evaluable.
bool Extrapolation::make_rows(Flow& flow, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                              int rows) {
  const Eigen::Index size = y.size();
  Rows& r = rows_;
  for (Eigen::VectorX<Lanes>* numbers :
       {&r.before, &r.now, &r.slope, &r.slope_before, &r.slope_before_that, &r.first_bend, &r.bend})
    numbers->resize(size);
  Lanes substep = 0;  // of lanes without a row
  for (int row = 1; row <= rows; ++row) substep.set(row - 1, h / substeps(row));
  begin_rows(y, dy, substep, r.before.data(), r.now.data(), r.slope.data());
  for (int i = 1; i < substeps(rows); ++i) {
    r.slope_before_that.swap(r.slope_before);
    r.slope_before.swap(r.slope);
    if (!flow.derivatives(r.now, rows - i / 2, r.slope)) return false;
    if (i > 1)
      find_bends(size, i <= 3, r.slope.data(), r.slope_before.data(), r.slope_before_that.data(),
                 i == 2 ? r.first_bend.data() : r.bend.data());
    go_on(size, 2 * substep, r.slope.data(), r.before.data());
    r.before.swap(r.now);
    if (i % 2 == 0) continue;
    // a row is done; its lane stays at the start from now on
    const int lane = i / 2;
    Eigen::VectorXd& end = r.ends[lane];
    end.resize(size);
    for (Eigen::Index c = 0; c < size; ++c) {
      end[c] = r.now[c][lane];
      r.now[c].set(lane, y[c]);
      r.before[c].set(lane, y[c]);
    }
    substep.set(lane, 0);
  }
  // of the last row, what leaps_at_an_end() looks at
  const auto take = [&](const Eigen::VectorX<Lanes>& from, Eigen::VectorXd& to) {
    to.resize(size);
    for (Eigen::Index c = 0; c < size; ++c) to[c] = from[c][rows - 1];
  };
  take(r.slope, slope_);
  take(r.slope_before, slope_before_);
  take(r.first_bend, first_bend_);
  take(r.bend, bend_);
  return true;
}

/// The extrapolation from the row in now_ and those before; then the row's error and the step that would
/// bring it to the tolerance. False: not finite.
bool Extrapolation::extrapolate(const Eigen::VectorXd& scale, double h, int row) {
  const int count = substeps(row);
  // Aitken and Neville: now_ passes along the row, table_ keeps the row before until it is replaced
  for (int column = 1; column < row; ++column) {
    const double ratio = double(count) / substeps(row - column);
    next_ = now_ + (now_ - table_[column - 1]) / (ratio * ratio - 1);
    table_[column - 1].swap(now_);
    now_.swap(next_);
  }
  table_[row - 1] = now_;
  if (row == 1) return now_.allFinite();

  double error = 0;
  for (Eigen::Index i = 0; i < now_.size(); ++i)
    if (const double part = std::abs(now_[i] - table_[row - 2][i]) / scale[i]; !(part <= error)) {
      error = part;
      worst_ = int(i);
    }
  error_[row] = error / tolerance_;
  if (!std::isfinite(error_[row])) return false;
  const double power = 1.0 / (2 * row - 1), least = std::pow(0.02, power);
  const double factor = 0.94 * std::pow(0.65 / std::max(error_[row], 1e-300), power);
  step_[row] = h * std::clamp(factor, least / 4, 1 / least);
  return true;
}

/// Whether the slope, being next_ at the step's end, leaps within the first or the last substep of the last
/// row by what would make an error.
bool Extrapolation::leaps_at_an_end(const Eigen::VectorXd& scale, double substep) const {
  for (Eigen::Index i = 0; i < next_.size(); ++i) {
    const double first = first_bend_[i], last = std::abs(next_[i] - 2 * slope_[i] + slope_before_[i]);
    const double most = std::max(first, last), other = std::max(std::min(first, last), bend_[i]);
    if (!(most <= leap * other) && !(0.5 * substep * most <= tolerance_ * scale[i])) return true;
  }
  return false;
}

/// Target and step after a step that was accepted (or, in the last row, refused) in `row`.
void Extrapolation::choose_after(int row, Attempt& attempt, double h) {
  if (fixed_rows_ > 0) {
    attempt.next_step = attempt.accepted && rejected_ ? std::min(step_[row], h) : step_[row];
    rejected_ = !attempt.accepted;
    return;
  }
  const auto per_time = [&](int r) { return work_[r] / step_[r]; };
  const int target = target_;
  int next;
  if (row < target)
    next = per_time(row) < 0.9 * per_time(row - 1) ? target : row;
  else if (row == target)
    next = per_time(row - 1) < 0.9 * per_time(row)   ? row - 1
           : per_time(row) < 0.9 * per_time(row - 1) ? row + 1
                                                     : row;
  else {
    next = per_time(target - 1) < 0.9 * per_time(target) ? target - 1 : target;
    if (per_time(row) < 0.9 * per_time(next)) next = row;
  }
  if (!attempt.accepted) next = std::min(next, target);
  target_ = std::clamp(next, least_target, most_target);
  // after a rejection neither order nor step may grow at once
  if (attempt.accepted && rejected_) target_ = std::min(target_, std::max(row, least_target));
  double step = target_ <= row ? step_[target_] : step_[row] * work_[target_] / work_[row];
  if (attempt.accepted && rejected_) step = std::min(step, h);
  rejected_ = !attempt.accepted;
  attempt.next_step = step;
}

Attempt Extrapolation::attempt(Flow& flow, double t, double h, const Eigen::VectorXd& y,
                               const Eigen::VectorXd& dy, Eigen::VectorXd& out) {
  Attempt attempt;
  // (of few rows, a scalar each is as cheap)
  const bool side_by_side =
      flow.has_lanes() &&
      (fixed_rows_ == 0 || cost_of_lanes * (substeps(fixed_rows_) - 1) < fixed_rows_ * fixed_rows_);
  if (side_by_side != side_by_side_) work_side_by_side(side_by_side);
  const int target = target_, last = fixed_rows_ > 0 || side_by_side ? target : target + 1;
  const double first = substeps(1), after = substeps(target + 1);
  bool made = !side_by_side || make_rows(flow, h, y, dy, target);
  for (int row = 1; row <= last; ++row) {
    if (!side_by_side)
      made = make_row(flow, t, h, y, dy, row);
    else if (made)
      now_ = rows_.ends[row - 1];
    if (!made || !extrapolate(flow.error_scale(), h, row)) {
      rejected_ = true;
      return {.evaluated = false, .accepted = false, .next_step = 0.25 * h};
    }
    if (row < last && (last == target || row < target - 1)) continue;
    attempt.worst = worst_;
    attempt.accepted = error_[row] <= 1;
    // what the rows to come would gain at best, as the convergence monitor of the book has it
    const double hope = row == target - 1 ? std::pow(after * substeps(target) / (first * first), 2)
                        : row == target   ? std::pow(after / first, 2)
                                          : 1;
    if (attempt.accepted || error_[row] > hope || row == last) {
      out = table_[row - 1];
      if (attempt.accepted) {
        if (!flow.derivative(t + h, out, next_)) {
          rejected_ = true;
          return {.evaluated = false, .accepted = false, .next_step = 0.25 * h};
        }
        if (leaps_at_an_end(flow.error_scale(), h / substeps(row))) {
          rejected_ = true;
          return {.accepted = false, .next_step = 0.5 * h, .worst = worst_};
        }
      }
      choose_after(row, attempt, h);
      if (!attempt.accepted) attempt.next_step = std::min(attempt.next_step, 0.9 * h);
      rows_made_ = row;
      return attempt;
    }
  }
  return attempt;
}

bool Extrapolation::shortened(Flow& flow, double t, double h, const Eigen::VectorXd& y,
                              const Eigen::VectorXd& dy, Eigen::VectorXd& out) {
  if (side_by_side_ && !make_rows(flow, h, y, dy, rows_made_)) return false;
  for (int row = 1; row <= rows_made_; ++row) {
    if (side_by_side_)
      now_ = rows_.ends[row - 1];
    else if (!make_row(flow, t, h, y, dy, row))
      return false;
    if (!extrapolate(flow.error_scale(), h, row)) return false;
  }
  out = table_[rows_made_ - 1];
  return true;
}

}  // namespace borelli
