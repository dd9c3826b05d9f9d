// Fixed-step methods for long runs, beyond their order (method_orders_test.cpp): Verlet's reversibility with
// a changing mass matrix and orientation, energy without drift, and stiffness for implicit methods.
#include "dynamics/methods/splitting.hpp"

#include <cmath>

#include "dynamics/methods/motion_flow.hpp"
#include "scenes.hpp"

namespace borelli::test {
namespace {

State after(const System& system, const std::string& method, State state, double step, int steps) {
  Workspace workspace(system);
  MotionFlow motion(system, {}, workspace);
  const auto integrator = need(make_integrator(method, 1));
  Work work(system.groups);
  Eigen::VectorXd y(motion.size()), dy(motion.size()), out(motion.size());
  for (int i = 0; i < steps; ++i) {
    EXPECT_TRUE(motion.start(state, work, y, dy));
    EXPECT_TRUE(integrator->attempt(motion, state.t, step, y, dy, out).evaluated);
    motion.take(out, state, work);
    state.t += step;
  }
  return state;
}

TEST(VelocityVerlet, IsReversible) {
  // hinges, slides and balls in a tree: the mass matrix changes, accelerations depend on velocities
  const System system = compiled(random_tree(4, {.balls = true}));
  State start = Random(3).state(system);
  const State there = after(system, "verlet", start, 1e-3, 200);
  const State back = after(system, "verlet", there, -1e-3, 200);
  EXPECT_GT((there.q - start.q).norm(), 0.1);
  // rounding of 400 steps, and the tolerance of the half steps
  EXPECT_LT((back.q - start.q).norm(), 1e-11);
  EXPECT_LT((back.v - start.v).norm(), 1e-10);
  // a method that is not reversible returns with an error
  EXPECT_GT((after(system, "rk2", after(system, "rk2", start, 1e-3, 200), -1e-3, 200).q - start.q).norm(),
            1e-8);
}

TEST(LongRuns, KeepEnergyWithoutDrift) {
  // a pendulum of two links over about 300 swings in steps of a hundredth: the energy error of Runge-Kutta
  // grows with time, that of reversible methods does not
  Scene scene = chain(2, false, 0.4);
  const System system = compiled(scene);
  const auto drifts = [&](const char* method) {
    const double early = run(system, settings(method, 20, 0.02)).certificate.energy_drift;
    return std::pair(early, run(system, settings(method, 400, 0.02)).certificate.energy_drift);
  };
  const auto rk4 = drifts("rk4");
  EXPECT_GT(rk4.second, 10 * rk4.first);
  for (const char* method : {"verlet", "implicit_midpoint", "gauss4"}) {
    const auto [early, late] = drifts(method);
    EXPECT_LT(late, 2 * early) << method;
  }
}

TEST(StiffScenes, AreStableWithImplicitMethods) {
  // rk4 blows up on this one (Failure.DivergenceUnderAFixedStepNamesItsTime): 1e8 N m/rad, damped
  Scene scene = chain(1, false, 0.1);
  scene.efforts = {{"stiff", CoordinateSpring{{"h0"}, 1e8, 1e6, 0}}};
  const System system = compiled(scene);
  for (const char* method : {"implicit_midpoint", "gauss4", "gauss6"}) {
    const auto out = simulate(system, system.initial, settings(method, 1, 0.01));
    ASSERT_TRUE(out) << method << ": " << out.error().message();
    // creeps to rest: its slow rate is k / c = 100 / s
    EXPECT_LT(std::abs(last(out->q)[0]), 0.1) << method;
  }
  const auto verlet = simulate(system, system.initial, settings("verlet", 1, 0.01));
  ASSERT_FALSE(verlet);
  EXPECT_NE(verlet.error().what.find("the half step of the velocity did not converge"), std::string::npos)
      << verlet.error().what;
}

}  // namespace
}  // namespace borelli::test
