// Factors and solves with the mass matrix along the branches of the tree: A = F^T F with F lower triangular
// and no fill-in, so that independent solids cost nothing to each other (Featherstone, Rigid Body Dynamics
// Algorithms, 2008, section 6.5, there called LTL).
#pragma once

#include <span>

#include "dynamics/system/system.hpp"

namespace borelli {

/// Factors the free part of A (row >= column kept) into F, nv x nv. Returns -1, or the number of the free
/// coordinate whose pivot vanishes beside its own entry: no effort along it meets any inertia.
int factor_mass_matrix(const System& system, const Rows& A, Rows& F);

/// x <- F^-T x, and x <- F^-1 x, in place, nv numbers. One after the other they solve A x = b.
void solve_transposed(const System& system, const Rows& F, double* x);
void solve_lower(const System& system, const Rows& F, double* x);
/// x <- F^-T x of eight columns at once, row k of which stands at x + k * stride. The rows that are not zero
/// come to stand in `rows`, descending; returns how many.
int solve_transposed(const System& system, const Rows& F, double* x, Eigen::Index stride, int* rows);
/// x <- F^-T x, where x has entries in these coordinates only: ascending, each with its ancestors.
void solve_transposed(const System& system, const Rows& F, std::span<const int> coordinates, double* x);

}  // namespace borelli
