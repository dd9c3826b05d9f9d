// Whole runs against references: the paper's roundabout, tops, pendulums, a constrained point, springs;
// orders by step halving.
#include "dynamics/run/simulate.hpp"

#include <cmath>

#include "scenes.hpp"

namespace borelli::test {
namespace {

// ---- the paper's roundabout ----

// End state at 5 s with the benchmark scene's masses; two different methods agree to at least 8 digits.
const Vector3d roundabout_q(36.589803206456790, -.491961391081574, .009149081659433);
const Vector3d roundabout_v(7.73755291360600, 12.9839351301372, -9.92117999987793);

TEST(Roundabout, ReachesTheReferenceState) {
  const Trajectory end = run(roundabout(), settings("rk4_adaptive", 5, 0.01, 1e-11));
  // the tolerance, added up over a thousand steps, times the growth of errors over 5 s
  EXPECT_LT((last(end.q) - roundabout_q).norm(), 1e-8);
  EXPECT_LT((last(end.v) - roundabout_v).norm(), 1e-7);
  EXPECT_TRUE(end.certificate.trusted) << end.certificate.reason;
}

TEST(Roundabout, DistrustsEulerAndTrustsRungeKutta) {  // the paper's figures 2 and 4, dt = 0.01
  const Certificate euler = run(roundabout(), settings("euler", 5, 0.01)).certificate;
  EXPECT_FALSE(euler.trusted);
  EXPECT_NE(euler.reason.find("the energy balance of 's1' and the solids tied to it has an error of"),
            std::string::npos)
      << euler.reason;
  EXPECT_LT(euler.reason_time, 1);  // found early
  const Certificate rk4 = run(roundabout(), settings("rk4", 5, 0.01)).certificate;
  EXPECT_TRUE(rk4.trusted) << rk4.reason;
  EXPECT_EQ(rk4.steps_accepted, 500);
  EXPECT_EQ(rk4.evaluations, 2001);
  const Certificate rk2 = run(roundabout(), settings("rk2", 5, 0.01)).certificate;
  EXPECT_LT(100 * rk4.energy_drift, rk2.energy_drift);  // 1.2e-4, 0.12 and 8.9 J of 99 J
  EXPECT_LT(10 * rk2.energy_drift, euler.energy_drift);
}

TEST(Roundabout, MethodsReachTheirOrders) {
  const System system = compiled(roundabout());
  const auto error = [&](const char* method, double step) {
    const Trajectory end = run(system, settings(method, 1, step));
    static const Trajectory reference = run(system, settings("rk4", 1, 1e-4));  // error below 1e-12
    return (last(end.q) - last(reference.q)).norm();
  };
  // steps at which the next order's share is below a tenth
  EXPECT_NEAR(order(error("euler", 2e-4), error("euler", 1e-4)), 1, 0.1);
  EXPECT_NEAR(order(error("rk2", 2e-3), error("rk2", 1e-3)), 2, 0.1);
  EXPECT_NEAR(order(error("rk4", 4e-3), error("rk4", 2e-3)), 4, 0.1);
}

// ---- chains ----

TEST(Chain, ReachesTheReferenceStates) {
  // end states at 10 s of the benchmark scenes chain3d2 and chain3d7: hinges about y and x in turn (8 digits
  // and more)
  const System two = compiled([] {
    Scene scene = chain(2, true);
    scene.solids[0].switches[0].q = {1};
    scene.solids[1].switches[1].q = {.7};
    return scene;
  }());
  const Trajectory end2 = run(two, settings("rk4_adaptive", 10, 0.01, 1e-12));
  EXPECT_LT((last(end2.q) - Eigen::Vector2d(.805048150457940, -.638326467639700)).norm(), 1e-8);
  EXPECT_LT((last(end2.v) - Eigen::Vector2d(-1.53027089632793, 1.08898678404824)).norm(), 1e-8);

  // seven links are chaotic: errors grow about 1e4-fold in 10 s
  const Trajectory end7 = run(compiled(chain(7, true, 0.4)), settings("rk4_adaptive", 10, 0.01, 1e-12));
  Eigen::VectorXd q(7);
  q << -.034795237167082, -.302990797470372, .356588974290199, -.005923977175612, -.126215354480326,
      .080712222957669, -.141851520735710;
  EXPECT_LT((last(end7.q) - q).norm(), 1e-7);
}

// ---- tops: orientation at full order ----

Scene free_top(const Vector3d& moments, const Vector3d& w) {
  Scene scene;
  scene.gravity.setZero();
  scene.solids = {
      solid("top", "world", {ball("turn", identity_quaternion(), w)}, {inertial(1, {0, 0, 0}, moments)})};
  return scene;
}

double orientation_error(const Quaternion& q, const Matrix3d& R) {
  return (rotation_matrix(q) - R).norm() / std::sqrt(2.0);  // the angle between them, if small
}

// A torque-free symmetric solid (Landau and Lifshitz, Mechanics, section 35): it turns about the angular
// momentum L at the rate L / I1 while it turns back about its own axis at (I3 - I1) / I1 w3.
TEST(FreeTop, RotatesAsInClosedFormAtEachMethodsOrder) {
  const double I1 = 1, I3 = 1.6, t = 2;
  const Vector3d w(1, 0, 5);
  const Vector3d L(I1 * w[0], 0, I3 * w[2]);
  const double own = (I3 - I1) / I1 * w[2];
  const Matrix3d R =
      rotation_about(L.normalized(), L.norm() / I1 * t) * rotation_about(Vector3d::UnitZ(), -own * t);
  const Vector3d w_end(w[0] * std::cos(own * t), w[0] * std::sin(own * t), w[2]);
  const System system = compiled(free_top({I1, I1, I3}, w));
  const auto errors = [&](const char* method, double step) {
    const Trajectory end = run(system, settings(method, t, step));
    EXPECT_NEAR(last(end.q).norm(), 1, 1e-15);  // the quaternion stays unit
    return std::pair(orientation_error(last(end.q), R), (last(end.v) - w_end).norm());
  };
  for (const auto& [method, step, expected] :
       {std::tuple("euler", 1e-3, 1.0), {"rk2", 1e-2, 2.0}, {"rk4", 2e-2, 4.0}}) {
    const auto coarse = errors(method, step), fine = errors(method, step / 2);
    EXPECT_NEAR(order(coarse.first, fine.first), expected, 0.1) << method;
    EXPECT_NEAR(order(coarse.second, fine.second), expected, 0.1) << method;
  }
}

TEST(FreeTop, KeepsEnergyAndAngularMomentumThroughDzhanibekovsFlips) {
  const Trajectory trajectory =
      run(free_top({1, 2, 3}, {1e-3, 10, 1e-3}), settings("rk4_adaptive", 10, 0.01, 1e-12));
  bool flipped = false;
  SimulationSettings fine = settings("rk4_adaptive", 10, 0.01, 1e-12);
  fine.output_interval = 0.05;
  const Trajectory path = run(free_top({1, 2, 3}, {1e-3, 10, 1e-3}), fine);
  for (Eigen::Index i = 0; i < path.v.rows(); ++i) flipped = flipped || path.v(i, 1) < -9;
  EXPECT_TRUE(flipped);
  EXPECT_LT(trajectory.certificate.energy_drift, 1e-10 * trajectory.certificate.energy_turnover);
  ASSERT_EQ(trajectory.certificate.conserved.size(), 1u);
  EXPECT_LT(trajectory.certificate.conserved[0].drift, 1e-10 * trajectory.certificate.conserved[0].scale);
}

// Heavy top of Arnold and Bruels (Multibody System Dynamics 18, 2007): 15 kg, centre 1 m from the fixed
// point, inertia about it diag(15.234375, .46875, 15.234375). The centre at t = 2 s as published and checked
// by an eighth-order method.
TEST(HeavyTop, ReachesItsReferenceAtFourthOrder) {
  Scene scene;
  scene.solids = {solid("top", "world", {ball("turn", identity_quaternion(), {0, 150, -4.61538})},
                        {inertial(15, {0, 1, 0}, {0.234375, 0.46875, 0.234375})})};
  const Vector3d centre(-.15041682275, -.72416559164, -.67302226956);
  const System system = compiled(scene);
  const auto error = [&](const SimulationSettings& how) {
    return (Vector3d(last(run(system, how).gravity_centre)) - centre).norm();
  };
  EXPECT_LT(error(settings("rk4_adaptive", 2, 0.001, 1e-12)), 1e-9);
  // at 150 rad/s the order appears below a thirtieth of a radian per step: 3.67, 3.86, ...; a missing
  // commutator would give 2
  EXPECT_NEAR(order(error(settings("rk4", 2, 2.5e-4)), error(settings("rk4", 2, 1.25e-4))), 4, 0.2);
}

// ---- pendulums ----

TEST(Pendulum, ReturnsAfterItsPeriod) {
  const double angle = 2.5, l = 0.7;
  Scene scene;
  scene.solids = {solid("bob", "world", {hinge("swing", Vector3d::UnitY(), angle)},
                        {inertial(2, {0, 0, -l}, {0, 0, 0})})};
  const double period = 4 * std::comp_ellint_1(std::sin(angle / 2)) * std::sqrt(l / 9.81);
  const Trajectory end = run(scene, settings("rk4_adaptive", period, 0.01, 1e-12));
  // at rest there, so an error of the velocity shows the error of the period
  EXPECT_NEAR(last(end.q)[0], angle, 1e-10);
  EXPECT_NEAR(last(end.v)[0], 0, 1e-9);
}

// IFToMM benchmark A01: a point of 1 kg held on a circle of 1 m by a constraint; the period and the place at
// 10 s are closed forms in elliptic functions.
Scene constrained_point(double x, double z) {
  Scene scene;
  scene.solids = {solid("point", "world",
                        {slide("x", Vector3d::UnitX(), x), slide("z", Vector3d::UnitZ(), z)},
                        {inertial(1, {0, 0, 0}, {0, 0, 0})})};
  scene.constraints = {{"rod", Distance{{"point", {0, 0, 0}}, {"world", {0, 0, 0}}, constant(1)}}};
  return scene;
}
const Eigen::Vector2d a01(-.275087462576117, -.961419205099125);

TEST(ConstrainedPoint, ReachesItsReferenceWithProjection) {
  const Trajectory end = run(constrained_point(-1, 0), settings("rk4_adaptive", 10, 0.01, 1e-12));
  EXPECT_LT((last(end.q) - a01).norm(), 1e-9);
  EXPECT_TRUE(end.certificate.trusted) << end.certificate.reason;
  EXPECT_LT(end.certificate.residuals[0].position, 1e-12);
  EXPECT_LT(end.certificate.residuals[0].velocity, 1e-12);
}

TEST(ConstrainedPoint, KeepsTheMethodsOrderWithBothTreatments) {
  const System system = compiled(constrained_point(-1, 0));
  for (const auto treatment : {ConstraintTreatment::projection, ConstraintTreatment::baumgarte}) {
    const auto error = [&](const char* method, double step) {
      SimulationSettings how = settings(method, 10, step);
      how.constraints = treatment;
      return (last(run(system, how).q) - a01).norm();
    };
    // steps at which the next order's share is below a tenth
    EXPECT_NEAR(order(error("rk4", 1.25e-3), error("rk4", 6.25e-4)), 4, 0.1) << int(treatment);
    EXPECT_NEAR(order(error("rk2", 1.25e-3), error("rk2", 6.25e-4)), 2, 0.1) << int(treatment);
  }
}

TEST(ConstrainedPoint, MultiplierIsTheRodsTension) {
  SimulationSettings how = settings("rk4", 1, 0.01);
  how.output_interval = 0.1;
  const Trajectory path = run(constrained_point(-1, 0), how);
  for (Eigen::Index i = 0; i < path.q.rows(); ++i) {
    // m v^2 / l + m g cos of the angle from below, pulling inwards
    const double tension = path.v.row(i).squaredNorm() - 9.81 * path.q(i, 1);
    EXPECT_NEAR(path.multipliers(i, 0), -tension, 1e-9);
  }
}

// A pivot shaken fast holds a pendulum upside down if a^2 omega^2 > 2 g l (Kapitza 1951), for a << l.
TEST(Kapitza, StaysUprightOnlyAboveTheLimit) {
  const double a = 0.02, l = 1, g = 9.81;
  const auto largest_lean = [&](double over_limit) {
    const double omega = std::sqrt(over_limit * 2 * g * l) / a;
    Scene scene;
    scene.solids = {
        solid("pivot", "world", {driven(slide("shake", Vector3d::UnitZ()), Sine{a, omega, M_PI / 2, 0})}, {}),
        solid("bob", "pivot", {hinge("swing", Vector3d::UnitY(), M_PI + 0.05)},
              {inertial(1, {0, 0, -l}, {0, 0, 0})})};
    SimulationSettings how = settings("rk4_adaptive", 4, 0.001, 1e-8);
    how.output_interval = 0.02;
    const Trajectory path = run(scene, how);
    EXPECT_TRUE(path.certificate.trusted) << path.certificate.reason;
    return (path.q.array() - M_PI).abs().maxCoeff();
  };
  EXPECT_LT(largest_lean(2), 0.15);
  EXPECT_GT(largest_lean(0.5), 1);
}

// ---- energy ----

TEST(Springs, DampedMassDecaysAsInClosedForm) {
  const double m = 2, k = 50, c = 1.2, rest = 0.8, start = 1.3;
  Scene scene;
  scene.gravity.setZero();
  scene.solids = {
      solid("mass", "world", {slide("x", Vector3d::UnitX(), start)}, {inertial(m, {0, 0, 0}, {0, 0, 0})})};
  scene.efforts = {{"spring", PointSpring{{"mass", {0, 0, 0}}, {"world", {0, 0, 0}}, k, c, rest}}};
  const double t = 3, decay = c / (2 * m), omega = std::sqrt(k / m - decay * decay);
  const double x =
      (start - rest) * std::exp(-decay * t) * (std::cos(omega * t) + decay / omega * std::sin(omega * t));
  const Trajectory end = run(scene, settings("rk4_adaptive", t, 0.01, 1e-11));
  EXPECT_NEAR(last(end.q)[0], rest + x, 1e-9);
  const Certificate& certificate = end.certificate;
  EXPECT_TRUE(certificate.trusted) << certificate.reason;
  const double energy = end.kinetic.back() + end.potential.back(), at_start = 0.5 * k * 0.25;
  EXPECT_NEAR(certificate.work_efforts, energy - at_start, 1e-8);
  EXPECT_LT(certificate.work_efforts, 0);
}

TEST(Energy, BalanceHoldsAtTheMethodsOrder) {
  Scene scene = random_tree(6, {.balls = true, .drives = true});
  scene.efforts = {{"spring", PointSpring{{"s3", {0.1, 0, 0}}, {"world", {1, 0, 0}}, 20, 1, 0.1}},
                   {"twist", TorsionSpring{{"s4"}, {"s5"}, 3, 0.5, {0, 0, 0}}},
                   {"coordinate", CoordinateSpring{{"c20"}, 3, 0.1, 0}},
                   {"push", Force{{"s2", {0, 0, 0}}, {1, 2, 3}, Axes::solid, Sine{}, {}}}};
  scene.constraints = {
      {"plane", PointOnPlane{{"s5", {0.2, 0, 0}}, {{"world", {0, 0, 0}}, {0, 0, 1}}, Sine{0.1, 2, 0, 0}}}};
  const System system = compiled(scene);
  for (const auto treatment : {ConstraintTreatment::projection, ConstraintTreatment::baumgarte}) {
    const auto drift = [&](double step) {
      SimulationSettings how = settings("rk4", 1, step);
      how.constraints = treatment;
      const Certificate certificate = run(system, how).certificate;
      EXPECT_NE(certificate.work_efforts, 0);
      EXPECT_NE(certificate.work_drives, 0);
      EXPECT_NE(certificate.work_constraints, 0);
      return certificate.energy_drift;
    };
    EXPECT_NEAR(order(drift(0.01), drift(0.005)), 4, 0.7)
        << int(treatment);  // a maximum over the run wanders
  }
}

// ---- the paper's shock ----

// A cube falls along a rail with a bar hinged on it, whose far end is in a horizontal slide, until the bar
// stands upright and stops it. All of the fall's energy passes through the bar, 200 times lighter, within
// milliseconds (the paper's figures 5 to 8).
TEST(Shock, AdaptiveMethodCostsAThirtiethOfFixedSteps) {
  Scene scene;
  scene.solids = {solid("cube", "world", {slide("height", Vector3d::UnitZ())},
                        {inertial(200, {0, 0, 0}, 200 * 0.16 / 6 * Vector3d::Ones())}),
                  solid("bar", "cube", {hinge("tilt", Vector3d::UnitY(), M_PI / 2)},
                        {inertial(1, {0, 0, 0.5}, {1.0 / 12, 1.0 / 12, 0})})};
  scene.constraints = {
      {"slide", PointOnPlane{{"bar", {0, 0, 1}}, {{"world", {0, 0, 0}}, {0, 0, 1}}, constant(0)}}};
  const System system = compiled(scene);
  const Certificate adaptive = run(system, settings("rk4_adaptive", 5, 1e-3, 1e-6)).certificate;
  EXPECT_TRUE(adaptive.trusted) << adaptive.reason;
  EXPECT_GT(adaptive.steps_rejected, 0);
  EXPECT_LT(adaptive.smallest_step, 1e-4);  // while the bar stands upright
  // a fixed step with thirty times the evaluations (10.8 thousand) is still fifty times worse: 0.07 J and
  // 0.0013 J
  const Certificate fixed_step = run(system, settings("rk4", 5, 5.0 / 64800)).certificate;
  EXPECT_GT(fixed_step.evaluations, 29 * adaptive.evaluations);
  EXPECT_GT(fixed_step.energy_drift, 10 * adaptive.energy_drift);
}

// ---- mass ratios ----

TEST(MassRatio, MillionToOneKeepsItsEnergy) {
  for (const double ratio : {1e6, 1e-6}) {
    Scene scene = chain(2, false, 0.7);
    scene.solids[1].inertials = {inertial(ratio, {0, 0, -0.5}, ratio * Vector3d(1.0 / 12, 1.0 / 12, 1e-3))};
    const Trajectory end = run(scene, settings("rk4_adaptive", 2, 0.001, 1e-9));
    EXPECT_TRUE(end.certificate.trusted) << ratio << ": " << end.certificate.reason;
  }
}

}  // namespace
}  // namespace borelli::test
