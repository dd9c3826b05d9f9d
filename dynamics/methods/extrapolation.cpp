#include "dynamics/methods/extrapolation.hpp"

#include <algorithm>
#include <cmath>

#include "dynamics/numbers/exceeds.hpp"
#include "dynamics/numbers/processor.hpp"

namespace borelli {

namespace {

// The slope jumps in a substep if its second difference there exceeds this multiple of those elsewhere.
constexpr double leap = 8;

// Ratio of second to first differences of the slope: 2 if it alternates with the substeps, 1 at a jump, small
// if smooth.
constexpr double rattle = 1.5;

// Cost of four slopes in lanes relative to one slope; orders and times hardly depend on it from 0.7 to 2.2.
constexpr double cost_of_lanes = 1.5;

/// Starts the midpoint rule in every lane with its own substep.
BORELLI_INLINED_FOR_PROCESSOR
void begin_rows(const Eigen::VectorXd& y, const Eigen::VectorXd& dy, const Quad& substep, Quad* before,
                Quad* now) {
  for (Eigen::Index i = 0; i < y.size(); ++i) {
    before[i] = y[i];
    now[i] = y[i] + substep * dy[i];
  }
}

/// One substep of the midpoint rule in every lane: `before` <- the state after the one with this slope.
BORELLI_INLINED_FOR_PROCESSOR
void make_substep(Eigen::Index size, const Quad& substep, const Quad* slope, Quad* before) {
  for (Eigen::Index i = 0; i < size; ++i) before[i] += 2 * substep * slope[i];
}

}  // namespace

Extrapolation::Extrapolation(double tolerance) : Extrapolation(tolerance, 0) {}

Extrapolation::Extrapolation(double tolerance, int rows)
    : tolerance_(tolerance),
      fixed_rows_(rows),
      table_(most_rows),
      work_(most_rows + 1),
      step_(most_rows + 1),
      error_(most_rows + 1),
      least_factor_(most_rows + 1),
      ends_(most_rows + 1) {
  for (int row = 1; row <= most_rows; ++row) least_factor_[row] = std::pow(0.02, 1.0 / (2 * row - 1));
  work_side_by_side(false);
  reset();
}

/// Sets the cost of the rows in slopes, including the slope at the start.
void Extrapolation::work_side_by_side(bool side_by_side) {
  side_by_side_ = side_by_side;
  work_[0] = 1;
  for (int row = 1; row <= most_rows; ++row)
    work_[row] = side_by_side ? 1 + cost_of_lanes * (substeps(row) - 1) : work_[row - 1] + substeps(row) - 1;
}

void Extrapolation::reset() {
  // One or two digits per row, as in the program of the book.
  target_ = fixed_rows_ > 0 ? fixed_rows_
                            : std::clamp(int(1.5 - 0.6 * std::log10(tolerance_)), least_target, most_target);
  rejected_ = false;
}

/// now_ <- the midpoint rule with the row's substeps. Returns false if f could not be evaluated.
bool Extrapolation::make_row(Flow& flow, double t, double h, const Eigen::VectorXd& y,
                             const Eigen::VectorXd& dy, int row) {
  const int count = substeps(row);
  const double substep = h / count;
  before_ = y;
  now_ = y + substep * dy;
  slope_ = dy;
  bend_.setZero(y.size());
  change_.setZero(y.size());
  for (int i = 1; i < count; ++i) {
    slope_before_that_.swap(slope_before_);
    slope_before_.swap(slope_);
    if (!flow.derivative(t + i * substep, now_, slope_)) return false;
    note_bend(i);
    next_ = before_ + 2 * substep * slope_;
    before_.swap(now_);
    now_.swap(next_);
  }
  return true;
}

/// Distributes rows over lanes: the longest rows first, each to the lane that is free first.
Extrapolation::Shares Extrapolation::share(int rows) {
  Shares out;
  int taken[Quad::count] = {}, last[Quad::count] = {};
  for (int row = rows; row > 0; --row) {
    const auto lane = std::min_element(std::begin(taken), std::end(taken)) - std::begin(taken);
    (last[lane] > 0 ? out.follower[last[lane]] : out.first[lane]) = row;
    last[lane] = row;
    taken[lane] += substeps(row) - 1;  // the slope at the start is known
  }
  out.slopes = *std::max_element(std::begin(taken), std::end(taken));
  return out;
}

/// ends_ <- the midpoint rule for each of `rows` rows. Returns false if f could not be evaluated.
bool Extrapolation::make_rows(Flow& flow, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                              int rows) {
  const Eigen::Index size = y.size();
  const Shares shares = share(rows);
  int row[Quad::count], made[Quad::count];  // per lane: its current row, and the substeps made of it
  Quad substep = 0;                         // zero in a finished lane, which stays at the start
  int working = 0;
  const auto begin_row = [&](int lane, int next) {
    row[lane] = next;
    made[lane] = 1;
    substep.set(lane, next > 0 ? h / substeps(next) : 0);
    working += next > 0;
  };
  for (int lane = 0; lane < Quad::count; ++lane) begin_row(lane, shares.first[lane]);
  for (Eigen::VectorX<Quad>* numbers : {&before_lanes_, &now_lanes_, &slope_lanes_}) numbers->resize(size);
  begin_rows(y, dy, substep, before_lanes_.data(), now_lanes_.data());
  slope_ = dy;
  bend_.setZero(size);
  change_.setZero(size);
  for (int i = 1; i <= shares.slopes; ++i) {
    if (!flow.derivatives(now_lanes_, working, slope_lanes_)) return false;
    if (i < substeps(rows)) {  // the first lane makes the last row, which leaps_or_rattles() checks
      slope_before_that_.swap(slope_before_);
      slope_before_.swap(slope_);
      slope_.resize(size);
      for (Eigen::Index c = 0; c < size; ++c) slope_[c] = slope_lanes_[c][0];
      note_bend(i);
    }
    make_substep(size, substep, slope_lanes_.data(), before_lanes_.data());
    before_lanes_.swap(now_lanes_);
    for (int lane = 0; lane < Quad::count; ++lane) {
      if (row[lane] == 0 || ++made[lane] < substeps(row[lane])) continue;
      Eigen::VectorXd& end = ends_[row[lane]];
      end.resize(size);
      --working;
      begin_row(lane, shares.follower[row[lane]]);
      for (Eigen::Index c = 0; c < size; ++c) {
        end[c] = now_lanes_[c][lane];
        before_lanes_[c].set(lane, y[c]);
        now_lanes_[c].set(lane, y[c] + substep[lane] * dy[c]);
      }
    }
  }
  return true;
}

/// Updates the differences of slopes after the i-th slope of a row.
void Extrapolation::note_bend(int i) {
  if (i > 1) change_ = change_.cwiseMax((slope_ - slope_before_).cwiseAbs());
  if (i == 2) first_bend_ = (slope_ - 2 * slope_before_ + slope_before_that_).cwiseAbs();
  if (i > 2) bend_ = bend_.cwiseMax((slope_ - 2 * slope_before_ + slope_before_that_).cwiseAbs());
}

/// Extrapolates from the row in now_ and the previous rows. For the last rows, finds the error and the step
/// for the target error. Returns false if not finite.
bool Extrapolation::extrapolate(const Eigen::VectorXd& scale, double h, int row) {
  const int count = substeps(row);
  // Aitken-Neville: now_ passes along the row; table_ holds the previous row until it is overwritten.
  for (int column = 1; column < row; ++column) {
    const double ratio = double(count) / substeps(row - column);
    next_ = now_ + (1 / (ratio * ratio - 1)) * (now_ - table_[column - 1]);
    table_[column - 1].swap(now_);
    now_.swap(next_);
  }
  table_[row - 1] = now_;
  if (row < std::max(2, target_ - 2)) return now_.allFinite();  // such a row sets neither step nor order

  double error = 0;
  for (Eigen::Index i = 0; i < now_.size(); ++i)
    if (const double part = std::abs(now_[i] - table_[row - 2][i]) / scale[i]; exceeds(part, error)) {
      error = part;
      worst_ = int(i);
    }
  error_[row] = error / tolerance_;
  if (!std::isfinite(error_[row])) return false;
  const double factor = 0.94 * std::pow(0.65 / std::max(error_[row], 1e-300), 1.0 / (2 * row - 1));
  step_[row] = h * std::clamp(factor, least_factor_[row] / 4, 1 / least_factor_[row]);
  return true;
}

/// Whether the slope jumps within the first or last substep of the last row by enough to cause an error, or
/// alternates from substep to substep. (Even and odd states of a row, each made from the slopes of the other,
/// have then separated; beside a kink all rows may do so alike.) next_ is the slope at the step's end.
bool Extrapolation::leaps_or_rattles(const Eigen::VectorXd& scale, double substep) const {
  for (Eigen::Index i = 0; i < next_.size(); ++i) {
    const double first = first_bend_[i], last = std::abs(next_[i] - 2 * slope_[i] + slope_before_[i]);
    const double most = std::max(first, last), other = std::max(std::min(first, last), bend_[i]);
    const bool leaps = !(most <= leap * other), rattles = !(bend_[i] <= rattle * change_[i]);
    if ((leaps || rattles) && !(0.5 * substep * std::max(most, bend_[i]) <= tolerance_ * scale[i]))
      return true;
  }
  return false;
}

/// Chooses target row and step after a step accepted in `row`, or rejected in the last row.
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
  // Right after a rejection, neither order nor step may grow.
  if (attempt.accepted && rejected_) target_ = std::min(target_, std::max(row, least_target));
  double step = target_ <= row ? step_[target_] : step_[row] * work_[target_] / work_[row];
  if (attempt.accepted && rejected_) step = std::min(step, h);
  rejected_ = !attempt.accepted;
  attempt.next_step = step;
}

Attempt Extrapolation::attempt(Flow& flow, double t, double h, const Eigen::VectorXd& y,
                               const Eigen::VectorXd& dy, Eigen::VectorXd& out) {
  Attempt attempt;
  // With few rows, one state at a time is as cheap.
  const bool side_by_side =
      (fixed_rows_ == 0 || cost_of_lanes * (substeps(fixed_rows_) - 1) < fixed_rows_ * fixed_rows_) &&
      flow.has_lanes();
  if (side_by_side != side_by_side_) work_side_by_side(side_by_side);
  const int target = target_, last = fixed_rows_ > 0 || side_by_side ? target : target + 1;
  const double first = substeps(1), after = substeps(target + 1);
  bool made = !side_by_side || make_rows(flow, h, y, dy, target);
  for (int row = 1; row <= last; ++row) {
    if (!side_by_side)
      made = make_row(flow, t, h, y, dy, row);
    else if (made)
      now_ = ends_[row];
    if (!made || !extrapolate(flow.error_scale(), h, row)) {
      rejected_ = true;
      return {.evaluated = false, .accepted = false, .next_step = 0.25 * h};
    }
    if (row < last && (last == target || row < target - 1)) continue;
    attempt.worst = worst_;
    attempt.accepted = error_[row] <= 1;
    // Best possible gain of the remaining rows, as in the convergence monitor of the book.
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
        if (leaps_or_rattles(flow.error_scale(), h / substeps(row))) {
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
      now_ = ends_[row];
    else if (!make_row(flow, t, h, y, dy, row))
      return false;
    if (!extrapolate(flow.error_scale(), h, row)) return false;
  }
  out = table_[rows_made_ - 1];
  return true;
}

}  // namespace borelli
