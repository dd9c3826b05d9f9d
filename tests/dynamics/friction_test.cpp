// Friction of bodies whose joints allow only some sliding directions, and friction on moving ground.
#include <cmath>

#include "scenes.hpp"

namespace borelli::test::friction_test {
namespace {

constexpr double g = 9.81;
using Eigen::Vector2d;

Inertial ball_inertial() { return inertial(1, {0, 0, 0}, {0.004, 0.004, 0.004}); }

Constraint over_plane(const Vector3d& normal, double friction, double restitution,
                      const std::string& ground = "world") {
  SphereOverPlane kind;
  kind.sphere = {"ball", {0, 0, 0}};
  kind.radius = 0.1;
  kind.plane.on = {ground, {0, 0, 0}};
  kind.plane.normal = normal;
  kind.surface = {restitution, friction};
  return {"ground", kind};
}

TEST(Friction, StopsPlanarMotionAsSpatialMotion) {
  for (double turn : {0., 0.5, M_PI / 2, 2.}) {
    SCOPED_TRACE(turn);
    const Vector3d along(std::cos(turn), std::sin(turn), 0);
    Scene scene;
    scene.solids = {solid("ball", "world", {slide("s", along, 0, 2), slide("z", Vector3d::UnitZ(), 0.1)},
                          {ball_inertial()})};
    scene.constraints = {over_plane(Vector3d::UnitZ(), 0.3, 0)};
    const Trajectory path = run(scene, settings("dopri5", 1, 1e-3, 1e-9));
    EXPECT_TRUE(path.certificate.trusted) << path.certificate.reason;
    EXPECT_NEAR(last(path.q)[0], 2 * 2 / (2 * 0.3 * g), 1e-8);
  }
}

TEST(Friction, HoldsABodyPressedOnAWall) {
  Scene scene;
  scene.solids = {solid("ball", "world", {slide("x", Vector3d::UnitX(), 0.1), slide("z", Vector3d::UnitZ())},
                        {ball_inertial()})};
  scene.constraints = {over_plane(Vector3d::UnitX(), 1, 0)};
  scene.efforts = {{"press", Force{{"ball", {0, 0, 0}}, {-20, 0, 0}, Axes::world, Polynomial{{1}}, {}}}};
  const Trajectory held = run(scene, settings("dopri5", 1, 1e-3, 1e-9));
  EXPECT_NEAR(last(held.q)[1], 0, 1e-12);
  std::get<SphereOverPlane>(scene.constraints[0].kind).surface.friction = 0.4;  // 8 N of 9.81
  const Trajectory slips = run(scene, settings("dopri5", 1, 1e-3, 1e-9));
  EXPECT_NEAR(last(slips.q)[1], -0.5 * (g - 8), 1e-8);
}

TEST(Friction, PlanarImpactsEqualSpatialOnes) {
  for (double speed : {0.05, 2.})
    for (ImpactLaw law : {ImpactLaw::sequential, ImpactLaw::simultaneous}) {
      std::vector<Eigen::VectorXd> ends;
      for (bool space : {false, true}) {
        Scene scene;
        std::vector<Switch> joint = {slide("x", Vector3d::UnitX(), 0, speed),
                                     slide("z", Vector3d::UnitZ(), 0.101), hinge("turn", Vector3d::UnitY())};
        if (space) joint.push_back(slide("y", Vector3d::UnitY()));
        scene.solids = {solid("ball", "world", joint, {ball_inertial()})};
        scene.constraints = {over_plane(Vector3d::UnitZ(), 0.5, 0.5)};
        SimulationSettings how = settings("dopri5", 0.1, 1e-3, 1e-9);
        how.impacts = law;
        ends.push_back(last(run(scene, how).q).head(3));
      }
      EXPECT_NEAR((ends[0] - ends[1]).norm(), 0, 1e-12) << speed;
    }
}

/// Final position of a point mass at radius r on a turntable that spins up from rest at alpha. It sticks
/// until that needs more than mu g, then slides. Classical Runge-Kutta method with steps that follow the
/// slip.
Vector2d carried(double r, double alpha, double mu, double end) {
  double t = std::sqrt(std::sqrt(mu * mu * g * g / (r * r) - alpha * alpha)) / alpha;
  const double a = 0.5 * alpha * t * t, w = alpha * t;
  using Motion = Eigen::Vector4d;
  Motion y;
  y << r * std::cos(a), r * std::sin(a), -w * r * std::sin(a), w * r * std::cos(a);
  const auto slip_of = [&](double at, const Motion& m) {
    return Vector2d(m[2] + alpha * at * m[1], m[3] - alpha * at * m[0]);
  };
  // opposite to the acceleration of the table's point
  Vector2d direction(alpha * y[1] + w * w * y[0], w * w * y[1] - alpha * y[0]);
  direction.normalize();
  const auto rate = [&](double at, const Motion& m) {
    Vector2d slip = slip_of(at, m);
    const Vector2d f = -mu * g * (slip.norm() > 1e-8 ? Vector2d(slip.normalized()) : direction);
    return Motion(m[2], m[3], f[0], f[1]);
  };
  while (t < end) {
    const double h = std::min({2e-4, end - t, 0.1 * std::max(slip_of(t, y).norm(), 1e-6) / (mu * g)});
    const Motion k1 = rate(t, y), k2 = rate(t + h / 2, y + h / 2 * k1), k3 = rate(t + h / 2, y + h / 2 * k2),
                 k4 = rate(t + h, y + h * k3);
    y += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    t += h;
  }
  return y.head<2>();
}

TEST(Friction, OfAnAcceleratingTurntableCarriesThenSlips) {
  const Vector2d expected = carried(0.5, 1, 0.3, 4);
  for (const char* method : {"dopri5", "dop853", "gbs", "gauss16", "rk4_adaptive"})
    for (double tolerance : {1e-9, 1e-10}) {
      SCOPED_TRACE(fmt::format("{} at {}", method, tolerance));
      Scene scene;
      scene.solids = {
          solid("table", "world", {driven(hinge("turn", Vector3d::UnitZ()), Polynomial{{0, 0, 0.5}})},
                {ball_inertial()}),
          solid("ball", "world",
                {slide("x", Vector3d::UnitX(), 0.5), slide("y", Vector3d::UnitY()),
                 slide("z", Vector3d::UnitZ(), 0.1)},
                {ball_inertial()})};
      scene.constraints = {over_plane(Vector3d::UnitZ(), 0.3, 0, "table")};
      const Trajectory path = run(scene, settings(method, 4, 1e-3, tolerance));
      EXPECT_TRUE(path.certificate.trusted) << path.certificate.reason;
      EXPECT_NEAR((Vector2d(last(path.q).head<2>()) - expected).norm(), 0, 2e-6);
    }
}

TEST(Friction, BoxAtRestIsTrustedForLongRuns) {
  for (double end : {10., 1000.})
    for (const char* method : {"dopri5", "dop853"}) {
      SCOPED_TRACE(fmt::format("{} for {} s", method, end));
      Scene scene = sample("block_on_slope.toml");
      std::get<BoxOverPlane>(scene.constraints[0].kind).surface.friction = 0.7;
      scene.solids[1].switches[0].v = {0};
      const Trajectory path = run(scene, settings(method, end, 1e-3, 1e-9));
      EXPECT_TRUE(path.certificate.trusted) << path.certificate.reason;
      EXPECT_NEAR(last(path.q)[0], 0, 1e-8);
    }
}

}  // namespace
}  // namespace borelli::test::friction_test
