#include "dynamics/equations/constraint_solver.hpp"

#include <algorithm>
#include <functional>
#include <numeric>

#include "dynamics/equations/branch_sparse.hpp"

namespace borelli {

namespace {

// Marks a squared remainder as out of date: it is computed at the next use.
constexpr double unknown = -1;

double known_left(const BlockRows& W, int row, double& left) {
  if (left == unknown) left = W.squared_norm(row);
  return left;
}

}  // namespace

ConstraintSolver::ConstraintSolver(const System& system)
    : system_(system),
      order_(system.rows),
      scale_(Eigen::VectorXd::Zero(system.rows)),
      length_(scale_),
      longest_(scale_),
      unit_(system),
      W_(0, system.nv),
      basis_(W_),
      left_(scale_),
      unit_multipliers_(scale_),
      rest_(scale_),
      pivot_(Eigen::VectorXd::Zero(std::min(system.rows, system.nv))),
      largest_(pivot_),
      z_(pivot_),
      s_(z_),
      y_(Eigen::VectorXd::Zero(W_.padded_columns())) {
  std::iota(order_.begin(), order_.end(), 0);
}

void ConstraintSolver::prepare(const Rows& L, const Rows& F, bool decide, RowSet set) {
  const auto present = [this] { return system_.rows - (scale_.array() == 0).count(); };
  const auto before = present();
  for (int r = 0; r < system_.rows; ++r) {
    const std::span<const int> columns = unit_.columns(r);
    double* row = unit_.row(r);
    double largest = 0;
    length_[r] = 0;
    for (std::size_t i = 0; i < columns.size(); ++i) {
      row[i] = L(r, columns[i]);
      largest = std::max(largest, std::abs(row[i]));
      length_[r] += std::abs(row[i]) * system_.velocity_scale[columns[i]];
    }
    // Entries are lengths or pure numbers; entries of the size of rounding count as zero.
    const bool left_out = set == RowSet::positions && system_.kinematic_rows[r];
    if (left_out || largest <= 1e-13 * std::max(1.0, system_.length)) {
      unit_.clear(r);
      scale_[r] = 0;
      continue;
    }
    unit_.measure(system_, F, r);
    double square = 0;
    for (std::size_t i = 0; i < columns.size(); ++i) square += row[i] * row[i];
    scale_[r] = 1 / std::sqrt(square);
    // The direction of a row that has nearly vanished (a slider at its crank's dead point) is rounding.
    if (remembered_ >= 0 && length_[r] < longest_[r]) scale_[r] *= length_[r] / longest_[r];
    for (std::size_t i = 0; i < columns.size(); ++i) row[i] *= scale_[r];
  }
  // Dependent rows usually stay dependent, so the Gram matrix is not tried again for them.
  factored_ = (healthy_ || (decide && present() != before)) && eliminate(decide);
  if (!factored_) orthonormalise(decide);
  if (decide) healthy_ = rank_ == present();
}

void ConstraintSolver::begin(bool decide) {
  if (!decide) return;
  std::iota(order_.begin(), order_.end(), 0);
  rank_ = int(pivot_.size());
  nearness_ = 1;
}

/// Factors the rows by their Gram matrix. Returns false if a row is too close to the others for it, and
/// nothing is decided.
bool ConstraintSolver::eliminate(bool decide) {
  unit_.multiply(decide);
  begin(decide);
  for (int k = 0; k < rank_; ++k) {
    if (decide) {
      const int next = unit_.next();
      if (next < 0) return false;
      if (is_empty(next)) {  // so are all remaining rows
        rank_ = k;
        break;
      }
      order_[k] = next;
    }
    const int row = order_[k];
    const double left = unit_.left(row);
    if (!(left >= healthy_distance * healthy_distance)) return false;
    if (decide) {
      pivot_[k] = std::sqrt(left);
      if (!counts(k, pivot_[k])) return false;
    }
    unit_.eliminate(row);
  }
  if (decide)
    for (int row = 0, k = rank_; row < system_.rows; ++row)
      if (unit_.left(row) != SparseRows::gone) order_[k++] = row;
  return std::all_of(order_.begin() + rank_, order_.end(), [&](int row) { return is_empty(row); });
}

/// Factors the rows with an orthonormal basis.
void ConstraintSolver::orthonormalise(bool decide) {
  if (W_.rows() < system_.rows) {  // allocated only when the Gram matrix fails
    W_ = BlockRows(system_.rows, system_.nv);
    basis_ = BlockRows(pivot_.size(), system_.nv);
    R_.resize(system_.rows, pivot_.size());
    G_.resize(pivot_.size(), pivot_.size());
  }
  for (int r = 0; r < system_.rows; ++r) {
    W_.clear(r);
    const std::span<const int> columns = unit_.columns(r);
    for (std::size_t i = 0; i < columns.size(); ++i) W_.row(r)[columns[i]] = unit_.row(r)[i];
    W_.find_blocks(r);
    left_[r] = W_.squared_norm(r);
  }
  R_.setZero();
  begin(decide);
  for (int k = 0; k < rank_; ++k) {
    if (decide) {
      choose_pivot(k);
      pivot_[k] = std::sqrt(left_[order_[k]]);
      if (!counts(k, pivot_[k])) {
        rank_ = k;
        break;
      }
    }
    make_orthonormal(k);
  }
}

/// Whether the k-th row in the order is far enough from those before it to be independent of them.
bool ConstraintSolver::counts(int k, double distance) {
  if (k < remembered_ || (remembered_ < 0 && distance >= rank_tolerance))
    nearness_ = std::min(nearness_, distance);
  if (remembered_ < 0) return distance >= rank_tolerance;
  if (k >= remembered_) return distance >= nearness_tolerance;
  return distance >= std::clamp(nearness_share * largest_[k], rank_tolerance, nearness_tolerance);
}

void ConstraintSolver::remember() {
  std::sort(pivot_.begin(), pivot_.begin() + rank_, std::greater());  // (order of Gram-Schmidt)
  for (int k = 0; k < rank_; ++k) largest_[k] = std::max(largest_[k], pivot_[k]);
  longest_ = longest_.cwiseMax(length_);
  remembered_ = std::max(remembered_, rank_);
}

void ConstraintSolver::remember(const ConstraintSolver& other) {
  largest_ = other.largest_;
  longest_ = other.longest_;
  remembered_ = other.remembered_;
}

void ConstraintSolver::forget() {
  largest_.setZero();
  longest_.setZero();
  remembered_ = -1;
}

/// Moves the row with the largest remainder to the k-th place.
void ConstraintSolver::choose_pivot(int k) {
  int best = k;
  double largest = known_left(W_, order_[k], left_[order_[k]]);
  for (int i = k + 1; i < system_.rows; ++i) {
    // Of rows equally far, take the one written first, whatever the rounding.
    if (const double other = known_left(W_, order_[i], left_[order_[i]]); other > largest * (1 + 1e-6)) {
      largest = other;
      best = i;
    }
  }
  std::rotate(order_.begin() + k, order_.begin() + best, order_.begin() + best + 1);
}

void ConstraintSolver::make_orthonormal(int k) {
  const int pivot = order_[k];
  for (int j = 0; j < k; ++j)  // again, to remove what cancellation left
    if (basis_.shares(j, W_, pivot)) take_out(j, pivot);
  const double length = std::sqrt(known_left(W_, pivot, left_[pivot]));
  R_(pivot, k) = length;
  basis_.clear(k);
  // Otherwise a stage of a step hit a singular position: the row takes no part at this instant.
  if (length >= rank_tolerance) basis_.add(k, 1 / length, W_, pivot);
  for (std::size_t i = k + 1; i < order_.size(); ++i)
    if (basis_.shares(k, W_, order_[i])) take_out(k, order_[i]);
}

/// Subtracts from a row of W its projection on the k-th basis row.
void ConstraintSolver::take_out(int k, int row) {
  const double c = basis_.dot(k, W_, row);
  if (c == 0) return;
  R_(row, k) += c;
  W_.add(row, -c, basis_, k);
  left_[row] = unknown;
}

std::vector<std::string> ConstraintSolver::rows_behind(int row) const {
  std::vector<std::string> names;
  if (is_empty(row) || std::find(order_.begin(), order_.begin() + rank_, row) != order_.begin() + rank_)
    return names;
  // The row is sum_i c_i (independent row i), with sum_i R(i, k) c_i = R(row, k): triangular in the rows'
  // order.
  Eigen::VectorXd part(rank_);
  for (int k = rank_ - 1; k >= 0; --k) {
    double sum = R_(row, k);
    for (int j = k + 1; j < rank_; ++j) sum -= R_(order_[j], k) * part[j];
    part[k] = sum / R_(order_[k], k);
  }
  for (int k = 0; k < rank_; ++k)
    if (std::abs(part[k]) > 1e-6) names.push_back(system_.row_names[order_[k]]);
  return names;
}

void ConstraintSolver::correct(const Rows& F, const Eigen::VectorXd& b, Eigen::VectorXd& x) {
  if (factored_) {
    combine_rows(b, x);
  } else {
    for (int k = 0; k < rank_; ++k) {
      const int row = order_[k];
      const double sum = scale_[row] * b[row] - R_.row(row).head(k).dot(z_.head(k));
      z_[k] = R_(row, k) >= rank_tolerance ? sum / R_(row, k) : 0;
    }
    combine(x);
  }
  solve_lower(system_, F, x.data());
}

/// x <- y = W^T m with W y = b for unit rows, by their Gram matrix; m goes to unit_multipliers_.
void ConstraintSolver::combine_rows(const Eigen::VectorXd& b, Eigen::VectorXd& x) {
  y_.setZero();
  unit_multipliers_.setZero();
  for (int refinement = 0; refinement < 2; ++refinement) {
    rest_.setZero();
    for (int k = 0; k < rank_; ++k) {
      const int row = order_[k];
      rest_[row] = scale_[row] * b[row] - (refinement > 0 ? unit_.dot(row, y_.data()) : 0);
    }
    unit_.solve_lower(rest_.data());
    unit_.solve_upper(rest_.data());
    for (int k = 0; k < rank_; ++k) unit_.add_to(y_.data(), rest_[order_[k]], order_[k]);
    unit_multipliers_ += rest_;
  }
  x = y_.head(system_.nv);
}

void ConstraintSolver::compromise(const Rows& F, const Eigen::VectorXd& b, double damping,
                                  Eigen::VectorXd& x) {
  if (factored_) {
    orthonormalise(false);
    factored_ = false;
  }
  z_.head(rank_).setZero();
  for (int row = 0; row < system_.rows; ++row)
    z_.head(rank_) += scale_[row] * b[row] * R_.row(row).head(rank_).transpose();
  solve_gram(damping, z_);
  combine(x);
  solve_lower(system_, F, x.data());
}

/// x <- y = sum_k z_k basis_k.
void ConstraintSolver::combine(Eigen::VectorXd& x) {
  y_.setZero();
  for (int k = 0; k < rank_; ++k) basis_.add_to(y_.data(), z_[k], k);
  x = y_.head(system_.nv);
}

/// x <- (R^T R + damping^2)^-1 x over the rank, by Cholesky.
void ConstraintSolver::solve_gram(double damping, Eigen::VectorXd& x) {
  for (int i = 0; i < rank_; ++i) G_.row(i).head(i + 1).setZero();
  for (int row = 0; row < system_.rows; ++row)
    for (int i = 0; i < rank_; ++i)
      if (const double c = R_(row, i); c != 0) G_.row(i).head(i + 1) += c * R_.row(row).head(i + 1);
  for (int i = 0; i < rank_; ++i)
    for (int j = 0; j <= i; ++j) {
      const double sum =
          G_(i, j) + (i == j ? damping * damping : 0) - G_.row(i).head(j).dot(G_.row(j).head(j));
      G_(i, j) = i == j ? std::sqrt(std::max(sum, rank_tolerance * rank_tolerance)) : sum / G_(j, j);
    }
  for (int i = 0; i < rank_; ++i) {
    for (int j = 0; j < i; ++j) x[i] -= G_(i, j) * x[j];
    x[i] /= G_(i, i);
  }
  for (int i = rank_ - 1; i >= 0; --i) {
    for (int j = i + 1; j < rank_; ++j) x[i] -= G_(j, i) * x[j];
    x[i] /= G_(i, i);
  }
}

void ConstraintSolver::multipliers(Eigen::VectorXd& lambda) {
  if (factored_) {
    lambda = unit_multipliers_.cwiseProduct(scale_);
    return;
  }
  lambda.setZero();
  s_ = z_;
  const bool independent =
      std::all_of(order_.begin() + rank_, order_.end(), [&](int row) { return is_empty(row); });
  if (independent) {  // R is triangular in the rows' order
    for (int k = rank_ - 1; k >= 0; --k) {
      const int row = order_[k];
      lambda[row] = R_(row, k) >= rank_tolerance ? s_[k] / R_(row, k) : 0;
      s_.head(k) -= lambda[row] * R_.row(row).head(k).transpose();
    }
  } else {  // the least of all solutions: lambda = R s with R^T R s = z
    solve_gram(0, s_);
    for (int row = 0; row < system_.rows; ++row) lambda[row] = R_.row(row).head(rank_).dot(s_.head(rank_));
  }
  lambda.array() *= scale_.array();
}

}  // namespace borelli
