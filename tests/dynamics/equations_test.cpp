// Solving the equations at one state: power balance, faults by name, and no allocation.
#include "dynamics/equations/equations.hpp"

#include "allocation_count.hpp"
#include "dynamics/constraints/local_coordinates.hpp"
#include "scenes.hpp"

namespace borelli::test {
namespace {

/// A tree with drives, springs and constraints.
Scene everything() {
  Scene scene = random_tree(6, {.balls = true, .drives = true});
  scene.efforts = {{"spring", PointSpring{{"s3", {0.1, 0, 0}}, {"world", {1, 0, 0}}, 20, 1, 0.1}},
                   {"twist", TorsionSpring{{"s4"}, {"s5"}, 3, 0.5, {0, 0, 0}}},
                   {"coordinate", CoordinateSpring{{"c20"}, 3, 0.1, 0}},
                   {"push", Force{{"s2", {0, 0, 0}}, {1, 2, 3}, Axes::solid, Sine{}, {}}}};
  scene.constraints = {
      {"plane", PointOnPlane{{"s5", {0.2, 0, 0}}, {{"world", {0, 0, 0}}, {0, 0, 1}}, Sine{0.1, 2, 0, 0}}},
      {"rod", Distance{{"s3", {0, 0, 0.1}}, {"s1", {1, 0, 0}}, constant(1)}}};
  return scene;
}

TEST(Equations, EvaluationsDoNotAllocate) {
#ifndef BORELLI_COUNTS_ALLOCATIONS
  GTEST_SKIP() << "a sanitizer has its own allocator";
#else
  Scene scene = everything();
  for (const bool dependent : {false, true}) {
    if (dependent) {  // a dependent row uses the solver's other path, which allocates once
      scene.constraints.push_back(scene.constraints[0]);
      scene.constraints.back().name = "again";
    }
    const System system = compiled(scene);
    const State state = Random(3).state(system);
    Workspace w(system);
    const auto solve = [&](double t) {
      return accelerate(system, system.parameters, t, state.q.data(), state.v.data(), {}, w);
    };
    if (dependent) {
      ASSERT_FALSE(solve(0));
    }
    const long before = allocation_count;
    for (int i = 0; i < 3; ++i) ASSERT_FALSE(solve(0.1 * i));
    EXPECT_EQ(allocation_count, before) << dependent;
  }
#endif
}

// d(kinetic + potential)/dt, by differences along the solved motion, is the sum of the powers.
TEST(Equations, PowerEqualsTheRateOfEnergy) {
  const System system = compiled(everything());
  for (unsigned seed = 0; seed < 5; ++seed) {
    State state = Random(seed).state(system);
    state.t = 0.2;
    Workspace w(system);
    ASSERT_FALSE(accelerate(system, system.parameters, state.t, state.q.data(), state.v.data(), {}, w));
    const Powers power = w.power;
    const Eigen::VectorXd a = w.a;
    const auto energy = [&](double s) {
      Eigen::VectorXd q = state.q;
      const Eigen::VectorXd x = s * state.v + s * s / 2 * a, v = state.v + s * a;
      from_local_coordinates(system, state.q.data(), x.data(), q.data());
      EXPECT_FALSE(update_terms(system, system.parameters, state.t + s, q.data(), v.data(), w));
      return w.terms.kinetic + w.terms.potential;
    };
    const double h = 1e-5, rate = (energy(h) - energy(-h)) / (2 * h);
    // differences: h^2 times the third derivative, rounding of about 100 J over h
    EXPECT_NEAR(power.total(), rate, 1e-6 * (1 + std::abs(rate))) << seed;
    EXPECT_NE(power.drives, 0);
    EXPECT_NE(power.constraints, 0);
  }
}

TEST(Equations, BaumgarteAddsItsRestoringAccelerations) {
  const System system = compiled(everything());
  const State state = Random(3).state(system);
  Workspace w(system);
  RowHandling handling{.decide_rank = true, .alpha = 3, .beta = 4};
  ASSERT_FALSE(accelerate(system, system.parameters, 0.1, state.q.data(), state.v.data(), handling, w));
  const Eigen::VectorXd second = w.rows.L.leftCols(system.nv) * w.a + w.rows.E;
  EXPECT_LT((second + 6 * w.rows.rate + 16 * w.rows.h).norm(), 1e-10 * (1 + second.norm()));
}

TEST(Equations, NamesASingularMassMatrix) {
  // a point mass on the axis of its own hinge: there is mass, but none moves
  Scene scene;
  scene.solids = {
      solid("arm", "world", {hinge("lift", Vector3d::UnitY())}, {link()}),
      solid("bead", "arm", {hinge("spin", Vector3d::UnitZ())}, {inertial(1, {0, 0, 1}, {0, 0, 0})})};
  const Result<Trajectory> out = simulate(compiled(scene));
  ASSERT_FALSE(out);
  EXPECT_EQ(out.error().where, "coordinate 'spin'");
  EXPECT_NE(out.error().what.find("mass matrix is singular at t = 0 s"), std::string::npos)
      << out.error().what;
}

TEST(Equations, NamesAnAccelerationThatIsNotANumber) {
  Scene scene = chain(2, false);
  scene.efforts = {
      {"push", Force{{"l1", {0, 0, -1}}, {1e300, 0, 0}, Axes::world, Polynomial{{0, 0, 0, 1e300}}, {}}}};
  const System system = compiled(scene);
  Workspace w(system);
  const Fault fault =
      accelerate(system, system.parameters, 2, system.initial.q.data(), system.initial.v.data(), {}, w);
  EXPECT_EQ(fault.kind, Fault::Kind::not_finite);
  EXPECT_EQ(describe(system, fault, 2).where, "coordinate 'h0'");
}

}  // namespace
}  // namespace borelli::test
