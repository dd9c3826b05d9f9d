// Least corrections and multipliers against a dense saddle-point solve (full rank) and a pseudo-inverse
// (dependent rows).
#include "dynamics/equations/constraint_solver.hpp"

#include <Eigen/Dense>

#include "dynamics/constraints/assembly.hpp"
#include "dynamics/equations/equations.hpp"
#include "scenes.hpp"

namespace borelli::test {
namespace {

/// Five hinged links whose end is held on a point of the world: a loop.
Scene loop() {
  Scene scene = chain(5, true, 0.5);
  scene.constraints = {{"end", PointOnPoint{{"l4", {0, 0, -1}}, {"world", {0, 0, -2}}}}};
  return scene;
}

Workspace accelerated(const System& system, const State& state) {
  Workspace w(system);
  EXPECT_FALSE(accelerate(system, system.parameters, state.t, state.q.data(), state.v.data(), {}, w));
  return w;
}

TEST(ConstraintSolver, AgreesWithTheSaddlePointSystem) {
  const System system = compiled(loop());
  const State state = Random(1).state(system);
  const Workspace w = accelerated(system, state);
  const int n = system.nv, m = system.rows;
  ASSERT_EQ(w.solver.rank(), m);
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(n + m, n + m);  // equations 3 and 4 of the paper
  K.topLeftCorner(n, n) = Eigen::MatrixXd(w.terms.A).selfadjointView<Eigen::Lower>();
  K.bottomLeftCorner(m, n) = w.rows.L;
  K.topRightCorner(n, m) = -w.rows.L.transpose();
  Eigen::VectorXd rest(n + m);
  rest << w.terms.Q - w.terms.B, -w.rows.E;
  const Eigen::VectorXd x = K.fullPivLu().solve(rest);
  // rounding times the condition of the system, about 1e3
  EXPECT_LT((w.a - x.head(n)).norm(), 1e-12 * x.norm());
  EXPECT_LT((w.multipliers - x.tail(m)).norm(), 1e-12 * x.norm());
}

// Many loops, each tied to the next: their Gram matrix is sparse and stays so.
TEST(ConstraintSolver, AgreesWithTheSaddlePointSystemOverManyLoops) {
  const System system = compiled(sample("four_bar_40.toml"));
  State state = system.initial;
  Workspace w(system);
  need(assemble(system, system.parameters, state, w));
  state.v.setLinSpaced(-1, 2);  // velocities that differ from loop to loop
  ASSERT_FALSE(accelerate(system, system.parameters, 0, state.q.data(), state.v.data(), {}, w));
  const int n = system.nv, m = w.solver.rank();
  ASSERT_EQ(m, 80);
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(n + m, n + m);
  Eigen::VectorXd rest(n + m);
  K.topLeftCorner(n, n) = Eigen::MatrixXd(w.terms.A).selfadjointView<Eigen::Lower>();
  rest.head(n) = w.terms.Q - w.terms.B;
  for (int k = 0; k < m; ++k) {
    const int row = w.solver.order()[k];
    K.row(n + k).head(n) = w.rows.L.row(row);
    K.col(n + k).head(n) = -w.rows.L.row(row).transpose();
    rest[n + k] = -w.rows.E[row];
  }
  const Eigen::VectorXd x = K.fullPivLu().solve(rest);
  EXPECT_LT((w.a - x.head(n)).norm(), 1e-11 * x.norm());
  for (int k = 0; k < m; ++k) EXPECT_NEAR(w.multipliers[w.solver.order()[k]], x[n + k], 1e-11 * x.norm());
  for (int k = m; k < system.rows; ++k) EXPECT_EQ(w.multipliers[w.solver.order()[k]], 0);
}

// Two rows that differ by little, against the saddle point in long double: the Gram matrix has the square of
// the rows' condition, 1 / nearness, but its solution is refined.
TEST(ConstraintSolver, LosesOnlyTheConditionNumberNearDependence) {
  for (const double apart : {1., 1e-1, 1e-2, 1e-3, 3e-4, 1e-4, 1e-5, 1e-6, 1e-7}) {
    Scene scene = chain(6, true, 0.5);
    scene.constraints = {
        {"one", CoordinateCoupling{{{"h0"}, {"h3"}, {"h4"}}, {1, -2, 1}, constant(0)}},
        {"end", PointOnPlane{{"l5", {0, 0, -1}}, {{"world", {0, 0, -2}}, {0.6, 0, 0.8}}}},
        {"two", CoordinateCoupling{{{"h0"}, {"h3"}, {"h4"}, {"h5"}}, {1, -2, 1, apart}, constant(0)}}};
    const System system = compiled(scene);
    const State state = Random(1).state(system);
    const Workspace w = accelerated(system, state);
    const int n = system.nv, m = system.rows;
    ASSERT_EQ(w.solver.rank(), m);
    using Real = long double;
    Eigen::MatrixX<Real> K = Eigen::MatrixX<Real>::Zero(n + m, n + m);
    Eigen::VectorX<Real> rest(n + m);
    K.topLeftCorner(n, n) =
        Eigen::MatrixXd(Eigen::MatrixXd(w.terms.A).selfadjointView<Eigen::Lower>()).cast<Real>();
    K.bottomLeftCorner(m, n) = w.rows.L.cast<Real>();
    K.topRightCorner(n, m) = -w.rows.L.transpose().cast<Real>();
    rest << (w.terms.Q - w.terms.B).cast<Real>(), -w.rows.E.cast<Real>();
    const Eigen::VectorXd x = K.fullPivLu().solve(rest).cast<double>();
    const double nearness = w.solver.nearness();
    EXPECT_LT(nearness, 2 * apart);
    // rounding, the condition of A (about 1e3) and that of the rows; once more for multipliers
    EXPECT_LT((w.a - x.head(n)).norm(), 1e-13 / nearness * x.head(n).norm()) << apart;
    EXPECT_LT((w.multipliers - x.tail(m)).norm(), 1e-13 / nearness * x.tail(m).norm()) << apart;
  }
}

TEST(ConstraintSolver, GivesLeastNormMultipliersForDependentRows) {
  Scene scene = loop();
  scene.constraints.push_back(scene.constraints[0]);
  scene.constraints[1].name = "again";
  const System system = compiled(scene), once = compiled(loop());
  const State state = Random(1).state(system);
  const Workspace twice = accelerated(system, state), single = accelerated(once, state);
  EXPECT_EQ(twice.solver.rank(), 3);
  EXPECT_LT((twice.a - single.a).norm(), 1e-11);
  // two equal constraints share the load equally, the least-squares solution
  EXPECT_LT((twice.multipliers.head(3) - single.multipliers / 2).norm(), 1e-11);
  EXPECT_LT((twice.multipliers.tail(3) - single.multipliers / 2).norm(), 1e-11);
}

TEST(ConstraintSolver, RankIsIndependentOfUnits) {
  // one row scaled by 1e-9 (a coupling in other units) is as independent as before
  Scene scene = chain(3, false, 0.2);
  scene.constraints = {{"tie", CoordinateCoupling{{{"h0"}, {"h1"}}, {1e-9, -1e-9}, constant(0)}},
                       {"other", CoordinateCoupling{{{"h1"}, {"h2"}}, {1e6, -1e6}, constant(0)}}};
  const System system = compiled(scene);
  const Workspace w = accelerated(system, system.initial);
  EXPECT_EQ(w.solver.rank(), 2);
  EXPECT_NEAR(w.a[0], w.a[1], 1e-12);
  EXPECT_NEAR(w.a[1], w.a[2], 1e-12);
}

TEST(ConstraintSolver, NamesTheRowsBehindADependentOne) {
  Scene scene = chain(3, false, 0.2);
  scene.constraints = {{"first", CoordinateCoupling{{{"h0"}, {"h1"}}, {1, -1}, constant(0)}},
                       {"second", CoordinateCoupling{{{"h1"}, {"h2"}}, {1, -1}, constant(0)}},
                       {"sum", CoordinateCoupling{{{"h0"}, {"h2"}}, {1, -1}, constant(0)}}};
  const System system = compiled(scene);
  const Workspace w = accelerated(system, system.initial);
  ASSERT_EQ(w.solver.rank(), 2);
  const int dependent = w.solver.order()[2];
  std::vector<std::string> others = w.solver.rows_behind(dependent);
  EXPECT_EQ(others.size(), 2u);
  EXPECT_TRUE(w.solver.rows_behind(w.solver.order()[0]).empty());
}

}  // namespace
}  // namespace borelli::test
