// The examples of docs/adding_a_kind.md, taken from the page: they compile, are short, and work as described.
#include <fstream>

#include "dynamics/constraints/local_coordinates.hpp"
#include "dynamics/equations/passes.hpp"
#include "dynamics/methods/heun.hpp"
#include "dynamics/methods/motion_flow.hpp"
#include "dynamics/numbers/dual.hpp"
#include "dynamics/scene/constraint_same_height.hpp"
#include "dynamics/scene/effort_attraction.hpp"
#include "dynamics/scene/switch_swing.hpp"
#include "scenes.hpp"
#include "tests/paths.hpp"

namespace borelli::test {
namespace {

TEST(AddingAKind, ExamplesHaveFewerThanFortyLines) {
  for (const char* name :
       {"scene/switch_swing", "scene/effort_attraction", "scene/constraint_same_height", "methods/heun"}) {
    std::ifstream file(test::doc_examples() + "/dynamics/" + name + ".hpp");
    int lines = 0;
    for (std::string line; std::getline(file, line);) ++lines;
    EXPECT_GT(lines, 10) << name;
    EXPECT_LT(lines, 40) << name;
  }
}

TEST(AddingAKind, SwitchRotatesAboutItsPoint) {
  Random random(3);
  const Swing swing{random.direction(), random.vector(1)};
  const Pose X_WA{rotation_matrix(random.turn()), random.vector(1)};
  const double angle = 0.7;
  // there, round, and back
  const Pose there{Matrix3d::Identity(), swing.point}, back{Matrix3d::Identity(), -swing.point};
  const Pose expected = X_WA * there * Pose{rotation_about(swing.axis, angle), Vector3d::Zero()} * back;
  PoseOf<DualNumber> X{X_WA.R.cast<DualNumber>(), X_WA.p.cast<DualNumber>()};
  DualNumber q(angle);
  q.d[0] = 1;
  Eigen::Vector3<DualNumber> angular, linear;
  swing.advance(&q, X, &angular, &linear);
  Matrix3d R, R_rate;
  Vector3d p, p_rate, w, v;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) R(i, j) = X.R(i, j).value, R_rate(i, j) = X.R(i, j).d[0];
    p[i] = X.p[i].value, p_rate[i] = X.p[i].d[0];
    w[i] = angular[i].value, v[i] = linear[i].value;
  }
  EXPECT_LT((R - expected.R).norm() + (p - expected.p).norm(), 1e-14);
  // its twist is the rate of its pose
  EXPECT_LT((p_rate - v).norm(), 1e-14);
  for (int i = 0; i < 3; ++i) EXPECT_LT((R_rate.col(i) - w.cross(R.col(i))).norm(), 1e-14);
}

TEST(AddingAKind, EffortIsTheGradientOfItsPotential) {
  Scene scene = random_tree(4, {.balls = true});
  const Attraction kind{{"s3", {0.1, 0.2, 0.3}}, {"s5", {1, 0, 0}}, 2};
  scene.efforts = {{"place", PointSpring{kind.a, kind.b, 0, 0, 0}}};  // the same sites
  const System system = compiled(scene);
  const State state = Random(5).state(system);
  Kinematics kinematics(system);
  const auto sums_at = [&](double s) {
    Eigen::VectorXd q = state.q;
    from_local_coordinates(system, state.q.data(), Eigen::VectorXd(s * state.v).data(), q.data());
    update_kinematics(system, system.parameters, 0, q.data(), state.v.data(), kinematics);
    EffortSums sums(system);
    EffortPass<double> pass(system, system.parameters, kinematics, sums);
    pass.turn_to(system.efforts[0]);
    kind.apply(pass);
    return sums;
  };
  // central differences: h^2 times third derivatives (about 100), and rounding / h
  const double h = 1e-5, slope = (sums_at(h).potential - sums_at(-h).potential) / (2 * h);
  const EffortSums now = sums_at(0);
  double power = 0;
  for (std::size_t b = 1; b < system.bodies.size(); ++b)
    power += now.force[b].dot(kinematics.bodies[b].v) + now.moment[b].dot(kinematics.bodies[b].w);
  EXPECT_NEAR(power, -slope, 2e-7);
  EXPECT_GT(std::abs(power), 0.01);
}

TEST(AddingAKind, ConstraintRowIsTheGradientOfItsHeight) {
  Scene scene = random_tree(4, {.balls = true});
  const SameHeight kind{{"s3", {0.1, 0.2, 0.3}}, {"s5", {1, 0, 0}}};
  scene.constraints = {{"place", Distance{kind.a, kind.b, constant(1)}}};  // the same sites, one row
  const System system = compiled(scene);
  const State state = Random(5).state(system);
  const auto rows_at = [&](const Eigen::VectorXd& x) {
    Eigen::VectorXd q = state.q;
    from_local_coordinates(system, state.q.data(), x.data(), q.data());
    Kinematics kinematics(system);
    update_kinematics(system, system.parameters, 0, q.data(), state.v.data(), kinematics);
    ConstraintRows rows(system);
    ConstraintPass<double> pass(system, system.parameters, kinematics, rows);
    pass.turn_to(system.constraints[0]);
    kind.evaluate(pass);
    rows.rate = rows.L * kinematics.u;
    return rows;
  };
  // central differences: h^2 times third derivatives (about 100), and rounding / h
  const double h = 1e-5, tolerance = 2e-7;
  const ConstraintRows now = rows_at(Eigen::VectorXd::Zero(system.nv));
  for (int i = 0; i < system.nv; ++i) {
    const Eigen::VectorXd x = h * Eigen::VectorXd::Unit(system.nv, i);
    EXPECT_NEAR(now.L(0, i), (rows_at(x).h[0] - rows_at(-x).h[0]) / (2 * h), tolerance);
  }
  const Eigen::VectorXd x = h * state.v;
  EXPECT_NEAR(now.E[0], (rows_at(x).rate[0] - rows_at(-x).rate[0]) / (2 * h), tolerance);
}

TEST(AddingAKind, IntegratorIsOfSecondOrder) {
  Scene scene = chain(2, true, 0.5);
  const System system = compiled(scene);
  const auto end = [&](Integrator& integrator, int steps) {
    Workspace workspace(system);
    MotionFlow motion(system, system.settings, workspace);
    State state = system.initial;
    Work work(system.groups);
    Eigen::VectorXd y(motion.size()), dy(motion.size()), out(motion.size());
    for (int i = 0; i < steps; ++i) {
      EXPECT_TRUE(motion.start(state, work, y, dy));
      EXPECT_TRUE(integrator.attempt(motion, state.t, 1.0 / steps, y, dy, out).evaluated);
      motion.take(out, state, work);
      state.t += 1.0 / steps;
    }
    return state.q;
  };
  const auto fine = need(make_integrator("dop853", 1));
  const Eigen::VectorXd reference = end(*fine, 200);
  Heun heun;
  EXPECT_NEAR(order((end(heun, 200) - reference).norm(), (end(heun, 400) - reference).norm()), 2, 0.1);
}

}  // namespace
}  // namespace borelli::test
