#include "dynamics/constraint_solver.hpp"

#include <algorithm>
#include <numeric>

#include "dynamics/branch_sparse.hpp"

namespace borelli {

ConstraintSolver::ConstraintSolver(const System& system)
    : system_(system),
      order_(system.rows),
      scale_(Eigen::VectorXd::Zero(system.rows)),
      length_(scale_),
      longest_(scale_),
      W_(Rows::Zero(system.rows, system.nv)),
      basis_(Rows::Zero(std::min(system.rows, system.nv), system.nv)),
      R_(Rows::Zero(std::min(system.rows, system.nv), system.rows)),
      pivot_(Eigen::VectorXd::Zero(std::min(system.rows, system.nv))),
      largest_(pivot_),
      z_(pivot_),
      G_(Rows::Zero(z_.size(), z_.size())),
      s_(z_),
      y_(Eigen::VectorXd::Zero(system.nv)) {
  std::iota(order_.begin(), order_.end(), 0);
}

void ConstraintSolver::prepare(const Rows& L, const Rows& F, bool decide, RowSet set) {
  for (int r = 0; r < system_.rows; ++r) {
    W_.row(r) = L.row(r).head(system_.nv);
    length_[r] = 0;
    for (int i = 0; i < system_.nv; ++i) length_[r] += std::abs(W_(r, i)) * system_.velocity_scale[i];
    // entries are lengths or pure numbers; one of rounding's size is none
    const bool left_out = set == RowSet::positions && system_.kinematic_rows[r];
    if (left_out || system_.nv == 0 ||
        W_.row(r).cwiseAbs().maxCoeff() <= 1e-13 * std::max(1.0, system_.length)) {
      W_.row(r).setZero();
      scale_[r] = 0;
      continue;
    }
    solve_transposed(system_, F, W_.row(r).data());
    scale_[r] = 1 / W_.row(r).norm();
    // one that has all but vanished (a slide at its crank's dead point) points where rounding will
    if (remembered_ >= 0 && length_[r] < longest_[r]) scale_[r] *= length_[r] / longest_[r];
    W_.row(r) *= scale_[r];
  }
  R_.setZero();
  if (decide) {
    std::iota(order_.begin(), order_.end(), 0);
    rank_ = int(basis_.rows());
    nearness_ = 1;
  }
  for (int k = 0; k < rank_; ++k) {
    if (decide) {
      choose_pivot(k);
      pivot_[k] = W_.row(order_[k]).norm();
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

void ConstraintSolver::choose_pivot(int k) {
  int best = k;
  double largest = W_.row(order_[k]).squaredNorm();
  for (int i = k + 1; i < system_.rows; ++i) {
    // of rows equally far the earlier written one is taken, whatever the rounding
    const double length = W_.row(order_[i]).squaredNorm();
    if (length > largest * (1 + 1e-6)) {
      largest = length;
      best = i;
    }
  }
  std::rotate(order_.begin() + k, order_.begin() + best, order_.begin() + best + 1);
}

void ConstraintSolver::make_orthonormal(int k) {
  const int pivot = order_[k];
  auto row = W_.row(pivot);
  for (int j = 0; j < k; ++j) {  // once more, against what cancellation left
    const double c = basis_.row(j).dot(row);
    R_(j, pivot) += c;
    row -= c * basis_.row(j);
  }
  const double length = row.norm();
  R_(k, pivot) = length;
  if (length >= rank_tolerance)
    basis_.row(k) = row / length;
  else  // a stage of a step fell on a singular position: the row takes no part at this instant
    basis_.row(k).setZero();
  for (std::size_t i = k + 1; i < order_.size(); ++i) {
    auto other = W_.row(order_[i]);
    const double c = basis_.row(k).dot(other);
    R_(k, order_[i]) = c;
    other -= c * basis_.row(k);
  }
}

std::vector<std::string> ConstraintSolver::rows_behind(int row) const {
  std::vector<std::string> names;
  if (std::find(order_.begin(), order_.begin() + rank_, row) != order_.begin() + rank_) return names;
  // its parts c along the independent rows: sum_i R(k, i) c_i = R(k, row), triangular in the rows' order
  Eigen::VectorXd part(rank_);
  for (int k = rank_ - 1; k >= 0; --k) {
    double sum = R_(k, row);
    for (int j = k + 1; j < rank_; ++j) sum -= R_(k, order_[j]) * part[j];
    part[k] = sum / R_(k, order_[k]);
  }
  for (int k = 0; k < rank_; ++k)
    if (std::abs(part[k]) > 1e-6) names.push_back(system_.row_names[order_[k]]);
  return names;
}

void ConstraintSolver::correct(const Rows& F, const Eigen::VectorXd& b, Eigen::VectorXd& x) {
  y_.setZero();
  for (int k = 0; k < rank_; ++k) {
    const int row = order_[k];
    double sum = scale_[row] * b[row];
    for (int j = 0; j < k; ++j) sum -= R_(j, row) * z_[j];
    z_[k] = R_(k, row) >= rank_tolerance ? sum / R_(k, row) : 0;
    y_ += z_[k] * basis_.row(k).transpose();
  }
  x = y_;
  solve_lower(system_, F, x.data());
}

void ConstraintSolver::compromise(const Rows& F, const Eigen::VectorXd& b, double damping,
                                  Eigen::VectorXd& x) {
  for (int k = 0; k < rank_; ++k) {
    z_[k] = 0;
    for (int row = 0; row < system_.rows; ++row) z_[k] += R_(k, row) * scale_[row] * b[row];
  }
  solve_gram(damping, z_);
  y_.setZero();
  for (int k = 0; k < rank_; ++k) y_ += z_[k] * basis_.row(k).transpose();
  x = y_;
  solve_lower(system_, F, x.data());
}

/// x <- (R R^T + damping^2)^-1 x over the rank, by Cholesky.
void ConstraintSolver::solve_gram(double damping, Eigen::VectorXd& x) {
  for (int i = 0; i < rank_; ++i)
    for (int j = 0; j <= i; ++j) {
      double sum = R_.row(i).dot(R_.row(j)) + (i == j ? damping * damping : 0);
      for (int l = 0; l < j; ++l) sum -= G_(i, l) * G_(j, l);
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
  lambda.setZero();
  if (rank_ == system_.rows) {  // R is triangular in the rows' order
    for (int k = rank_ - 1; k >= 0; --k) {
      double sum = z_[k];
      for (int j = k + 1; j < rank_; ++j) sum -= R_(k, order_[j]) * lambda[order_[j]];
      lambda[order_[k]] = R_(k, order_[k]) >= rank_tolerance ? sum / R_(k, order_[k]) : 0;
    }
  } else {  // the least of many: lambda = R^T s with R R^T s = z
    s_ = z_;
    solve_gram(0, s_);
    for (int k = 0; k < rank_; ++k) lambda += s_[k] * R_.row(k).transpose();
  }
  lambda.array() *= scale_.array();
}

}  // namespace borelli
