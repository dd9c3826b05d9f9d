// Separation of overlapping starts: least moves against closed forms.
#include "dynamics/contacts/put_apart.hpp"

#include <cmath>

#include "scenes.hpp"

namespace borelli::test {
namespace {

constexpr double radius = 0.1;

// Balls on a line along x, each on its own slide.
Scene row_of_balls(const std::vector<double>& places, const std::vector<double>& masses) {
  Scene scene;
  scene.gravity.setZero();
  for (std::size_t i = 0; i < places.size(); ++i) {
    Solid ball;
    ball.name = fmt::format("b{}", i);
    ball.switches = {{.kind = Translation{Vector3d::UnitX()},
                      .coordinate = fmt::format("x{}", i),
                      .motion = {},
                      .q = {places[i]},
                      .v = {0},
                      .ranges = {}}};
    ball.inertials = {inertial(masses[i], {0, 0, 0}, {1, 1, 1})};
    scene.solids.push_back(ball);
  }
  for (std::size_t i = 1; i < places.size(); ++i) {
    SphereOverSphere kind;
    kind.a.solid = scene.solids[i].name;
    kind.b.solid = scene.solids[i - 1].name;
    kind.radii = {radius, radius};
    scene.constraints.push_back({fmt::format("{} on {}", i, i - 1), kind});
  }
  return scene;
}

std::string moved(const System& system, State& state) {
  const auto out = put_apart(system, system.parameters, state);
  EXPECT_TRUE(out) << (out ? "" : out.error().message());
  return out ? *out : "";
}

TEST(PutApart, TwoBodiesMoveInverselyToTheirMasses) {
  const System system = compiled(row_of_balls({0, 0.15}, {1, 3}));
  State state = system.initial;
  const std::string words = moved(system, state);
  EXPECT_NEAR(state.q[0], -0.05 * 3 / 4, 1e-12);
  EXPECT_NEAR(state.q[1], 0.15 + 0.05 / 4, 1e-12);
  EXPECT_EQ(words,
            "contact '1 on 0' overlapped by 0.05 m at the start; it was separated by the smallest move, "
            "mostly of coordinate 'x0', by 0.0375 m");
  EXPECT_EQ(moved(system, state), "");
}

TEST(PutApart, MovesNeighboursInContactToo) {
  // the second and third just touch, so all three move, by least squares (-2d/3, d/3, d/3)
  const System system = compiled(row_of_balls({0, 0.17, 0.37}, {1, 1, 1}));
  State state = system.initial;
  moved(system, state);
  const double d = 0.03;
  EXPECT_NEAR(state.q[0], -2 * d / 3, 1e-9);
  EXPECT_NEAR(state.q[1], 0.17 + d / 3, 1e-9);
  EXPECT_NEAR(state.q[2], 0.37 + d / 3, 1e-9);
}

TEST(PutApart, KeepsOtherConstraints) {
  // two pendulums of 1 m, whose bobs overlap: they swing apart, each by the same angle
  Scene scene;
  for (int i = 0; i < 2; ++i) {
    Solid bob;
    bob.name = fmt::format("bob{}", i);
    bob.switches = free_switches(bob.name);
    bob.switches[0].q = {i == 0 ? -0.05 : 0.05};
    bob.switches[2].q = {-std::sqrt(1 - 0.05 * 0.05)};
    bob.inertials = {inertial(2, {0, 0, 0}, {0.1, 0.1, 0.1})};
    scene.solids.push_back(bob);
    Distance string;
    string.a.solid = bob.name;
    string.distance = constant(1);
    scene.constraints.push_back({bob.name + " string", string});
  }
  SphereOverSphere kind;
  kind.a.solid = "bob0";
  kind.b.solid = "bob1";
  kind.radii = {radius, radius};
  scene.constraints.push_back({"bobs", kind});
  const System system = compiled(scene);
  State state = system.initial;
  moved(system, state);
  EXPECT_NEAR(state.q[0], -radius, 1e-9);
  EXPECT_NEAR(state.q.head<3>().norm(), 1, 1e-9);
}

TEST(PutApart, SeparatesAHeap) {
  Random random(3);
  Scene scene;
  for (int i = 0; i < 30; ++i) {
    Solid ball;
    ball.name = fmt::format("b{}", i);
    ball.switches = free_switches(ball.name);
    for (int k = 0; k < 2; ++k) ball.switches[std::size_t(k)].q = {random.number(-0.25, 0.25)};
    ball.switches[2].q = {random.number(0, 0.5)};
    ball.inertials = {inertial(random.number(0.1, 10), {0, 0, 0}, {1, 1, 1})};
    scene.solids.push_back(ball);
    SphereOverPlane floor;
    floor.sphere.solid = ball.name;
    floor.radius = radius;
    scene.constraints.push_back({ball.name + " on floor", floor});
    for (int j = 0; j < i; ++j) {
      SphereOverSphere kind;
      kind.a.solid = ball.name;
      kind.b.solid = fmt::format("b{}", j);
      kind.radii = {radius, radius};
      scene.constraints.push_back({fmt::format("{} on {}", i, j), kind});
    }
  }
  const System system = compiled(scene);
  State state = system.initial;
  moved(system, state);
  double least = 1, farthest = 0;
  for (int i = 0; i < 30; ++i) {
    const Vector3d at = state.q.segment<3>(7 * i);
    farthest = std::max(farthest, (at - Vector3d(system.initial.q.segment<3>(7 * i))).norm());
    least = std::min(least, at.z() / radius);
    for (int j = 0; j < i; ++j)
      least = std::min(least, (at - Vector3d(state.q.segment<3>(7 * j))).norm() / (2 * radius));
  }
  EXPECT_GT(least, 1 - 2e-9);
  EXPECT_LT(farthest, 4 * radius);  // most overlapped, some almost completely
}

TEST(PutApart, NamesContactsWithoutRoom) {
  Scene scene = row_of_balls({0, 0.15, 0.3}, {1, 1, 1});
  scene.solids[0].switches = {fixed({0, 0, 0}, Eigen::Matrix3d::Identity())};
  scene.solids[2].switches = {fixed({0.3, 0, 0}, Eigen::Matrix3d::Identity())};
  const System system = compiled(scene);
  State state = system.initial;
  const auto out = put_apart(system, system.parameters, state);
  ASSERT_FALSE(out);
  EXPECT_NE(out.error().message().find("overlaps at the start, and no move separates it: "),
            std::string::npos)
      << out.error().message();
}

// A ball on a slide parallel to the plane, and a welded ball: no coordinate moves them off the plane.
TEST(PutApart, NamesAContactThatNoCoordinateSeparates) {
  for (const bool slides : {true, false}) {
    Scene scene;
    scene.solids = {solid("ball", "world", {fixed({0, 0, 0.05})}, {inertial(1, {0, 0, 0}, {1, 1, 1})})};
    if (slides) scene.solids[0].switches.push_back(slide("x", Vector3d::UnitX(), 0, 1));
    SphereOverPlane kind;
    kind.sphere.solid = "ball";
    kind.radius = radius;
    kind.plane.on.solid = "world";
    scene.constraints = {{"floor", kind}};
    const System system = compiled(scene);
    State state = system.initial;
    const auto out = put_apart(system, system.parameters, state);
    ASSERT_FALSE(out);
    EXPECT_EQ(out.error().message(),
              "contact 'floor': overlaps at the start, and no move separates it: 0.05 remains; "
              "change the initial positions");
    for (const char* method : {"moreau", "dop853", "gbs", "rk4"})
      for (const bool apart : {true, false}) {
        SimulationSettings how = settings(method, 0.1, 1e-3);
        how.put_apart = apart;
        const auto path = simulate(system, system.initial, how);
        ASSERT_FALSE(path) << method;
        EXPECT_EQ(path.error().message().find("contact 'floor': overlaps"), 0u) << path.error().message();
      }
  }
}

TEST(PutApart, RunStartsWithoutOverlap) {
  for (const char* method : {"moreau", "dop853"}) {
    SimulationSettings how = settings(method, 0.1, 1e-3);
    how.put_apart = true;
    const Trajectory path = run(row_of_balls({0, 0.15}, {1, 3}), how);
    EXPECT_NEAR(path.q(0, 0), -0.0375, 1e-12) << method;
    EXPECT_TRUE(path.certificate.trusted) << path.certificate.reason;
    ASSERT_EQ(path.certificate.notes.size(), 1u);
    EXPECT_EQ(path.certificate.notes[0].find("contact '1 on 0' overlapped by 0.05 m"), 0u);
  }
}

}  // namespace
}  // namespace borelli::test
