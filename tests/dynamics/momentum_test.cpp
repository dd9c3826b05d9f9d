// Momenta are found to be conserved, and runs conserve them.
#include "dynamics/equations/momentum.hpp"

#include "scenes.hpp"

namespace borelli::test {
namespace {

std::vector<std::string> names(const Scene& scene) {
  const System system = compiled(scene);
  std::vector<std::string> out;
  for (const ConservedMomentum& momentum : conserved_momenta(system, system.parameters))
    out.push_back(momentum.name);
  return out;
}

Scene floating() {
  Scene scene;
  Random random(5);
  std::vector<Switch> switches = free_switches("a");
  switches[0].v = {1};
  switches[3].v = {1, 5, 0.1};
  scene.solids = {solid("a", "world", switches, {random.inertia().inertial()}),
                  solid("b", "a", {fixed({0.5, 0, 0}), ball("b", identity_quaternion(), {3, 0, -2})},
                        {random.inertia().inertial()})};
  return scene;
}

using Names = std::vector<std::string>;

TEST(Momentum, IsListedWhenConserved) {
  EXPECT_EQ(names(floating()),
            (Names{"linear momentum of 'a'", "angular momentum of 'a' about its gravity centre"}));
  EXPECT_EQ(names(roundabout()), Names{"angular momentum of 's1' about its axis"});
  EXPECT_EQ(names(chain(2, true)), Names{});  // its weight has a moment about the hinge
  Scene top;
  top.solids = {solid("top", "world", {ball("turn")}, {link()})};
  EXPECT_EQ(names(top), Names{"angular momentum of 'top' about its fixed point"});
  Scene sledge;  // moves freely in the plane
  sledge.solids = {
      solid("sledge", "world",
            {slide("x", Vector3d::UnitX()), slide("y", Vector3d::UnitY()), hinge("turn", Vector3d::UnitZ())},
            {link()})};
  EXPECT_EQ(names(sledge),
            (Names{"linear momentum of 'sledge'", "angular momentum of 'sledge' about its gravity centre"}));
}

TEST(Momentum, IsNotListedWhenTiedToTheWorld) {
  Scene scene = floating();
  scene.efforts = {{"inner", PointSpring{{"a", {0, 0, 0}}, {"b", {0.1, 0, 0}}, 1, 1, 0}}};
  EXPECT_EQ(names(scene).size(), 2u);
  scene.efforts = {{"outer", PointSpring{{"a", {0, 0, 0}}, {"world", {0.1, 0, 0}}, 1, 1, 0}}};
  EXPECT_EQ(names(scene).size(), 0u);
  scene.efforts = {{"push", Force{{"a", {0, 0, 0}}, {1, 0, 0}, Axes::world, constant(1), {}}}};
  EXPECT_EQ(names(scene).size(), 0u);
  scene = roundabout();
  scene.efforts = {{"brake", CoordinateSpring{{"dof1"}, 0, 1, 0}}};
  EXPECT_EQ(names(scene).size(), 0u);
  scene = roundabout();
  scene.solids[0].switches[0] = driven(scene.solids[0].switches[0], linear(0, 10));
  EXPECT_EQ(names(scene).size(), 0u);
}

TEST(Momentum, OfSolidsJoinedByASpringIsTheirSum) {
  Scene scene;
  Random random(6);
  for (const char* name : {"a", "b"})
    scene.solids.push_back(solid(name, "world", free_switches(name), {random.inertia().inertial()}));
  EXPECT_EQ(names(scene).size(), 4u);  // each by itself
  scene.efforts = {{"spring", PointSpring{{"a", {0.1, 0, 0}}, {"b", {1, 0.2, 0}}, 100, 1, 0.3}}};
  EXPECT_EQ(names(scene).size(), 2u);  // both together
  const Trajectory trajectory = run(compiled(scene), settings("rk4_adaptive", 2, 0.01, 1e-10));
  for (const Conserved& conserved : trajectory.certificate.conserved)
    EXPECT_LT(conserved.drift, 1e-8 * (1 + conserved.scale)) << conserved.name;
}

TEST(Momentum, IsConservedByRunsUpToTheWeightsImpulse) {
  for (const Scene& scene : {floating(), roundabout()}) {
    const Trajectory trajectory = run(compiled(scene), settings("rk4_adaptive", 3, 0.01, 1e-11));
    ASSERT_FALSE(trajectory.certificate.conserved.empty());
    for (const Conserved& conserved : trajectory.certificate.conserved) {
      EXPECT_GT(conserved.scale, 0.1);
      // the tolerance per step, over about a thousand steps
      EXPECT_LT(conserved.drift, 1e-8 * conserved.scale) << conserved.name;
    }
  }
}

}  // namespace
}  // namespace borelli::test
