// Branch-sparse factor of the mass matrix and its solves: A = F^T F, with F lower triangular and no fill-in,
// so that independent solids cost each other nothing (Featherstone, Rigid Body Dynamics Algorithms, 2008,
// section 6.5, there called LTL).
#pragma once

#include <span>

#include "dynamics/system/system.hpp"

namespace borelli {

/// Factors the free part of A (only row >= column is read) into F, nv x nv. Returns -1, or the free
/// coordinate whose pivot is no more than its rounding error: a force along it meets no inertia.
int factor_mass_matrix(const System& system, const Rows& A, Rows& F);

/// x <- F^-T x, and x <- F^-1 x, in place, nv numbers. In this order they solve A x = b.
void solve_transposed(const System& system, const Rows& F, double* x);
void solve_lower(const System& system, const Rows& F, double* x);
/// x <- F^-T x for eight columns at once; row k stands at x + k * stride. `rows` receives the nonzero rows,
/// descending; returns their number.
int solve_transposed(const System& system, const Rows& F, double* x, Eigen::Index stride, int* rows);
/// Which rows of a matrix of nv rows and nv columns may be nonzero, per eight columns.
class RowPattern {
 public:
  /// Those along the branches.
  explicit RowPattern(const System& system);
  /// Row i and those before it on its chain may be nonzero in column j.
  void add(const System& system, int i, int j);
  int blocks() const { return int(reached_.rows()); }
  bool holds(int block, int row) const { return reached_(block, row) != 0; }

 private:
  RowsOf<char> reached_;  ///< blocks x nv
};

/// x <- scale A^-1 x for two matrices side by side of the same pattern, each padded to whole blocks of eight
/// columns; row k of both stands at x + k * stride.
void solve_pair(const System& system, const Rows& F, const RowPattern& pattern, double scale, double* x,
                Eigen::Index stride);
/// x <- F^-T x for an x with entries only in `coordinates`: ascending, each with its ancestors.
void solve_transposed(const System& system, const Rows& F, std::span<const int> coordinates, double* x);

}  // namespace borelli
