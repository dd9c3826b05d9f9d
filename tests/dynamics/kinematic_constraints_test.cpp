// Kinematic constraints (rolling without slip, a knife edge): rows against velocities of the solids' points
// from differences of poses; motions against closed forms; the samples.
#include "dynamics/constraints/assembly.hpp"
#include "dynamics/constraints/local_coordinates.hpp"
#include "dynamics/equations/equations.hpp"
#include "dynamics/formats/scene_file.hpp"
#include "dynamics/scene/surface_contact.hpp"
#include "scenes.hpp"

namespace borelli::test::kinematic_constraints_test {
namespace {

// ---- rows ----

/// The poses of the solids of a system that moves with the velocities of a state, s later.
class Mover {
 public:
  explicit Mover(const Scene& scene) : system(compiled(scene)), state(Random(21).state(system)) {
    state.t = 0.3;
  }
  Workspace at(double s) const {
    Eigen::VectorXd q = state.q;
    from_local_coordinates(system, state.q.data(), Eigen::VectorXd(s * state.v).data(), q.data());
    Workspace w(system);
    EXPECT_FALSE(update_terms(system, system.parameters, state.t + s, q.data(), state.v.data(), w));
    return w;
  }
  Pose pose(const std::string& solid, const Workspace& w) const {
    for (std::size_t i = 0; i < system.solids.size(); ++i)
      if (system.solids[i] == solid)
        return w.kinematics.bodies[system.solid_bodies[i]].X * system.parameters.solid_places[i];
    return {};
  }
  /// Velocity relative to solid b of the point of solid a that is now at p, by central differences.
  Vector3d slip(const std::string& a, const std::string& b, const Vector3d& p) const {
    constexpr double h = 1e-5;
    const Workspace now = at(0), behind = at(-h), ahead = at(h);
    const auto velocity = [&](const std::string& solid) {
      const Vector3d own = pose(solid, now).inverse() * p;
      return Vector3d((pose(solid, ahead) * own - pose(solid, behind) * own) / (2 * h));
    };
    return velocity(a) - velocity(b);
  }
  System system;
  State state;
};

Mover tree_with(const ConstraintKind& kind) {
  Scene scene = random_tree(4, {.balls = true, .drives = true});
  scene.constraints = {{"it", kind}};
  return Mover(scene);
}

// of central differences: h^2 times third derivatives (about 100), and rounding / h
constexpr double tolerance = 2e-7;

/// Expects the rows of a form that touches a plane of solid b at p: the slip's components along the normal
/// and across it.
void expect_slip(const Mover& mover, const std::string& a, const Plane& plane, const Vector3d& p, bool held) {
  const Workspace now = mover.at(0);
  const Vector3d slip = mover.slip(a, plane.on.solid, p);
  const Matrix3d R = mover.pose(plane.on.solid, now).R;
  const Vector3d n = plane.normal.normalized(), t = across<double>(n);
  Eigen::VectorXd expected(3);
  expected << n.dot(R.transpose() * slip), t.dot(R.transpose() * slip), n.cross(t).dot(R.transpose() * slip);
  EXPECT_LT((now.rows.rate - expected.tail(held ? 3 : 2)).norm(), tolerance);
}

TEST(KinematicConstraints, DiscRowsAreTheVelocityOfItsLowestPoint) {
  for (const std::string ground : {"s5", "world"})
    for (const bool held : {true, false}) {
      const RollingDisc disc{
          {"s3", {0.1, 0.2, 0.3}}, {1, 2, -1}, 0.4, {{ground, {1, 0, 0}}, {2, 0, 1}}, held};
      const Mover mover = tree_with(disc);
      // the rim's points are centre + radius (u cos x + w sin x); their height is least against its slope
      const Workspace now = mover.at(0);
      const Pose X = mover.pose("s3", now);
      const Vector3d n = mover.pose(ground, now).R * disc.plane.normal.normalized();
      const Vector3d a = disc.axis.normalized(), u = X.R * a.unitOrthogonal(), w = (X.R * a).cross(u);
      const double x = std::atan2(-n.dot(w), -n.dot(u));
      const Vector3d lowest = X * disc.disc.point + disc.radius * (std::cos(x) * u + std::sin(x) * w);
      expect_slip(mover, "s3", disc.plane, lowest, held);
      const double height = n.dot(lowest - mover.pose(ground, now) * disc.plane.on.point);
      EXPECT_NEAR(now.rows.h[0], held ? height : 0, 1e-14);
    }
}

TEST(KinematicConstraints, SphereRowsAreTheVelocityOfItsLowestPoint) {
  for (const std::string ground : {"s5", "world"}) {
    const RollingSphere ball{{"s3", {0.1, 0.2, 0.3}}, 0.4, {{ground, {1, 0, 0}}, {2, 0, 1}}, true};
    const Mover mover = tree_with(ball);
    const Workspace now = mover.at(0);
    const Vector3d n = mover.pose(ground, now).R * ball.plane.normal.normalized();
    expect_slip(mover, "s3", ball.plane, mover.pose("s3", now) * ball.sphere.point - 0.4 * n, true);
  }
}

TEST(KinematicConstraints, KnifeEdgeRowIsTheSidewaysVelocity) {
  for (const std::string ground : {"s5", "world"}) {
    const Vector3d point(0.1, 0.2, 0.3), normal = Vector3d(1, 2, -1).normalized();
    const Mover mover = tree_with(KnifeEdge{{"s3", point}, normal, {ground}});
    const Workspace now = mover.at(0);
    const Pose X = mover.pose("s3", now);
    EXPECT_NEAR(now.rows.rate[0], (X.R * normal).dot(mover.slip("s3", ground, X * point)), tolerance);
  }
}

// ---- motions ----

void expect_held(const Trajectory& t) {
  EXPECT_TRUE(t.certificate.trusted) << t.certificate.reason;
  for (const ConstraintResidual& residual : t.certificate.residuals) {
    EXPECT_LT(residual.position, 1e-12) << residual.constraint;  // projected after each step
    EXPECT_LT(residual.velocity, 1e-12) << residual.constraint;
  }
}

// A disc of radius r whose axis stands at the angle x to the vertical, its centre on a circle of radius d:
// with rolling W d = -r w (w: the whole turn along the axis) and the moments about its centre,
// (C + m r^2) w W sin x - A W^2 sin x cos x + m g r cos x = 0 (as of Neimark and Fufaev, Dynamics of
// Nonholonomic Systems, chapter 2); for a thin disc W^2 = g cot x / (1.5 d + 0.25 r cos x).
TEST(KinematicConstraints, LeaningDiscRollsInACircle) {
  for (Equations equations : {Equations::recursive, Equations::lagrange}) {
    Scene scene = sample("rolling_disc.toml");
    scene.simulation.equations = equations;
    const double x = M_PI / 3, d = 1, r = 0.3, g = 9.81, mass = 2;
    const double W = std::sqrt(g / std::tan(x) / (1.5 * d + 0.25 * r * std::cos(x)));
    EXPECT_NEAR(scene.simulation.end_time, 2 * M_PI / W, 1e-14);
    scene.simulation.output_interval = 0.1;
    const Trajectory t = run(compiled(scene), scene.simulation);
    expect_held(t);
    const double spin = -W * (d / r + std::cos(x));
    for (Eigen::Index i = 0; i < t.q.rows(); ++i) {
      const double s = t.times[i];
      Eigen::VectorXd q(6);
      q << -d * std::sin(W * s), d * std::cos(W * s), r * std::sin(x), W * s, M_PI / 6, spin * s;
      EXPECT_LT((t.q.row(i).transpose() - q).norm(), 1e-8);  // about 100 steps at 1e-10
      // weight and centripetal force
      EXPECT_NEAR(t.multipliers(i, 0), mass * g, 1e-7);
      EXPECT_NEAR(t.multipliers.row(i).tail(2).norm(), mass * W * W * d, 1e-7);
    }
    EXPECT_TRUE(t.certificate.redundant.empty());
  }
}

/// A ball rolls on a turntable under gravity g. Its velocity v follows v' = (2/7) W z x v + (5/7) g (across),
/// about the drift 5/(2 W) z x g: circles at 2/7 of the table's rate W (Earnshaw 1844; Burns, Ball rolling on
/// a turntable, Am. J. Phys. 49, 1981).
void expect_turntable_motion(Scene scene, const Vector3d& gravity) {
  scene.gravity = gravity;
  scene.simulation.output_interval = 0.2;
  const Trajectory t = run(compiled(scene), scene.simulation);
  expect_held(t);
  const double W = 7, w = 2 * W / 7;
  const Vector3d z = Vector3d::UnitZ(), start(0.4, 0, 0.1), v(0, 0.5, 0),
                 drift = 5 / (2 * W) * z.cross(gravity);
  for (Eigen::Index i = 0; i < t.q.rows(); ++i) {
    const double s = t.times[i];
    const Vector3d u = v - drift;
    const Vector3d place =
        start + drift * s + std::sin(w * s) / w * u + (1 - std::cos(w * s)) / w * z.cross(u);
    EXPECT_LT((t.q.row(i).head(3).transpose() - place).norm(), 1e-8);  // about 100 steps at 1e-10
  }
}

TEST(KinematicConstraints, BallOnATurntableMovesInCircles) {
  const Scene scene = sample("turntable.toml");
  expect_turntable_motion(scene, {0, 0, -9.81});
}

TEST(KinematicConstraints, BallOnATiltedTurntableDriftsAcrossTheSlope) {
  const Scene scene = sample("turntable.toml");
  expect_turntable_motion(scene, 9.81 * Vector3d(std::sin(0.1), 0, -std::cos(0.1)));
}

// From turning alone: u = V tanh(k t), w = w0 / cosh(k t), V = w0 sqrt(J / m), k = a V m / J, J about the
// blade (Bloch, Nonholonomic Mechanics and Control, 2003, section 1.7).
TEST(KinematicConstraints, ChaplyginsSleighStraightensOut) {
  const Scene scene = sample("chaplygin_sleigh.toml");
  const double w0 = std::sqrt(2);
  for (ConstraintTreatment treatment : {ConstraintTreatment::projection, ConstraintTreatment::baumgarte}) {
    SimulationSettings how = scene.simulation;
    how.constraints = treatment;
    how.output_interval = 0.25;
    const Trajectory t = run(compiled(scene), how);
    EXPECT_TRUE(t.certificate.trusted) << t.certificate.reason;
    for (Eigen::Index i = 0; i < t.q.rows(); ++i) {
      const double s = t.times[i], heading = t.q(i, 2);
      const double along = t.v(i, 0) * std::cos(heading) + t.v(i, 1) * std::sin(heading);
      const double aside = t.v(i, 1) * std::cos(heading) - t.v(i, 0) * std::sin(heading);
      EXPECT_NEAR(along, std::tanh(s), 1e-8);  // about 100 steps at 1e-10
      EXPECT_NEAR(aside, 0, treatment == ConstraintTreatment::projection ? 1e-14 : 1e-8);
      EXPECT_NEAR(t.v(i, 2), w0 / std::cosh(s), 1e-8);
      EXPECT_NEAR(heading, w0 * 2 * std::atan(std::tanh(s / 2)), 1e-8);
      // the force on the blade: m (a w' + u w), with w' = -k w tanh
      EXPECT_NEAR(t.multipliers(i, 0), 2 * (-0.5 + 1) * w0 * std::tanh(s) / std::cosh(s), 1e-7);
    }
  }
}

// ---- assembly, faults ----

TEST(KinematicConstraints, AssemblyMovesPositionsAcrossABlade) {
  // the plane's and the blade's rows have the same direction; only the plane's has a position to correct
  Scene scene;
  scene.solids = {solid("skate", "world",
                        {slide("x", Vector3d::UnitX(), 0, 1), slide("y", Vector3d::UnitY(), 0.1, 1),
                         hinge("heading", Vector3d::UnitZ())},
                        {inertial(1, {0, 0, 0}, {0.1, 0.1, 0.1})})};
  scene.constraints = {{"blade", KnifeEdge{{"skate", {0, 0, 0}}, {0, 1, 0}, {"world"}}},
                       {"rail", PointOnPlane{{"skate", {0, 0, 0}}, {{}, {0, 1, 0}}, constant(0)}}};
  const System system = compiled(scene);
  State state = system.initial;
  const Assembly assembly = need(assemble(system, state));
  EXPECT_LT((state.q - Vector3d(0, 0, 0)).norm(), 1e-15);
  EXPECT_LT((state.v - Vector3d(1, 0, 0)).norm(), 1e-15);
  EXPECT_EQ(assembly.rank, 1);
  EXPECT_EQ(assembly.redundant, std::vector<std::string>{"rail"});
  // the same along a run: the plane's position is kept although the blade's row is the independent one
  const Trajectory t = run(system, settings("rk4", 1, 0.01));
  EXPECT_LT(std::abs(last(t.q)[1]), 1e-15);
}

TEST(KinematicConstraints, NamesAFlatDiscWithItsLine) {
  Scene scene = sample("rolling_disc.toml");
  scene.solids[0].switches = free_switches("disc");
  std::get<RollingDisc>(scene.constraints[0].kind).axis = Vector3d::UnitZ();
  const auto t = simulate(compiled(scene));
  ASSERT_FALSE(t);
  EXPECT_TRUE(t.error().where.ends_with("rolling_disc.toml:32: constraint 'ground[0]'")) << t.error().where;
  EXPECT_NE(t.error().what.find("lies flat"), std::string::npos);
}

TEST(KinematicConstraints, RefusesAnInvalidRadiusWithItsLine) {
  for (const char* name : {"rolling_disc.toml", "turntable.toml"}) {
    Scene scene = sample(name);
    std::visit(
        [](auto& kind) {
          if constexpr (requires { kind.held; }) kind.radius = 0;
        },
        scene.constraints[0].kind);
    const auto system = compile(scene);
    ASSERT_FALSE(system);
    EXPECT_NE(system.error().where.find(name), std::string::npos);
    EXPECT_EQ(system.error().what, "its radius must be positive");
  }
}

TEST(KinematicRows, AreRefusedByGeneralizedAlphaUnderProjection) {
  const Scene scene = sample("chaplygin_sleigh.toml");
  const System system = compiled(scene);
  SimulationSettings how = scene.simulation;
  how.method = "generalized_alpha";
  const auto refused = simulate(system, system.initial, how);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message().find("set constraints to baumgarte"), std::string::npos);
  how.constraints = ConstraintTreatment::baumgarte;
  EXPECT_TRUE(simulate(system, system.initial, how));
}

}  // namespace
}  // namespace borelli::test::kinematic_constraints_test
