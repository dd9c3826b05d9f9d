// The branch-sparse factor against a dense Cholesky factor of the same matrix.
#include "dynamics/equations/branch_sparse.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

#include "dynamics/equations/evaluate.hpp"
#include "scenes.hpp"

namespace borelli::test {
namespace {

/// A mass matrix of the system, its factor, and A x = b solved by that.
struct Solved {
  Rows A, F;
  Eigen::VectorXd b, x;

  explicit Solved(const System& system)
      : A(need(evaluate(system, Random(4).state(system))).mass_matrix),
        F(Rows::Zero(system.nv, system.nv)),
        b(Eigen::VectorXd::LinSpaced(system.nv, -1, 2)),
        x(b) {
    EXPECT_EQ(factor_mass_matrix(system, A, F), -1);
    EXPECT_LT((Rows(F.transpose() * F) - A).norm(), 1e-14 * system.nv * A.norm());
    solve_transposed(system, F, x.data());
    solve_lower(system, F, x.data());
  }
};

void expect_solved(const Scene& scene) {
  const System system = compiled(scene);
  const auto [A, F, b, x] = Solved(system);
  const Eigen::VectorXd dense = Eigen::MatrixXd(A).llt().solve(b);
  EXPECT_LT((x - dense).norm(), 1e-11 * dense.norm());  // rounding times the condition of A, up to 1e4
  // eight columns at once, each with one entry
  Rows columns = Rows::Zero(system.nv, 8);
  for (int c = 0; c < 8; ++c) columns(c % system.nv, c) = 1 + c;
  std::vector<int> rows(system.nv);
  const Rows whole = columns;
  const int count = solve_transposed(system, F, columns.data(), 8, rows.data());
  for (int c = 0; c < 8; ++c) {
    Eigen::VectorXd one = whole.col(c);
    solve_transposed(system, F, one.data());
    EXPECT_LE((columns.col(c) - one).norm(), 1e-14 * one.norm()) << c;
  }
  rows.resize(count);
  for (int k = 0; k < system.nv; ++k)
    EXPECT_EQ(!columns.row(k).isZero(0), std::find(rows.begin(), rows.end(), k) != rows.end()) << k;
}

TEST(BranchSparse, SolvesChainsStarsAndTrees) {
  expect_solved(chain(7, true));
  expect_solved(bars(5));
  for (unsigned seed = 0; seed < 5; ++seed) expect_solved(random_tree(seed, {.balls = true}));
}

// Branches longer than the blocked factorisation's width. The condition leaves x no correct digits, so the
// residual of b is compared with rounding.
TEST(BranchSparse, FactorsLongBranches) {
  const System system = compiled(chain(60, true));
  const auto [A, F, b, x] = Solved(system);
  EXPECT_LT((A * x - b).norm(), 1e-14 * system.nv * A.norm() * x.norm());
}

TEST(BranchSparse, HasNoFillInBetweenIndependentSolids) {
  const System system = compiled(bars(4));
  EXPECT_EQ(system.branches().first_ancestor.size(), 5u);  // nv + 1
  EXPECT_TRUE(system.branches().ancestors.empty());
}

TEST(BranchSparse, NamesACoordinateWithoutInertia) {
  const System system = compiled(chain(3, false));
  Rows A = need(evaluate(system, system.initial)).mass_matrix;
  Rows F = Rows::Zero(3, 3);
  A.row(1) = A.row(0) * A(1, 0) / A(0, 0);  // the second coordinate moves the same as the first
  A.col(1) = A.row(1);
  A(2, 0) = A(0, 2) = A(2, 1) = A(1, 2) = 0;
  A(0, 1) = A(1, 0);
  A(1, 1) = A(0, 1) * A(0, 1) / A(0, 0);
  EXPECT_EQ(factor_mass_matrix(system, A, F), 0);  // elimination runs from the leaves to the root
}

}  // namespace
}  // namespace borelli::test
