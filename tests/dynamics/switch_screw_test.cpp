// The screw: closed form, and the same scene with a slide and a hinge tied by a constraint.
#include "dynamics/scene/switch_screw.hpp"

#include "dynamics/formats/scene_file.hpp"
#include "scenes.hpp"

namespace borelli::test {
namespace {

Switch screw(const std::string& name, const Vector3d& axis, double pitch, double q = 0, double v = 0) {
  Switch out = hinge(name, axis, q, v);
  out.kind = Screw{axis, pitch};
  return out;
}

TEST(Screw, NutRunsDownItsThread) {
  // (I + m p^2) q'' = -m g p
  const double mass = 2, inertia = 0.01, pitch = 0.05;
  Scene scene;
  scene.solids = {solid("nut", "world", {screw("turn", Vector3d::UnitZ(), pitch)},
                        {inertial(mass, {0, 0, 0}, {0.01, 0.01, 0.01})})};
  const double a = -mass * 9.81 * pitch / (inertia + mass * pitch * pitch);
  for (Equations equations : {Equations::recursive, Equations::lagrange}) {
    SimulationSettings how = settings("rk4", 1.5, 0.1);
    how.equations = equations;
    const Trajectory t = run(scene, how);
    EXPECT_TRUE(t.certificate.trusted) << t.certificate.reason;
    EXPECT_NEAR(last(t.q)[0], a * 1.5 * 1.5 / 2, 1e-11);  // exact but for rounding: the motion is quadratic
    EXPECT_NEAR(t.poses.back().p.z(), pitch * last(t.q)[0], 1e-12);
  }
}

/// A link on a screw and a second one on an oblique screw; or each screw as a slide and a hinge tied by a
/// constraint.
Scene two_screws(bool tied) {
  Scene scene;
  const Vector3d first = Vector3d(1, 2, 2) / 3, second = Vector3d(2, -1, 2) / 3;
  const auto joint = [&](int i, const Vector3d& axis, double pitch, double q,
                         double v) -> std::vector<Switch> {
    const std::string name = fmt::format("q{}", i);
    if (!tied) return {screw(name, axis, pitch, q, v)};
    scene.constraints.push_back({fmt::format("thread {}", i),
                                 CoordinateCoupling{{{name + " along"}, {name}}, {1, -pitch}, constant(0)}});
    return {slide(name + " along", axis, pitch * q, pitch * v), hinge(name, axis, q, v)};
  };
  std::vector<Switch> outer = joint(1, second, -0.2, -0.5, 2);
  outer.insert(outer.begin(), fixed({0, 0.1, -1}));
  scene.solids = {solid("a", "world", joint(0, first, 0.3, 0.7, 1), {link()}),
                  solid("b", "a", outer, {link()})};
  return scene;
}

TEST(Screw, EqualsACoupledSlideAndHinge) {
  const Trajectory tied = run(two_screws(true), settings("dop853", 2, 1e-2, 1e-11));
  ASSERT_TRUE(tied.certificate.trusted) << tied.certificate.reason;
  for (Equations equations : {Equations::recursive, Equations::lagrange}) {
    SimulationSettings how = settings("dop853", 2, 1e-2, 1e-11);
    how.equations = equations;
    const Trajectory t = run(two_screws(false), how);
    EXPECT_TRUE(t.certificate.trusted) << t.certificate.reason;
    // two seconds at 1e-11 a step, about a hundred steps
    EXPECT_NEAR(last(t.q)[0], last(tied.q)[1], 1e-8);
    EXPECT_NEAR(last(t.q)[1], last(tied.q)[3], 1e-8);
  }
}

TEST(Screw, RoundTripsThroughSceneFiles) {
  Scene scene;
  scene.solids = {solid("nut", "world", {screw("turn", Vector3d::UnitZ(), -0.002)}, {link()})};
  const Scene back = need(parse_scene(need(write_scene(scene)), "nut.toml"));
  const auto& kind = std::get<Screw>(back.solids[0].switches[0].kind);
  EXPECT_EQ(kind.axis, Vector3d::UnitZ());
  EXPECT_EQ(kind.pitch, -0.002);
  // a screw without pitch is refused in favour of a hinge
  const auto missing =
      parse_scene("[[solid]]\nname = \"nut\"\njoint = {screw = \"z\"}\nmass = 1\n", "nut.toml");
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().message().find("pitch"), std::string::npos) << missing.error().message();
}

TEST(Screw, RefusesAPitchThatIsNotANumber) {
  Scene scene;
  scene.solids = {solid("nut", "world", {screw("turn", Vector3d::UnitZ(), NAN)}, {link()})};
  const auto system = compile(scene);
  ASSERT_FALSE(system);
  EXPECT_NE(system.error().what.find("pitch"), std::string::npos) << system.error().message();
}

}  // namespace
}  // namespace borelli::test
