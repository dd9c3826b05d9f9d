// Contacts that are hard for methods: steps longer than the flights between contacts, small fast bodies,
// corners that land in turn, very different masses.
#include <array>
#include <cmath>
#include <random>

#include "scenes.hpp"

namespace borelli::test::long_flights_test {
namespace {

constexpr double g = 9.81;

Scene balls(const std::vector<std::pair<double, double>>& heights, double restitution) {
  Scene scene;
  const ContactSurface surface{restitution, 0};
  for (std::size_t i = 0; i < heights.size(); ++i) {
    const std::string name = fmt::format("ball {}", i);
    scene.solids.push_back(
        solid(name, "world",
              {slide(fmt::format("x{}", i), Vector3d::UnitX()),
               slide(fmt::format("z{}", i), Vector3d::UnitZ(), heights[i].first, heights[i].second)},
              {inertial(1, {0, 0, 0}, {0.004, 0.004, 0.004})}));
    SphereOverPlane floor;
    floor.sphere = {name, {0, 0, 0}};
    floor.radius = 0.1;
    floor.plane.on = {"world", {0, 0, 0}};
    floor.surface = surface;
    scene.constraints.push_back({fmt::format("floor {}", i), floor});
    if (i == 0) continue;
    SphereOverSphere meet;
    meet.a = {name, {0, 0, 0}};
    meet.b = {fmt::format("ball {}", i - 1), {0, 0, 0}};
    meet.radii = {0.1, 0.1};
    meet.surface = surface;
    scene.constraints.push_back({fmt::format("meet {}", i), meet});
  }
  return scene;
}

TEST(LongFlights, BallThrownUpHitsThePostBelow) {
  for (const char* method : {"rk4_adaptive", "dopri5", "dop853", "gbs", "gauss16", "arkode"}) {
    SCOPED_TRACE(method);
    Scene scene;
    scene.solids = {solid("ball", "world",
                          {slide("x", Vector3d::UnitX()), slide("z", Vector3d::UnitZ(), 1, 1)},
                          {inertial(1, {0, 0, 0}, {0.004, 0.004, 0.004})})};
    SphereOverSphere meet;
    meet.a = {"ball", {0, 0, 0}};
    meet.b = {"world", {0, 0, 0}};
    meet.radii = {0.1, 0.3};
    meet.surface.restitution = 0.5;
    scene.constraints = {{"post", meet}};
    const Trajectory path = run(scene, settings(method, 2, 1e-3, 1e-8));
    EXPECT_TRUE(path.certificate.trusted) << path.certificate.reason;
    ASSERT_GT(path.certificate.events.size(), 10u);
    // up with 1 m/s and down to 0.6 m below; a parabola, which the methods have exactly but for rounding
    EXPECT_NEAR(path.certificate.events[0].time, (1 + std::sqrt(1 + 2 * g * 0.6)) / g, 1e-9);
    EXPECT_NEAR(last(path.q)[1], 0.4, 1e-9);  // at rest on the post
  }
}

TEST(LongFlights, ColumnOfBallsComesToRest) {
  for (double restitution : {0.3, 0.5, 0.7, 0.75, 0.9})
    for (const char* method : {"dopri5", "dop853"}) {
      SCOPED_TRACE(fmt::format("{} with {}", method, restitution));
      const Trajectory path =
          run(balls({{1.1, 0}, {1.3, 0}, {1.5, 0}}, restitution), settings(method, 20, 1e-3, 1e-8));
      EXPECT_TRUE(path.certificate.trusted) << path.certificate.reason;
      for (int i = 0; i < 3; ++i) EXPECT_NEAR(last(path.q)[2 * i + 1], 0.1 + 0.2 * i, 1e-9);
    }
}

TEST(LongFlights, SpinningRodStaysAboveTheFloor) {
  Scene scene;
  scene.solids = {solid("rod", "world",
                        {slide("x", Vector3d::UnitX()), slide("z", Vector3d::UnitZ(), 6),
                         hinge("turn", Vector3d::UnitY(), 0, 20)},
                        {inertial(1, {0, 0, 0}, {0.01, 0.083, 0.083})})};
  for (double restitution : {0.3, 0.5, 0.8, 1.})
    for (double spin : {3., 5., 10., 20.}) {
      CapsuleOverPlane meet;
      meet.capsule = {"rod", {0, 0, 0}};
      meet.axis = Vector3d::UnitX();
      meet.length = 1;
      meet.radius = 0.01;
      meet.plane.on = {"world", {0, 0, 0}};
      meet.surface.restitution = restitution;
      scene.constraints = {{"floor", meet}};
      scene.solids[0].switches[2].v = {spin};
      std::vector<Trajectory> runs;
      for (const char* method : {"dopri5", "dop853"}) {
        SCOPED_TRACE(fmt::format("{} with {} at {} rad/s", method, restitution, spin));
        SimulationSettings how = settings(method, 2, 1e-3, 1e-9);
        how.output_interval = 0.01;
        runs.push_back(run(scene, how));
        const Trajectory& path = runs.back();
        EXPECT_TRUE(path.certificate.trusted) << path.certificate.reason;
        EXPECT_GT(path.certificate.impacts, 0);
        for (Eigen::Index k = 0; k < path.q.rows(); ++k)
          EXPECT_GT(path.q(k, 1) - 0.5 * std::abs(std::sin(path.q(k, 2))) - 0.01, -1e-9);
      }
      // two methods find the same events; errors grow over about ten impacts
      EXPECT_LT((last(runs[0].q) - last(runs[1].q)).cwiseAbs().maxCoeff(), 1e-4)
          << restitution << " at " << spin;
    }
}

TEST(LongFlights, FastBallHitsTheTargetWithinAStep) {
  for (double speed : {1., 30., 130., 500., 2000., 1e5}) {
    SCOPED_TRACE(speed);
    Scene scene;
    scene.gravity.setZero();
    scene.solids = {solid("ball", "world", {slide("x", Vector3d::UnitX(), -0.25 - 0.237 * speed, speed)},
                          {inertial(1, {0, 0, 0}, {1e-3, 1e-3, 1e-3})}),
                    solid("target", "world", {slide("y", Vector3d::UnitX(), 0)},
                          {inertial(1, {0, 0, 0}, {4e-3, 4e-3, 4e-3})})};
    SphereOverSphere meet;
    meet.a = {"ball", {0, 0, 0}};
    meet.b = {"target", {0, 0, 0}};
    meet.radii = {0.05, 0.1};
    meet.surface.restitution = 1;
    scene.constraints = {{"meet", meet}};
    // equal masses: one stops, the other goes on as fast
    const double meets = 0.1 / speed + 0.237;
    const Trajectory path = run(scene, settings("dopri5", 1, 1e-2, 1e-9));
    EXPECT_TRUE(path.certificate.trusted) << path.certificate.reason;
    EXPECT_NEAR(last(path.q)[0], -0.15, 1e-12 * (1 + speed));
    EXPECT_NEAR(last(path.q)[1], speed * (1 - meets), 1e-12 * (1 + speed));
    // time stepping sees that the gap would close within the step, and when
    const Trajectory stepped = run(scene, settings("moreau", 1, 1e-2));
    EXPECT_EQ(stepped.certificate.impacts, 1);
    EXPECT_TRUE(stepped.certificate.trusted) << stepped.certificate.reason;
    EXPECT_NEAR(last(stepped.q)[0], -0.15, 1e-9 * (1 + speed));
    EXPECT_NEAR(last(stepped.q)[1], speed * (1 - meets), 1e-9 * (1 + speed));
  }
}

TEST(LongFlights, RotatingArmHitsTheBall) {
  for (double speed : {7., 10., 20., 300.})
    for (double radius : {0.005, 0.02})
      for (const char* method : {"dopri5", "dop853", "gbs", "gauss16", "rk4_adaptive", "arkode"}) {
        SCOPED_TRACE(fmt::format("{} at {} rad/s", method, speed));
        Scene scene;
        scene.gravity.setZero();
        scene.solids = {
            solid("arm", "world", {hinge("turn", Vector3d::UnitZ(), 0.5, speed)},
                  {inertial(1, {0, 0, 0}, {1, 1, 1})}),
            solid("ball", "world", {slide("x", Vector3d::UnitX(), 0.8), slide("y", Vector3d::UnitY())},
                  {inertial(0.01, {0, 0, 0}, {1e-6, 1e-6, 1e-6})})};
        CapsuleOverCapsule meet;
        meet.a = {"ball", {0, 0, 0}};
        meet.b = {"arm", {0.5, 0, 0}};
        meet.axis_b = Vector3d::UnitX();
        meet.length_b = 1;
        meet.radii = {radius, radius};
        scene.constraints = {{"meet", meet}};
        const double meets = (2 * M_PI - std::asin(2 * radius / 0.8) - 0.5) / speed;
        const Trajectory path = run(scene, settings(method, 1.01 * meets, 1e-3, 1e-9));
        ASSERT_FALSE(path.certificate.events.empty());
        EXPECT_NEAR(path.certificate.events[0].time, meets, 1e-9);
        // time stepping passes over it if its shortest part does, and says so
        if (speed < 100) continue;
        EXPECT_FALSE(run(scene, settings("moreau", 1, 1e-1)).certificate.trusted);
        const Trajectory located = run(scene, settings(method, 1, 1e-3, 1e-9)),
                         stepped = run(scene, settings("moreau", 1, 1e-2));
        if (stepped.certificate.trusted)
          EXPECT_LT((last(stepped.q) - last(located.q)).norm(), 0.05 * last(located.q).norm());
        else
          EXPECT_NE(stepped.certificate.reason.find("may pass through"), std::string::npos);
      }
}

TEST(LongFlights, RestIsReachedWithinRounding) {
  // a fall from so far that rounding of the gap is a nanometre
  Scene scene = balls({{2e6, 0}}, 0.5);
  scene.solids[0].inertials[0] = inertial(1, {0, 0, 0}, {4e9, 4e9, 4e9});
  std::get<SphereOverPlane>(scene.constraints[0].kind).radius = 1e5;
  const Trajectory path = run(scene, settings("dop853", 2500, 1e-3, 1e-9));
  EXPECT_TRUE(path.certificate.trusted) << path.certificate.reason;
  EXPECT_NEAR(last(path.q)[1], 1e5, 1e-6);
}

class Boxes : public testing::TestWithParam<int> {};

TEST_P(Boxes, OfAnySizeStayAboveTheFloor) {
  std::mt19937 dice(GetParam());
  const auto draw = [&dice](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(dice);
  };
  for (int k = 0; k < 24; ++k) {
    const double friction = std::array{0., 0.1, 0.4, 1.}[k % 4],
                 restitution = std::array{0., 0.3, 0.8}[k % 3];
    const Vector3d size(draw(0.05, 0.6), draw(0.05, 0.6), draw(0.05, 0.6)), squares = size.cwiseAbs2();
    const Eigen::Quaterniond q(
        Eigen::AngleAxisd(draw(0, 3), Vector3d(draw(-1, 1), draw(-1, 1), draw(-1, 1)).normalized()));
    const Quaternion turn(q.w(), q.x(), q.y(), q.z());
    Scene scene;
    scene.solids = {
        solid("box", "world",
              {slide("x", Vector3d::UnitX(), 0, draw(-2, 2)), slide("y", Vector3d::UnitY()),
               slide("z", Vector3d::UnitZ(), 1), ball("turn", turn, {draw(-8, 8), draw(-8, 8), draw(-8, 8)})},
              {inertial(1, {0, 0, 0},
                        {(squares[1] + squares[2]) / 12, (squares[0] + squares[2]) / 12,
                         (squares[0] + squares[1]) / 12})})};
    BoxOverPlane meet;
    meet.box = {"box", {0, 0, 0}};
    meet.size = size;
    meet.plane.on = {"world", {0, 0, 0}};
    meet.surface = {restitution, friction};
    scene.constraints = {{"floor", meet}};
    SimulationSettings how = settings("dop853", 4, 1e-3, 1e-8);
    how.output_interval = 0.01;
    SCOPED_TRACE(fmt::format("box {} with friction {}, restitution {}", k, friction, restitution));
    const Trajectory path = run(scene, how);
    EXPECT_TRUE(path.certificate.trusted) << path.certificate.reason;
    double highest = 1e9;
    for (Eigen::Index row = 0; row < path.q.rows(); ++row) {
      const Eigen::Quaterniond R(path.q(row, 3), path.q(row, 4), path.q(row, 5), path.q(row, 6));
      double lowest = 1e9;
      for (int c = 0; c < 8; ++c) {
        const Vector3d corner(c & 1 ? 0.5 : -0.5, c & 2 ? 0.5 : -0.5, c & 4 ? 0.5 : -0.5);
        lowest = std::min(lowest, path.q(row, 2) + (R * size.cwiseProduct(corner))[2]);
      }
      EXPECT_GT(lowest, -1e-8) << "at row " << row;
      // its energy, which must not grow
      const Vector3d v = path.v.row(row).head<3>(), w = path.v.row(row).tail<3>();
      const Vector3d I = scene.solids[0].inertials[0].tensor.diagonal();
      const double energy = 0.5 * v.squaredNorm() + 0.5 * w.dot(I.cwiseProduct(w)) + g * path.q(row, 2);
      EXPECT_LT(energy, highest + 1e-6);
      highest = std::min(highest, energy);
    }
    if (restitution < 0.5 && friction > 0.2) {  // it must be at rest by now
      EXPECT_LT(last(path.v).norm(), 1e-6);
    }
  }
}

// 11 and 12 once failed: when another corner came to rest, a corner at the floor turned down and passed
// through it
INSTANTIATE_TEST_SUITE_P(LongFlights, Boxes, testing::Values(7, 11, 12));

/// A ball of `light` kg on the floor or above it, and one of `heavy` kg above.
Scene pressed(double light, double heavy, double low, double high, double restitution, ImpactLaw law) {
  Scene scene = balls({{low, 0}, {high, 0}}, restitution);
  scene.solids[0].inertials[0] = inertial(light, {0, 0, 0}, light * Vector3d(4e-3, 4e-3, 4e-3));
  scene.solids[1].inertials[0] = inertial(heavy, {0, 0, 0}, heavy * Vector3d(4e-3, 4e-3, 4e-3));
  scene.simulation = settings("dopri5", 5, 1e-3, 1e-9);
  scene.simulation.impacts = law;
  return scene;
}

TEST(MassesFarApart, LightBallCarriesAHeavyOne) {
  for (double ratio : {1e2, 1e4, 1e6}) {
    SCOPED_TRACE(ratio);
    const Trajectory rest = run(pressed(1, ratio, 0.1, 0.3, 0.5, ImpactLaw::sequential));
    EXPECT_TRUE(rest.certificate.trusted) << rest.certificate.reason;
    EXPECT_NEAR(last(rest.q)[3], 0.3, 1e-12);
  }
}

TEST(MassesFarApart, HeavyBallFallsOnALightOne) {
  for (double restitution : {0., 0.5})
    for (double ratio : {1e2, 1e4, 1e6}) {
      SCOPED_TRACE(fmt::format("{} with {}", ratio, restitution));
      const Trajectory fallen = run(pressed(1, ratio, 0.5, 1, restitution, ImpactLaw::simultaneous));
      EXPECT_TRUE(fallen.certificate.trusted) << fallen.certificate.reason;
      EXPECT_NEAR(last(fallen.q)[1], 0.1, 1e-9);
      EXPECT_NEAR(last(fallen.q)[3], 0.3, 1e-9);
    }
  const Scene scene = pressed(1, 1e4, 0.5, 1, 0.5, ImpactLaw::sequential);
  const System system = compiled(scene);
  const auto endless = simulate(system);
  ASSERT_FALSE(endless);
  EXPECT_NE(endless.error().what.find("impacts follow each other without end at t = 0.37"), std::string::npos)
      << endless.error().what;
}

}  // namespace
}  // namespace borelli::test::long_flights_test
