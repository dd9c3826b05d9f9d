// Least corrections that satisfy the constraint rows, measured by the mass matrix, and the multipliers that
// bring them about. With A = F^T F and W = L F^-1, the acceleration that a = F^-1 y adds has the size |y|,
// and L a = W y.
//
// The rows of W, each scaled to unit length and so free of units, are made orthonormal one after the other,
// the farthest from the span of those before it first (Gram-Schmidt with pivoting; Bjorck, Numerics of
// Gram-Schmidt orthogonalization, 1994). Rows that lie in the span depend on the others: they take no part in
// y, and the multipliers are the least that give the same y.
//
// Where no row comes near to the others, their Gram matrix is eliminated instead (sparse_rows.hpp), at a cost
// that grows with the number of loops as good as linearly. The basis takes room of rows x rank, which is made
// when first it is needed.
//
// A row has entries on the branches that its constraint ties only. Rows are kept in blocks of columns, with a
// mask of those that are not empty, and what has no block in common is orthogonal as it is.
//
// At a singular position (a four-bar flattened) rows that are independent elsewhere become dependent. Close
// to it the direction in which such a row holds is known to rounding over the distance only, and steps that
// follow it there come out on any branch. So within a run the solver remembers how far from the others its
// rows have been, and counts them as dependent while they are much closer than that: the motion coasts
// through the neighbourhood by its own inertia, which is along the branch that it came on.
#pragma once

#include <algorithm>
#include <vector>

#include "dynamics/equations/block_rows.hpp"
#include "dynamics/equations/sparse_rows.hpp"
#include "dynamics/system/system.hpp"

namespace borelli {

/// Which rows take part: all, or those that hold positions (System::kinematic_rows are left out).
enum class RowSet { all, positions };

class ConstraintSolver {
 public:
  explicit ConstraintSolver(const System& system);

  /// How far from the span of the others a unit row must be to count as independent of them. It lies above
  /// what assembly and rounding leave (some 1e-10) and far below what a healthy mechanism has.
  static constexpr double rank_tolerance = 1e-8;
  /// Within a run: how near rows that have been independent may come to dependence, at most and in parts of
  /// the farthest that they have been, and from where on rows count as independent that have never been. What
  /// coasting through costs falls with it, what rounding costs rises with its inverse square: 1e-16 / 1e-8.
  static constexpr double nearness_tolerance = 1e-4, nearness_share = 1e-3;
  /// Rows farther from those before them than this, unit rows, are told apart by their Gram matrix: to 1e-8
  /// of the distance's square, and to 1e-2 where rows of which but a millionth was left went before.
  static constexpr double healthy_distance = 1e-4;

  /// Takes in L (rows x size; its free columns) and the factor F of the mass matrix. With `decide` it also
  /// decides rank and order of the rows; else it keeps those of the last decision. Rows that are not in the
  /// set count as empty.
  void prepare(const Rows& L, const Rows& F, bool decide, RowSet set = RowSet::all);

  /// Row r of L times x (nv numbers), over the coordinates that its constraint ties.
  double along(const Rows& L, int r, const Eigen::VectorXd& x) const { return unit_.dot(L, r, x.data()); }
  /// b <- b - L x, row by row as along() has it.
  void take_from(Eigen::VectorXd& b, const Rows& L, const Eigen::VectorXd& x) const {
    for (int r = 0; r < system_.rows; ++r) b[r] -= along(L, r, x);
  }

  /// The least correction x (nv numbers, by the mass matrix) with L x = b on the independent rows.
  void correct(const Rows& F, const Eigen::VectorXd& b, Eigen::VectorXd& x);

  /// A correction that brings all rows, dependent ones too, towards L x = b as far as they agree: least
  /// squares of unit rows, damped against directions that rows hardly determine (Levenberg 1944), `damping`
  /// in parts of a unit row.
  void compromise(const Rows& F, const Eigen::VectorXd& b, double damping, Eigen::VectorXd& x);

  /// The multipliers of the last correction (not compromise): A x = L^T lambda.
  void multipliers(Eigen::VectorXd& lambda);

  int rank() const { return rank_; }
  /// Of the least independent row that has been independent, at the last decision: how far it was from the
  /// span of the others. 1 without rows.
  double nearness() const { return nearness_; }
  /// The largest rank remembered, or that of the last decision if none is.
  int full_rank() const { return std::max(remembered_, rank_); }
  /// Remembers the rows' distances at the last decision, that of a state which the run came to: from then on
  /// they are judged by what they have been.
  void remember();
  /// The same memory as another solver of the same system.
  void remember(const ConstraintSolver& other);
  /// Judges rows by rank_tolerance alone.
  void forget();
  template <class Keeper>
  void keep(Keeper& k) {
    k.within(rank_, 0, system_.rows);
    k.within(remembered_, -1, system_.rows);
    for (int& row : order_) k.within(row, 0, system_.rows - 1);
    k(scale_, length_, longest_, nearness_, pivot_, largest_, healthy_);
  }
  /// The last correction (not compromise) in the basis of F, F x = y: its energy where x is a velocity is
  /// y . y / 2, component by component.
  const Eigen::VectorXd& measured() const { return y_; }
  /// Row indices: independent rows first (rank of them), then the dependent ones.
  const std::vector<int>& order() const { return order_; }
  /// Whether row i has no effect on any free coordinate.
  bool is_empty(int i) const { return scale_[i] == 0; }
  /// Of a dependent row: the names of the rows that it is made of; of an independent one: none.
  std::vector<std::string> rows_behind(int row) const;

 private:
  bool counts(int k, double distance);
  void begin(bool decide);
  bool eliminate(bool decide);
  void orthonormalise(bool decide);
  void choose_pivot(int k);
  void make_orthonormal(int k);
  void take_out(int k, int row);
  void combine_rows(const Eigen::VectorXd& b, Eigen::VectorXd& x);
  void combine(Eigen::VectorXd& x);
  void solve_gram(double damping, Eigen::VectorXd& x);

  const System& system_;
  int rank_ = 0;
  std::vector<int> order_;
  Eigen::VectorXd scale_;  ///< of each row of W: 1 / its length, less for one that was longer; 0: empty
  Eigen::VectorXd length_,
      longest_;            ///< of each row of L, by the coordinates' scales; over the states remembered
  SparseRows unit_;        ///< W, unit rows
  bool healthy_ = true;    ///< whether all that were not empty were independent, as decided
  bool factored_ = false;  ///< whether it stands in unit_; else basis_ and R_ do
  BlockRows W_;            ///< rows x nv: unit rows, on the way to what is left of them
  BlockRows basis_;        ///< rank x nv, orthonormal
  Rows R_;                 ///< rows x rank: unit row r of W is sum_k R(r, k) basis_k
  Eigen::VectorXd left_;   ///< of each row of W: the square of what is left of it
  Eigen::VectorXd unit_multipliers_, rest_;  ///< of unit_: of the last correction; scratch
  int remembered_ = -1;                      ///< the largest rank that states of the run had; -1: none seen
  double nearness_ = 1;
  Eigen::VectorXd pivot_;    ///< of each independent row in its order: its distance from those before it
  Eigen::VectorXd largest_;  ///< of these over the states remembered
  Eigen::VectorXd z_;        ///< of the last correction, in the basis
  Rows G_;                   ///< rank x rank scratch
  Eigen::VectorXd s_, y_;    ///< scratch
};

}  // namespace borelli
