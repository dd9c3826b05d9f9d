// The order table: every method's observed order on whole scenes, by halving equal steps. Scenes: a pendulum
// (one angle), a free solid (orientation), IFToMM's A01 (a point on a circle) and Chaplygin's sleigh, the
// last two with projection and with Baumgarte.
#include <algorithm>
#include <cmath>

#include "dynamics/methods/motion_flow.hpp"
#include "dynamics/numbers/rotation_vector.hpp"
#include "dynamics/run/step_path.hpp"
#include "scenes.hpp"

namespace borelli::test {
namespace {

struct Row {
  const char* method;
  double order;
  int steps;  ///< so many that the next order's term is small, and so few that rounding is smaller
};
// gbs in equal steps with an infinite tolerance ends at its second row, of order 4, or at its third if it
// computes rows in parallel (scenes without constraint rows); a real tolerance leads to higher rows
const Row table[] = {{"euler", 1, 4096},
                     {"rk2", 2, 512},
                     {"rk4", 4, 256},
                     {"rk4_adaptive", 5, 64},
                     {"dopri5", 5, 128},
                     {"dop853", 8, 16},
                     {"gbs", 4, 512},
                     {"gbs4", 4, 512},
                     {"gbs6", 6, 48},
                     {"gbs8", 8, 16},
                     {"semi_implicit_euler", 1, 4096},
                     {"verlet", 2, 512},
                     {"implicit_midpoint", 2, 512},
                     {"gauss4", 4, 64},
                     {"gauss6", 6, 12},
                     {"generalized_alpha", 2, 512},
                     {"moreau", 2, 512},
                     {"arkode", 4, 16}};

TEST(MethodOrders, EveryMethodIsInTheTable) {
  std::vector<std::string> names;
  for (const Row& row : table) names.emplace_back(row.method);
  names.insert(names.end() - 1, "cvode");  // chooses its steps and orders itself; accuracy_test.cpp runs it
  // gauss16 has order 16, which rounding hides here; collocation_test.cpp tests it
  names.insert(std::find(names.begin(), names.end(), "gbs8") + 1, "gauss16");
  EXPECT_EQ(names, integrator_names());
}

/// Runs from the scene's start to `end` in equal steps, whatever error the method estimates.
State in_equal_steps(const System& system, const std::string& method, double end, int steps,
                     ConstraintTreatment treatment) {
  SimulationSettings how;
  how.constraints = treatment;
  Workspace workspace(system), probe(system);
  MotionFlow motion(system, how, workspace);
  const auto integrator = need(make_integrator(method, 1e9));
  StepPath path(system, how, motion, *integrator, &probe);
  Landing landing(system);
  landing.state = system.initial;
  need(assemble(system, system.parameters, landing.state, workspace));
  Eigen::VectorXd y(motion.size()), dy(motion.size()), out(motion.size());
  for (int i = 0; i < steps; ++i) {
    const double t = landing.state.t, next = end * (i + 1) / steps;
    if (method != "generalized_alpha") integrator->reset();  // generalized_alpha keeps its own accelerations
    EXPECT_TRUE(motion.start(landing.state, landing.work, y, dy));
    EXPECT_TRUE(integrator->attempt(motion, t, next - t, y, dy, out).evaluated);
    const Work work = landing.work;
    path.begin(t, next - t, y, dy, out, work);
    EXPECT_TRUE(path.land_at_end(next, landing));
  }
  return landing.state;
}

// ---- the scenes, each with an error at the end ----

struct Case {
  const char* name;
  System system;
  ConstraintTreatment treatment;
  double end;
  State reference;
  double error(const std::string& method, int steps) const {
    const State state = in_equal_steps(system, method, end, steps, treatment);
    return (state.q - reference.q).norm() + (reference.v.size() ? (state.v - reference.v).norm() : 0);
  }
};

// A point on a hinge, 1 m below it, from rest at `start`: theta = 2 asin(k sn(K(k) + w t)), k = sin(start /
// 2), with sn by the arithmetic-geometric mean (Abramowitz and Stegun, 16.4).
double pendulum_angle(double start, double t) {
  const double k = std::sin(start / 2), w = std::sqrt(9.81);
  const double u = std::comp_ellint_1(k) + w * t;
  double a[20] = {1}, c[20] = {k}, b = std::sqrt(1 - k * k);
  int n = 0;
  while (std::abs(c[n]) > 1e-17 && n < 19) {
    a[n + 1] = (a[n] + b) / 2;
    c[n + 1] = (a[n] - b) / 2;
    b = std::sqrt(a[n] * b);
    ++n;
  }
  double phi = std::ldexp(a[n] * u, n);
  for (; n > 0; --n) phi = (phi + std::asin(c[n] / a[n] * std::sin(phi))) / 2;
  return 2 * std::asin(k * std::sin(phi));
}

Case pendulum() {
  Scene scene;
  scene.solids = {
      solid("bob", "world", {hinge("swing", Vector3d::UnitY(), 2)}, {inertial(1, {0, 0, -1}, {0, 0, 0})})};
  Case out{"pendulum", compiled(scene), {}, 1, {}};
  const double angle = pendulum_angle(2, out.end);
  out.reference.q = Eigen::VectorXd::Constant(1, angle);
  // moving down to the other side; speed by energy
  out.reference.v = Eigen::VectorXd::Constant(1, -std::sqrt(2 * 9.81 * (std::cos(angle) - std::cos(2.0))));
  return out;
}

// Symmetric and free of torques: its closed form is that of simulate_test.cpp (Landau and Lifshitz, section
// 35).
Case free_solid() {
  const double I1 = 1, I3 = 1.6, t = 2;
  const Vector3d w(1, 0, 5), L(I1 * w[0], 0, I3 * w[2]);
  Scene scene;
  scene.gravity.setZero();
  scene.solids = {solid("top", "world", {ball("turn", identity_quaternion(), w)},
                        {inertial(1, {0, 0, 0}, {I1, I1, I3})})};
  const auto turn = [](const Vector3d& axis, double angle) { return exponential(angle * axis); };
  Case out{"free solid", compiled(scene), {}, t, {}};
  out.reference.q =
      product(turn(L.normalized(), L.norm() / I1 * t), turn(Vector3d::UnitZ(), -(I3 - I1) / I1 * w[2] * t));
  return out;
}

// IFToMM's A01 to 0.7 s, its angle from below the closed form of the pendulum's from pi/2.
Case point_on_circle(ConstraintTreatment treatment) {
  Scene scene;
  scene.solids = {solid("point", "world",
                        {slide("x", Vector3d::UnitX(), -1), slide("z", Vector3d::UnitZ(), 0)},
                        {inertial(1, {0, 0, 0}, {0, 0, 0})})};
  scene.constraints = {{"rod", Distance{{"point", {0, 0, 0}}, {"world", {0, 0, 0}}, constant(1)}}};
  Case out{treatment == ConstraintTreatment::projection ? "point on a circle, projected"
                                                        : "point on a circle, Baumgarte",
           compiled(scene),
           treatment,
           0.7,
           {}};
  const double angle = pendulum_angle(M_PI / 2, out.end);
  out.reference.q = Eigen::Vector2d(-std::sin(angle), -std::cos(angle));
  return out;
}

// Chaplygin's sleigh (kinematic_constraints_test.cpp has its closed form), pushed forwards while it turns.
Case sleigh(ConstraintTreatment treatment) {
  Scene scene;
  scene.gravity.setZero();
  scene.solids = {solid("sleigh", "world",
                        {slide("x", Vector3d::UnitX(), 0, 1), slide("y", Vector3d::UnitY()),
                         hinge("heading", Vector3d::UnitZ(), 0, 3)},
                        {inertial(2, {0.5, 0, 0}, {0.25, 0.25, 0.5})})};
  scene.constraints = {{"blade", KnifeEdge{{"sleigh", {0, 0, 0}}, {0, 1, 0}, {"world"}}}};
  Case out{treatment == ConstraintTreatment::projection ? "sleigh, projected" : "sleigh, Baumgarte",
           compiled(scene),
           treatment,
           1,
           {}};
  out.reference = in_equal_steps(out.system, "dop853", out.end, 200, treatment);
  return out;
}

TEST(MethodOrders, AreReachedOnEveryScene) {
  for (const Case& one : {pendulum(), free_solid(), point_on_circle(ConstraintTreatment::projection),
                          point_on_circle(ConstraintTreatment::baumgarte),
                          sleigh(ConstraintTreatment::projection), sleigh(ConstraintTreatment::baumgarte)})
    for (Row row : table) {
      if (std::string_view(row.method) == "gbs" && one.system.rows == 0) row = {"gbs", 6, 48};
      if (need(make_integrator(row.method, 1e9))->objection(one.system, one.treatment)) continue;  // refused
      const double coarse = one.error(row.method, row.steps), fine = one.error(row.method, 2 * row.steps);
      // the next order's term at these steps
      EXPECT_NEAR(order(coarse, fine), row.order, 0.1 * row.order)
          << row.method << ", " << one.name << ": " << coarse << " and " << fine;
    }
}

}  // namespace
}  // namespace borelli::test
