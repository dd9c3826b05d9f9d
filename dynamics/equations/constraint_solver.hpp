// Least corrections that satisfy the constraint rows, in the norm of the mass matrix, and their multipliers.
// With A = F^T F and W = L F^-1, a correction a = F^-1 y has norm |y|, and L a = W y.
//
// The rows of W are scaled to unit length, which removes their units. They are made orthonormal one after the
// other, always the one farthest from the span of those before it (Gram-Schmidt with pivoting; Bjorck,
// Numerics of Gram-Schmidt orthogonalization, 1994). Rows in that span are dependent: they do not enter y,
// and the multipliers are the least that give the same y.
//
// If all rows are well separated, their Gram matrix is eliminated instead (sparse_rows.hpp), at a cost nearly
// linear in the number of loops. The orthonormal basis needs rows x rank numbers, allocated at first use.
//
// A row has entries only on the branches that its constraint ties. Rows are stored in blocks of columns with
// a mask of the nonempty ones; rows without a common block are orthogonal.
//
// At a singular position (a flattened four-bar) rows become dependent that are independent elsewhere. Close
// to it, the direction of such a row is known only to rounding over its distance, and steps along it end on
// an arbitrary branch. Within a run the solver therefore remembers how far its rows have been from the
// others. It treats them as dependent while they are much closer than that: the motion coasts through the
// neighbourhood by its inertia, along its own branch.
#pragma once

#include <algorithm>
#include <vector>

#include "dynamics/equations/block_rows.hpp"
#include "dynamics/equations/sparse_rows.hpp"
#include "dynamics/system/system.hpp"

namespace borelli {

/// The rows that take part: all, or only position rows (without System::kinematic_rows).
enum class RowSet { all, positions };

class ConstraintSolver {
 public:
  explicit ConstraintSolver(const System& system);

  /// Least distance of an independent unit row from the span of the others. It lies above the errors of
  /// assembly and rounding (about 1e-10) and far below the distances in a healthy mechanism.
  static constexpr double rank_tolerance = 1e-8;
  /// Rank thresholds within a run. A row that has been independent stays so down to nearness_share of its
  /// largest distance, or to nearness_tolerance if that is less. A row that has never been independent must
  /// exceed nearness_tolerance. A smaller tolerance coasts less, but amplifies rounding by its inverse
  /// square: 1e-16 / 1e-8.
  static constexpr double nearness_tolerance = 1e-4, nearness_share = 1e-3;
  /// Unit rows farther than this from those before them are eliminated by their Gram matrix. It resolves the
  /// square of the distance to 1e-8, or to 1e-2 after rows of which only a millionth was left.
  static constexpr double healthy_distance = 1e-4;

  /// Sets L (rows x size; only the free columns are read) and the factor F of the mass matrix. With `decide`
  /// it also decides rank and order of the rows; else it keeps the last decision. Rows outside `set` count as
  /// empty.
  void prepare(const Rows& L, const Rows& F, bool decide, RowSet set = RowSet::all);

  /// Row r of L times x (nv numbers), over the coordinates that its constraint ties.
  double along(const Rows& L, int r, const Eigen::VectorXd& x) const { return unit_.dot(L, r, x.data()); }
  /// b <- b - L x, row by row with along().
  void take_from(Eigen::VectorXd& b, const Rows& L, const Eigen::VectorXd& x) const {
    for (int r = 0; r < system_.rows; ++r) b[r] -= along(L, r, x);
  }

  /// The least correction x (nv numbers, norm of the mass matrix) with L x = b on the independent rows.
  void correct(const Rows& F, const Eigen::VectorXd& b, Eigen::VectorXd& x);

  /// A correction that brings all rows, dependent ones too, as close to L x = b as possible: least squares of
  /// unit rows, damped against poorly determined directions (Levenberg 1944). `damping` is relative to a unit
  /// row.
  void compromise(const Rows& F, const Eigen::VectorXd& b, double damping, Eigen::VectorXd& x);

  /// The multipliers of the last correction (not compromise): A x = L^T lambda.
  void multipliers(Eigen::VectorXd& lambda);

  int rank() const { return rank_; }
  /// At the last decision, the least distance from the others of a row that counts, or has counted, as
  /// independent. 1 without rows.
  double nearness() const { return nearness_; }
  /// The larger of the remembered rank and that of the last decision.
  int full_rank() const { return std::max(remembered_, rank_); }
  /// Remembers the rows' distances at the last decision, for a state that the run accepted. Later decisions
  /// compare with them.
  void remember();
  /// Copies the memory of another solver of the same system.
  void remember(const ConstraintSolver& other);
  /// Clears the memory: rows are judged by rank_tolerance alone.
  void forget();
  template <class Keeper>
  void keep(Keeper& k) {
    k.within(rank_, 0, system_.rows);
    k.within(remembered_, -1, system_.rows);
    for (int& row : order_) k.within(row, 0, system_.rows - 1);
    k(scale_, length_, longest_, nearness_, pivot_, largest_, healthy_);
  }
  /// The last correction x (not compromise) as y = F x. If x is a velocity, its kinetic energy is y . y / 2,
  /// component by component.
  const Eigen::VectorXd& measured() const { return y_; }
  /// Row indices: independent rows first (rank of them), then the dependent ones.
  const std::vector<int>& order() const { return order_; }
  /// Whether row i has no effect on any free coordinate.
  bool is_empty(int i) const { return scale_[i] == 0; }
  /// Names of the independent rows that combine to a dependent `row`; empty for an independent one.
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
  Eigen::VectorXd scale_;  ///< per row of W: 1 / its length, reduced while L's row is shorter than
                           ///< remembered; 0: empty
  Eigen::VectorXd length_,
      longest_;  ///< length of each row of L in the coordinates' scales; its maximum over remembered states
  SparseRows unit_;        ///< W with unit rows
  bool healthy_ = true;    ///< whether all nonempty rows were independent at the last decision
  bool factored_ = false;  ///< whether the factor is in unit_; else in basis_ and R_
  BlockRows W_;            ///< rows x nv: unit rows minus their projections on the basis so far
  BlockRows basis_;        ///< rank x nv, orthonormal
  Rows R_;                 ///< rows x rank: unit row r of W is sum_k R(r, k) basis_k
  Eigen::VectorXd left_;   ///< per row of W: squared length of what is left
  Eigen::VectorXd unit_multipliers_, rest_;  ///< for unit_: multipliers of the last correction; scratch
  int remembered_ = -1;                      ///< largest rank of remembered states; -1: none
  double nearness_ = 1;
  Eigen::VectorXd pivot_;    ///< per independent row, in order: distance from those before it
  Eigen::VectorXd largest_;  ///< maximum of pivot_ over remembered states
  Eigen::VectorXd z_;        ///< last correction in the orthonormal basis
  Rows G_;                   ///< rank x rank scratch
  Eigen::VectorXd s_, y_;    ///< scratch
};

}  // namespace borelli
