// Efforts and constraints on random trees (free and driven): springs against the slope of their potential,
// dampers against their power, constraint rows against central differences in position and in time.
#include "dynamics/equations/passes.hpp"

#include "dynamics/constraints/local_coordinates.hpp"
#include "dynamics/equations/derivatives.hpp"
#include "dynamics/equations/equations.hpp"
#include "dynamics/equations/evaluate.hpp"
#include "dynamics/formats/scene_file.hpp"
#include "dynamics/scene/hyper_dual.hpp"
#include "scenes.hpp"

namespace borelli::test::scan_test {
namespace {

// of central differences with step h: h^2 times third derivatives (about 100), and rounding / h
constexpr double h = 1e-5, tolerance = 2e-7;

/// A system with its state, evaluated at displaced states.
class Probe {
 public:
  Probe(const Scene& scene, unsigned seed) : system(compiled(scene)), state(Random(seed).state(system)) {
    state.t = 0.3;
  }

  /// Terms after a displacement x in the local coordinates, at time t + s.
  Workspace at(const Eigen::VectorXd& x, double s) const {
    Eigen::VectorXd q = state.q;
    from_local_coordinates(system, state.q.data(), x.data(), q.data());
    Workspace w(system);
    EXPECT_FALSE(update_terms(system, system.parameters, state.t + s, q.data(), state.v.data(), w));
    return w;
  }
  Workspace now() const { return at(Eigen::VectorXd::Zero(system.nv), 0); }
  Workspace along(int i, double s) const { return at(s * Eigen::VectorXd::Unit(system.nv, i), 0); }
  Workspace later(double s) const { return at(s * state.v, s); }

  System system;
  State state;
};

// ---- efforts ----

Scene tree_with(const EffortKind& kind, bool drives) {
  Scene scene = random_tree(4, {.balls = true, .drives = drives});
  scene.gravity.setZero();
  scene.efforts = {{"effort", kind}};
  return scene;
}

std::vector<EffortKind> springs(double stiffness, double damping) {
  return {PointSpring{{"s3", {0.1, 0.2, 0.3}}, {"s5", {-0.2, 0.1, 0}}, stiffness, damping, 0.4},
          PointSpring{{"s2", {0.1, 0.2, 0.3}}, {"world", {1, 2, 3}}, stiffness, damping, 0},
          TorsionSpring{{"s3"}, {"s4"}, stiffness, damping, {0.3, -0.2, 0.5}},
          TorsionSpring{{"s5"}, {"world"}, stiffness, damping, {0, 0, 0}},
          CoordinateSpring{{"c20"}, stiffness, damping, 0.2},
          CoordinateSpring{{"c01"}, stiffness, damping, 0.2},
          LimitSpring{{"c20"}, stiffness, damping, {{-0.01, 0.01}}},
          LimitSpring{{"c51"}, stiffness, damping, {{-0.1, 0.1}, {-0.1, 0.2}, {-0.05, 0.05}}},
          PdController{{"c40"}, stiffness, damping, {constant(0.1)}},
          PdController{{"c11"}, stiffness, damping, {constant(0.1), constant(-0.2), constant(0.3)}}};
}

TEST(Efforts, SpringsFollowTheGradientOfTheirPotential) {
  for (const EffortKind& kind : springs(30, 0)) {
    const Probe probe(tree_with(kind, false), 11);
    const Workspace now = probe.now();
    EXPECT_GT(now.terms.potential, 0);
    for (int i = 0; i < probe.system.nv; ++i) {
      const double slope = (probe.along(i, h).terms.potential - probe.along(i, -h).terms.potential) / (2 * h);
      EXPECT_NEAR(now.terms.Q[i], -slope, 30 * tolerance) << kind.index() << ", " << i;
    }
    EXPECT_EQ(now.efforts.power, 0);
  }
}

TEST(Efforts, SpringWorkEqualsTheLossOfPotential) {
  std::vector<EffortKind> kinds = springs(30, 2);
  kinds.push_back(PdController{{"c40"}, 30, 2, {Sine{}}});
  kinds.push_back(PdController{{"c11"}, 30, 2, {Sine{}, constant(0.1), Polynomial{{0.1, 0.5}}}});
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    const EffortKind& kind = kinds[i];
    const Probe probe(tree_with(kind, true), 12);
    const Workspace now = probe.now();
    const double loss = (probe.later(h).terms.potential - probe.later(-h).terms.potential) / (2 * h);
    // the effort's total power: from the potential and the damper
    EXPECT_NEAR(now.terms.Q.dot(now.kinematics.u), now.efforts.power - loss, 30 * tolerance) << kind.index();
    if (i < springs(0, 0).size()) {
      EXPECT_LE(now.efforts.power, 0);  // (a moving target may give energy)
    }
  }
}

TEST(Efforts, InternalPairDoesNotMoveTheGravityCentre) {
  Scene scene;
  scene.gravity.setZero();
  Random random(3);
  for (const char* name : {"a", "b"})
    scene.solids.push_back(solid(name, "world", free_switches(name), {random.inertia().inertial()}));
  scene.efforts = {
      {"force", Force{{"a", {1, 0, 0}}, {1, 2, 3}, Axes::solid, constant(2), SolidPoint{"b", {0, 1, 0}}}},
      {"torque", Torque{{"a"}, {1, -2, 3}, Axes::world, Sine{}, SolidName{"b"}}},
      {"point", PointSpring{{"a", {0, 0, 1}}, {"b", {1, 0, 0}}, 5, 1, 0.1}},
      {"twist", TorsionSpring{{"a"}, {"b"}, 5, 1, {0, 0, 0}}},
  };
  const Probe probe(scene, 5);
  const Workspace w = probe.now();
  EXPECT_LT((w.efforts.force[1] + w.efforts.force[2]).norm(), 1e-13);
  // moments about the world's origin vanish, except for the pair of forces, whose lines of action differ
  Vector3d moment = Vector3d::Zero();
  for (int b : {1, 2}) moment += w.efforts.moment[b] + w.kinematics.bodies[b].g.cross(w.efforts.force[b]);
  const Pose &X_a = w.kinematics.bodies[1].X, &X_b = w.kinematics.bodies[2].X;
  const Vector3d f = X_a.R * Vector3d(2, 4, 6);
  const Vector3d couple = (X_a * Vector3d(1, 0, 0) - X_b * Vector3d(0, 1, 0)).cross(f);
  EXPECT_LT((moment - couple).norm(), 1e-13);
}

TEST(Efforts, ForceWorksAlongItsPointsVelocity) {
  Scene scene = random_tree(7, {.balls = true});
  scene.gravity.setZero();
  const Vector3d point(0.3, 0.1, -0.2), force(1, -2, 0.5);
  scene.efforts = {{"push", Force{{"s5", point}, force, Axes::world, Polynomial{{1, 2}}, {}}}};
  const Probe probe(scene, 5);
  const Workspace w = probe.now();
  const auto place = [&](const Workspace& at) {
    return at.kinematics.bodies[probe.system.solid_bodies[5]].X * point;
  };
  const Vector3d velocity = (place(probe.later(h)) - place(probe.later(-h))) / (2 * h);
  const double power = (1 + 2 * 0.3) * force.dot(velocity);
  EXPECT_NEAR(w.efforts.power, power, tolerance);
  EXPECT_NEAR(w.terms.Q.dot(w.kinematics.u), power, tolerance);
}

// ---- constraints ----

/// Points of a curve in an oblique plane, where the normal directions turn only with the curve.
std::vector<Vector3d> in_a_plane() {
  const Vector3d u = Vector3d(1, 2, -2) / 3, v = Vector3d(2, 1, 2) / 3;
  std::vector<Vector3d> out;
  for (int i = 0; i < 7; ++i)
    out.push_back(3 * std::cos(0.9 * i) * u + (2 + 0.1 * i) * std::sin(0.9 * i) * v + Vector3d(0.5, 0, 1));
  return out;
}

std::vector<ConstraintKind> constraints() {
  FunctionConstraint own;  // |p|^2 c21 sin t + c20^2 - 1
  own.coordinates = {{"c21"}, {"c20"}};
  own.points = {{"s4", {0.1, 0.2, 0.3}}};
  own.function = [](double t, const Eigen::VectorXd& x, FunctionDerivatives& f) {
    const Vector3d p = x.tail<3>();
    const double s = std::sin(t), c = std::cos(t), p2 = p.squaredNorm();
    f.value = p2 * x[0] * s + x[1] * x[1] - 1;
    f.gradient << p2 * s, 2 * x[1], 2 * p * x[0] * s;
    f.hessian.block<3, 1>(2, 0) = 2 * p * s;
    f.hessian.block<1, 3>(0, 2) = 2 * p.transpose() * s;
    f.hessian.block<3, 3>(2, 2) = 2 * x[0] * s * Matrix3d::Identity();
    f.hessian(1, 1) = 2;
    f.rate = p2 * x[0] * c;
    f.gradient_rate << p2 * c, 0, 2 * p * x[0] * c;
    f.acceleration = -p2 * x[0] * s;
  };
  const Pose pose{rotation_matrix(Random(2).turn()), {0.3, 0.1, 0.2}};
  return {PointOnPoint{{"s3", {0.1, 0.2, 0.3}}, {"s5", {1, 0, 0}}},
          PointOnPoint{{"s4", {0.1, 0.2, 0.3}}, {"world", {1, 0, 0}}},
          PointOnPlane{{"s3", {0.1, 0.2, 0.3}}, {{"s5", {1, 0, 0}}, {1, 2, -1}}, Sine{}},
          PointOnPlane{{"s5", {0.1, 0.2, 0.3}}, {{"world", {1, 0, 0}}, {1, 2, -1}}, constant(0)},
          Distance{{"s3", {0.1, 0.2, 0.3}}, {"s5", {1, 0, 0}}, Polynomial{{2, 1, 0.5}}},
          Distance{{"s2", {0.1, 0.2, 0.3}}, {"world", {1, 3, 0}}, constant(1)},
          CoordinateCoupling{{{"c20"}, {"c21"}, {"c01"}}, {2, -1, 0.5}, Sine{}},
          WeldConstraint{{"s3"}, {"s5"}, pose},
          WeldConstraint{{"s4"}, {"world"}, pose},
          own,
          RollingDisc{{"s3", {0.1, 0.2, 0.3}}, {1, 2, -1}, 0.4, {{"s5", {1, 0, 0}}, {2, 0, 1}}},
          RollingDisc{{"s5", {0.1, 0.2, 0.3}}, {0, 2, -1}, 0.4, {{"world", {1, 0, 0}}, {1, 2, 2}}, false},
          RollingSphere{{"s4", {0.1, 0.2, 0.3}}, 0.4, {{"s5", {1, 0, 0}}, {2, 0, 1}}},
          KnifeEdge{{"s3", {0.1, 0.2, 0.3}}, {1, 2, -1}, {"s5"}},
          KnifeEdge{{"s5", {0.1, 0.2, 0.3}}, {1, 2, -1}, {"world"}},
          PointOnLine{{"s3", {0.1, 0.2, 0.3}}, {"s5", {1, 0, 0}}, {1, 2, -1}},
          PointOnLine{{"s5", {0.1, 0.2, 0.3}}, {"world", {1, 0, 0}}, {1, 2, -1}},
          PointOnCurve{{"s3", {0.1, 0.2, 0.3}}, {"s5"}, in_a_plane(), false},
          PointOnCurve{{"s4", {0.1, 0.2, 0.3}}, {"world"}, in_a_plane(), true},
          AngleConstraint{{"s3"}, {1, 2, -1}, {"s5"}, {1, 0, 0}, Polynomial{{1, 0.2, 0.1}}},
          AngleConstraint{{"s4"}, {1, 2, -1}, {"world"}, {1, 0, 0}, constant(1)},
          CoordinateFunction{{"c20"}, {"c21"}, Table({-1, -0.2, 0.5, 1}, {1, 2, 2.5, 3.5})},
          CoordinateFunction{{"c21"}, {"c01"}, Sine{0.5, 2, 0.1, 0.2}}};
}

class ConstraintKinds : public testing::TestWithParam<std::tuple<int, bool>> {
 protected:
  static Scene scene() {
    Scene out = random_tree(4, {.balls = true, .drives = std::get<1>(GetParam())});
    out.constraints = {{"constraint", constraints()[std::get<0>(GetParam())]}};
    return out;
  }
  Probe probe{scene(), 21};
};

TEST_P(ConstraintKinds, JacobianIsTheGradientOfTheResidual) {
  const Workspace now = probe.now();
  for (int i = 0; i < probe.system.nv; ++i) {
    const Eigen::VectorXd slope = (probe.along(i, h).rows.h - probe.along(i, -h).rows.h) / (2 * h);
    for (int r = 0; r < probe.system.rows; ++r) {
      // kinematic rows are tested in kinematic_constraints_test.cpp
      const double asked = probe.system.kinematic_rows[r] ? 0 : now.rows.L(r, i);
      EXPECT_NEAR(slope[r], asked, tolerance) << i;
    }
  }
}

TEST_P(ConstraintKinds, RateAndBiasAreTheTimeDerivatives) {
  const Workspace behind = probe.later(-h), now = probe.now(), ahead = probe.later(h);
  for (int r = 0; r < probe.system.rows; ++r) {
    if (probe.system.kinematic_rows[r]) continue;
    EXPECT_NEAR(now.rows.rate[r], (ahead.rows.h[r] - behind.rows.h[r]) / (2 * h), tolerance);
  }
  // with no free acceleration, d2h/dt2 is E alone
  EXPECT_LT((now.rows.E - (ahead.rows.rate - behind.rows.rate) / (2 * h)).norm(), tolerance);
}

TEST_P(ConstraintKinds, AccelerationKeepsTheSecondDerivativeZero) {
  Workspace w(probe.system);
  ASSERT_FALSE(accelerate(probe.system, probe.system.parameters, probe.state.t, probe.state.q.data(),
                          probe.state.v.data(), {}, w));
  const Eigen::VectorXd second = w.rows.L.leftCols(probe.system.nv) * w.a + w.rows.E;
  for (int k = 0; k < w.solver.rank(); ++k)  // a weld may demand more than its solids' free coordinates allow
    EXPECT_LT(std::abs(second[w.solver.order()[k]]), 1e-11 * (1 + w.rows.E.norm() + w.a.norm()));
  const Eigen::MatrixXd unit_rows = w.rows.L.leftCols(probe.system.nv).rowwise().normalized();
  EXPECT_EQ(w.solver.rank(),
            Eigen::ColPivHouseholderQR<Eigen::MatrixXd>(unit_rows).setThreshold(1e-8).rank());
}

// Rows over dual numbers, from which the derivatives of the dynamics come.
TEST_P(ConstraintKinds, DynamicsDerivativesMatchDifferences) {
  const System& system = probe.system;
  const ForwardDerivatives exact = need(forward_derivatives(system, probe.state));
  const auto acceleration = [&](const Eigen::VectorXd& x, const Eigen::VectorXd& v) {
    State state = probe.state;
    from_local_coordinates(system, probe.state.q.data(), x.data(), state.q.data());
    state.v += v;
    return need(evaluate(system, state)).acceleration;
  };
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(system.nv);
  // differences with step h: h^2 times third derivatives over those of the first (about 1e3), rounding / h
  const double scale = 1 + exact.acceleration_by_q.norm() + exact.acceleration_by_v.norm();
  for (int i = 0; i < system.nv; ++i) {
    const Eigen::VectorXd x = h * Eigen::VectorXd::Unit(system.nv, i);
    EXPECT_LT(
        (exact.acceleration_by_q.col(i) - (acceleration(x, zero) - acceleration(-x, zero)) / (2 * h)).norm(),
        1e-6 * scale)
        << i;
    EXPECT_LT(
        (exact.acceleration_by_v.col(i) - (acceleration(zero, x) - acceleration(zero, -x)) / (2 * h)).norm(),
        1e-6 * scale)
        << i;
  }
}

INSTANTIATE_TEST_SUITE_P(All, ConstraintKinds,
                         testing::Combine(testing::Range(0, int(constraints().size())), testing::Bool()));

// |p|^2 c21 sin t + c20^2 - 1 by its code alone, against the derivatives written by hand above.
TEST(Constraints, FunctionDerivativesComeFromItsCode) {
  std::vector<ConstraintKind> kinds = constraints();
  const auto found = std::find_if(kinds.begin(), kinds.end(), [](const ConstraintKind& kind) {
    return std::holds_alternative<FunctionConstraint>(kind);
  });
  const auto& by_hand = std::get<FunctionConstraint>(*found);
  const auto by_code = with_derivatives([](const HyperDual& t, const std::vector<HyperDual>& x) {
    return (x[2] * x[2] + x[3] * x[3] + x[4] * x[4]) * x[0] * sin(t) + x[1] * x[1] - 1;
  });
  FunctionDerivatives a, b;
  for (FunctionDerivatives* d : {&a, &b}) {
    d->gradient = d->gradient_rate = Eigen::VectorXd::Zero(5);
    d->hessian = Eigen::MatrixXd::Zero(5, 5);
  }
  const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(5, -1, 2);
  by_hand.function(0.7, x, a);
  by_code(0.7, x, b);
  EXPECT_NEAR(b.value, a.value, 1e-14);
  EXPECT_NEAR(b.rate, a.rate, 1e-14);
  EXPECT_NEAR(b.acceleration, a.acceleration, 1e-14);
  EXPECT_LT((b.gradient - a.gradient).norm(), 1e-14);
  EXPECT_LT((b.gradient_rate - a.gradient_rate).norm(), 1e-14);
  EXPECT_LT((b.hessian - a.hessian).norm(), 1e-14);
}

TEST(Constraints, HyperDualFunctionsHaveTheirDerivatives) {
  const auto expect = [](const HyperDual& f, double value, double slope, double curvature) {
    EXPECT_NEAR(f.value, value, 1e-15);
    EXPECT_NEAR(f.d1, 2 * slope, 1e-14);
    EXPECT_NEAR(f.d2, 3 * slope, 1e-14);
    EXPECT_NEAR(f.d12, 5 * slope + 6 * curvature, 1e-14);
  };
  const HyperDual x(0.7, 2, 3, 5);
  const double v = 0.7;
  expect(1 / x, 1 / v, -1 / (v * v), 2 / (v * v * v));
  expect(sin(x), std::sin(v), std::cos(v), -std::sin(v));
  expect(cos(x), std::cos(v), -std::sin(v), -std::cos(v));
  expect(exp(x), std::exp(v), std::exp(v), std::exp(v));
  expect(log(x), std::log(v), 1 / v, -1 / (v * v));
  expect(sqrt(x), std::sqrt(v), 0.5 / std::sqrt(v), -0.25 / (v * std::sqrt(v)));
  expect(pow(x, 3), v * v * v, 3 * v * v, 6 * v);
  expect(atan(x), std::atan(v), 1 / (1 + v * v), -2 * v / ((1 + v * v) * (1 + v * v)));
  expect(abs(-x), v, 1, 0);
}

TEST(Constraints, RefusesANonPositiveDistanceWithItsLine) {
  for (const char* distance : {"-1", "0", "[0, 1]"}) {
    const std::string text = fmt::format(
        "[[solid]]\nname = \"bob\"\njoint = {{translation = \"x\"}}\nmass = 1\ntensor = [0, 0, "
        "0]\n\n[[constraint]]\n"
        "name = \"rod\"\nkind = \"distance\"\na = \"bob\"\nb = \"world\"\ndistance = {}\n",
        distance);
    const auto system = compile(need(parse_scene(text, "rod.toml")));
    ASSERT_FALSE(system) << distance;
    EXPECT_EQ(system.error().message(),
              "rod.toml:7: constraint 'rod': its distance must be positive at the start");
  }
}

TEST(Constraints, NamesARodBetweenCoincidentPoints) {
  Scene scene = chain(1, false);
  scene.constraints = {{"rod", Distance{{"l0", {0, 0, 0}}, {"world", {0, 0, 0}}, constant(1)}}};
  const Result<Trajectory> out = simulate(compiled(scene));
  ASSERT_FALSE(out);
  EXPECT_EQ(out.error().where, "constraint 'rod'");
  EXPECT_NE(out.error().what.find("two points coincide"), std::string::npos);
}

}  // namespace
}  // namespace borelli::test::scan_test
