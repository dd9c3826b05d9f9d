// Branch-sparse factor of the mass matrix and its solves: A = F^T F, with F lower triangular and no fill-in,
// so that independent solids cost each other nothing (Featherstone, Rigid Body Dynamics Algorithms, 2008,
// section 6.5, there called LTL).
#pragma once

#include <span>

#include "dynamics/system/system.hpp"

namespace borelli {

/// Factors the free part of A (only row >= column is read) into F, nv x nv. Returns -1, or the free
/// coordinate whose pivot vanishes against its own diagonal entry: a force along it meets no inertia.
int factor_mass_matrix(const System& system, const Rows& A, Rows& F);

/// x <- F^-T x, and x <- F^-1 x, in place, nv numbers. In this order they solve A x = b.
void solve_transposed(const System& system, const Rows& F, double* x);
void solve_lower(const System& system, const Rows& F, double* x);
/// x <- F^-T x for eight columns at once; row k stands at x + k * stride. `rows` receives the nonzero rows,
/// descending; returns their number.
int solve_transposed(const System& system, const Rows& F, double* x, Eigen::Index stride, int* rows);
/// x <- scale A^-1 x for nv rows of `columns` numbers (a multiple of eight); row k stands at x + k * stride.
void solve_columns(const System& system, const Rows& F, double scale, double* x, Eigen::Index stride,
                   int columns);
/// x <- F^-T x for an x with entries only in `coordinates`: ascending, each with its ancestors.
void solve_transposed(const System& system, const Rows& F, std::span<const int> coordinates, double* x);

}  // namespace borelli
