// Least corrections that satisfy the constraint rows, measured by the mass matrix, and the multipliers that
// bring them about. With A = F^T F and W = L F^-1, the acceleration that a = F^-1 y adds has the size |y|,
// and L a = W y.
//
// The rows of W, each scaled to unit length and so free of units, are made orthonormal one after the other,
// the farthest from the span of those before it first (Gram-Schmidt with pivoting; Bjorck, Numerics of
// Gram-Schmidt orthogonalization, 1994). Rows that lie in the span depend on the others: they take no part in
// y, and the multipliers are the least that give the same y.
#pragma once

#include <vector>

#include "dynamics/system.hpp"

namespace borelli {

class ConstraintSolver {
 public:
  explicit ConstraintSolver(const System& system);

  /// How far from the span of the others a unit row must be to count as independent of them. It lies above
  /// what assembly and rounding leave (some 1e-10) and far below what a healthy mechanism has.
  static constexpr double rank_tolerance = 1e-8;

  /// Takes in L (rows x size; its free columns) and the factor F of the mass matrix. With `decide` it also
  /// decides rank and order of the rows; else it keeps those of the last decision.
  void prepare(const Rows& L, const Rows& F, bool decide);

  /// The least correction x (nv numbers, by the mass matrix) with L x = b on the independent rows.
  void correct(const Rows& F, const Eigen::VectorXd& b, Eigen::VectorXd& x);

  /// A correction that brings all rows, dependent ones too, towards L x = b as far as they agree: least
  /// squares of unit rows, damped against directions that rows hardly determine (Levenberg 1944), `damping`
  /// in parts of a unit row.
  void compromise(const Rows& F, const Eigen::VectorXd& b, double damping, Eigen::VectorXd& x);

  /// The multipliers of the last correction (not compromise): A x = L^T lambda.
  void multipliers(Eigen::VectorXd& lambda);

  int rank() const { return rank_; }
  /// Row indices: independent rows first (rank of them), then the dependent ones.
  const std::vector<int>& order() const { return order_; }
  /// Whether row i has no effect on any free coordinate.
  bool is_empty(int i) const { return scale_[i] == 0; }
  /// Of a dependent row: the names of the rows that it is made of; of an independent one: none.
  std::vector<std::string> rows_behind(int row) const;

 private:
  void choose_pivot(int k);
  void make_orthonormal(int k);
  void solve_gram(double damping, Eigen::VectorXd& x);

  const System& system_;
  int rank_ = 0;
  std::vector<int> order_;
  Eigen::VectorXd scale_;  ///< of each row of W: 1 / its length; 0 for an empty one
  Rows W_;                 ///< rows x nv: unit rows, on the way to what is left of them
  Rows basis_;             ///< rank x nv, orthonormal
  Rows R_;                 ///< rank x rows: unit row r of W is sum_k R(k, r) basis_k
  Eigen::VectorXd z_;      ///< of the last correction, in the basis
  Rows G_;                 ///< rank x rank scratch
  Eigen::VectorXd s_, y_;  ///< scratch
};

}  // namespace borelli
