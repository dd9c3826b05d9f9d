// compile(): merging of welded solids, folding of constants, numbering, and refusals by name.
#include <algorithm>

#include "dynamics/equations/evaluate.hpp"
#include "dynamics/run/simulate.hpp"
#include "dynamics/system/coupled_switch.hpp"
#include "scenes.hpp"

namespace borelli::test {
namespace {

TEST(Compile, SupportListsTheCoordinatesBetweenSolidAndWorld) {
  const System system = compiled(roundabout());
  ASSERT_EQ(system.bodies.size(), 4u);  // the world and three
  const auto support = [&](int b) {
    const auto first = system.branches().support.begin() + system.bodies[b].first_support;
    return std::vector<int>(first, first + system.bodies[b].support_count);
  };
  EXPECT_EQ(support(1), (std::vector<int>{0}));
  EXPECT_EQ(support(2), (std::vector<int>{0, 1}));
  EXPECT_EQ(support(3), (std::vector<int>{0, 2}));
}

TEST(Compile, ParentsMayComeAfterTheirChildren) {
  Scene scene = chain(3, true, 0.3);
  const System in_order = compiled(scene);
  std::swap(scene.solids[0], scene.solids[2]);
  const System mixed = compiled(scene);
  EXPECT_EQ(mixed.solids[0], "l2");
  EXPECT_EQ(mixed.coordinates[0].name, "h0");
  const Evaluation a = need(evaluate(in_order, in_order.initial)), b = need(evaluate(mixed, mixed.initial));
  EXPECT_EQ(a.acceleration, b.acceleration);
}

TEST(Compile, WeldedSolidsMergeAndKeepNamesAndPoses) {
  Scene scene = chain(2, true, 0.4);
  const Inertial extra = inertial(0.7, {0.1, 0, 0}, {0.01, 0.02, 0.025});
  const Pose X{rotation_matrix(Random(1).turn()), {0.2, -0.1, 0.3}};
  scene.solids.insert(scene.solids.begin() + 1, solid("tool", "l0", {fixed(X.p, X.R)}, {extra}));
  scene.solids.push_back(solid("tip", "tool", {fixed({0, 0, 0.1})}, {}));
  const System welded = compiled(scene);
  EXPECT_EQ(welded.bodies.size(), 3u);
  EXPECT_EQ(welded.nv, 2);

  // the same by hand: one solid with both inertials
  Scene by_hand = chain(2, true, 0.4);
  by_hand.solids[0].inertials.push_back(extra.expressed_in(X.R, X.p));
  const System merged = compiled(by_hand);
  const Evaluation a = need(evaluate(welded, welded.initial)), b = need(evaluate(merged, merged.initial));
  EXPECT_LT((a.acceleration - b.acceleration).norm(), 1e-13);

  const Trajectory trajectory = run(welded, settings("rk4", 0.01, 0.01));
  ASSERT_EQ(trajectory.solids, (std::vector<std::string>{"l0", "tool", "l1", "tip"}));
  const Pose expected = trajectory.pose(1, 0) * X;
  EXPECT_LT((trajectory.pose(1, 1).R - expected.R).norm() + (trajectory.pose(1, 1).p - expected.p).norm(),
            1e-14);
}

TEST(Compile, FoldsAwayLockedCoordinates) {
  Scene scene = chain(3, true, 0.3);
  scene.solids[1].switches[1].motion = Locked{};
  const System locked = compiled(scene);
  EXPECT_EQ(locked.nv, 2);
  EXPECT_EQ(locked.bodies.size(), 3u);  // l0 with l1, and l2
  // the same by a constraint instead of folding, which takes another path through the engine
  Scene held = chain(3, true, 0.3);
  held.constraints.push_back({"hold", CoordinateCoupling{{{"h1"}}, {1}, constant(0.3)}});
  const System constrained = compiled(held);
  const Evaluation a = need(evaluate(locked, locked.initial)),
                   b = need(evaluate(constrained, constrained.initial));
  EXPECT_NEAR(a.acceleration[0], b.acceleration[0], 1e-12);
  EXPECT_NEAR(a.acceleration[1], b.acceleration[2], 1e-12);
  EXPECT_NEAR(b.acceleration[1], 0, 1e-12);
}

TEST(Compile, ALockedCoordinateKeepsItsValueInConstraintsAndSprings) {
  Scene scene = chain(2, false, 0.3);
  scene.solids[0].switches[0].motion = Locked{};
  scene.constraints.push_back({"ratio", CoordinateCoupling{{{"h0"}, {"h1"}}, {2, 1}, constant(1)}});
  System system = compiled(scene);
  Result<Trajectory> trajectory = simulate(system, system.initial, settings("rk4", 0.1, 0.01));
  EXPECT_NEAR(last(need(std::move(trajectory)).q)[0], 1 - 2 * 0.3, 1e-12);
}

TEST(Compile, UnnamedCoordinatesGetTheirSolidsName) {
  Scene scene = bars(1);
  scene.solids[0].switches[1].coordinate.clear();
  EXPECT_EQ(compiled(scene).coordinates[0].name, "b0");
  scene.solids[0].switches.push_back(hinge("", Vector3d::UnitX()));
  EXPECT_EQ(compiled(scene).coordinates[1].name, "b0.2");
}

TEST(Compile, SystemLengthIsTheScenesSize) { EXPECT_NEAR(compiled(bars(5)).length, 8, 1e-12); }

// ---- refusals ----

void expect_refused(const Scene& scene, const std::string& where, const std::string& what) {
  const Result<System> system = compile(scene);
  ASSERT_FALSE(system) << "accepted; expected: " << what;
  EXPECT_EQ(system.error().where, where);
  EXPECT_NE(system.error().what.find(what), std::string::npos) << system.error().what;
  EXPECT_EQ(system.error().kind, Error::Kind::use);
}

TEST(CompileRefuses, SolidsWithoutGoodNamesOrParents) {
  Scene scene = chain(2, false);
  scene.solids[1].name = "l0";
  expect_refused(scene, "solid 'l0'", "two solids of this name");
  scene.solids[1].name = "world";
  expect_refused(scene, "solid 'world'", "rename it");
  scene.solids[1].name = "";
  expect_refused(scene, "solid 2", "has no name");
  scene.solids[1].name = "l1";
  scene.solids[1].parent = "l7";
  expect_refused(scene, "solid 'l1'", "'l7' is not in the scene; choose from world, l0, l1");
  scene.solids[1].parent = "l1";
  expect_refused(scene, "solid 'l1'", "its own ancestor");
}

TEST(CompileRefuses, ImpossibleInertia) {
  Scene scene = chain(1, false);
  scene.solids[0].inertials[0].tensor.diagonal() << 1, 1, 3;
  expect_refused(scene, "solid 'l0'", "triangle inequality");
  scene.solids[0].inertials[0] = inertial(-1, {0, 0, 0}, {1, 1, 1});
  expect_refused(scene, "solid 'l0'", "mass is -1");
}

TEST(CompileRefuses, AMasslessLeaf) {
  Scene scene = chain(2, false);
  scene.solids[1].inertials.clear();
  expect_refused(scene, "solid 'l1', coordinate 'h1'", "moves no mass");
}

TEST(CompileRefuses, CoordinatesWithBadNumbers) {
  const auto with = [](auto change) {
    Scene scene = chain(1, false);
    change(scene.solids[0].switches[0]);
    return scene;
  };
  const std::string where = "solid 'l0', coordinate 'h0'";
  expect_refused(with([](Switch& s) { s.kind = Rotation{Vector3d::Zero()}; }), where, "has no direction");
  expect_refused(with([](Switch& s) { s.q = {1, 2}; }), where, "2 numbers; expected 1");
  expect_refused(with([](Switch& s) { s.v = {1, 2}; }), where, "2 numbers");
  expect_refused(with([](Switch& s) { s.q = {NAN}; }), where + ", initial q", "a number that is not finite");
  expect_refused(with([](Switch& s) { s.ranges = {{1, 2}}; }), where, "outside its range of 1 to 2");
  expect_refused(with([](Switch& s) { s.ranges = {{2, 1}}; }), where, "range runs from 2 to 1");
  expect_refused(with([](Switch& s) { s.ranges = {{0, INFINITY}}; }), where, "range runs from 0 to inf");
  expect_refused(with([](Switch& s) { s.ranges = {{0, 1}, {0, 1}}; }), where, "has 2 ranges; expected one");
  expect_refused(with([](Switch& s) {
                   s.motion = Driven{{constant(1)}};
                   s.ranges = {{0, 2}};
                 }),
                 where, "a range has no effect");
  expect_refused(with([](Switch& s) { s.motion = Driven{}; }), where,
                 "driven by 0 functions of time; expected 1");
  expect_refused(with([](Switch& s) { s.motion = Driven{{constant(1)}}; }), where, "remove q and v");
  expect_refused(with([](Switch& s) { s = ball("h0", Quaternion(1, 1, 0, 0)); }), where,
                 "quaternion has length 1.41421");
  Scene scene = chain(2, false);
  scene.solids[1].switches[1].coordinate = "h0";
  expect_refused(scene, "solid 'l1', coordinate 'h0'", "names must differ");
}

TEST(CompileRefuses, EffortsAndConstraintsOnMissingObjects) {
  Scene scene = chain(1, false);
  scene.efforts = {{"pull", Force{{"l9", {0, 0, 0}}, {1, 0, 0}, Axes::world, constant(1), {}}}};
  expect_refused(scene, "effort 'pull'", "its 'at' is on solid 'l9', which is not in the scene");
  scene.efforts = {{"spring", CoordinateSpring{{"h9"}, 1, 0, 0}}};
  expect_refused(scene, "effort 'spring'", "coordinate 'h9', which is not in the scene; choose from h0");
  scene.efforts = {{"spring", CoordinateSpring{{"h0"}, NAN, 0, 0}}};
  expect_refused(scene, "effort 'spring'", "'stiffness' is not a finite number");
  scene.efforts.clear();
  scene.constraints = {{"rod", Distance{}}, {"rod", Distance{}}};
  expect_refused(scene, "constraint 'rod'", "two constraints of this name");
  scene.constraints = {{"gear", CoordinateCoupling{{{"h0"}}, {}, constant(0)}}};
  expect_refused(scene, "constraint 'gear'", "one ratio per coordinate");
  scene.constraints = {{"own", FunctionConstraint{}}};
  expect_refused(scene, "constraint 'own'", "has no function");
}

// ---- many solids ----

// A chain of n links; the first hangs from the world.
Scene long_chain(int n) {
  Scene scene;
  scene.name = "long chain";
  scene.gravity.setZero();
  for (int i = 0; i < n; ++i) {
    const std::string parent = i == 0 ? world_name : fmt::format("l{}", i - 1);
    scene.solids.push_back(
        solid(fmt::format("l{}", i), parent,
              {fixed({0, 0, i == 0 ? 0. : -1.}), hinge(fmt::format("h{}", i), Vector3d::UnitY())}, {link()}));
  }
  return scene;
}

// Memory grows linearly with the chain's length. Only the mass matrix would grow with its square, to 80 GB
// for 100 000 coordinates, and compile() does not make it.
TEST(Compile, MemoryOfLongChainsGrowsLinearly) {
  const int n = 100000;
  const System system = compiled(long_chain(n));
  ASSERT_EQ(system.nv, n);
  EXPECT_EQ(system.bodies.back().support_count, n);
  const auto matrix = evaluate(system, system.initial);
  ASSERT_FALSE(matrix);
  EXPECT_NE(matrix.error().message().find("long chain: the mass matrix of 100000 coordinates needs"),
            std::string::npos)
      << matrix.error().message();
}

// The straight chain spins about its own length like one rod, at a constant rate.
TEST(Compile, LongChainsAreSimulated) {
  const int n = 20000;
  Scene scene = long_chain(n);
  std::get<Rotation>(scene.solids[0].switches[1].kind).axis = Vector3d::UnitZ();
  scene.solids[0].switches[1].v = {2};
  const Trajectory path = run(scene, settings("rk4", 2e-3, 1e-3));
  EXPECT_NEAR(last(path.q)[0], 4e-3, 1e-12);
  EXPECT_LT(last(path.q).tail(n - 1).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_NEAR(path.kinetic.back(), 0.5 * n * 0.001 * 4, 1e-9 * n);
}

TEST(Compile, SixtyThousandFreeSolidsFall) {
  const int n = 60000;
  Scene scene;
  scene.name = "rain";
  for (int i = 0; i < n; ++i)
    scene.solids.push_back(solid(fmt::format("s{}", i), "world", free_switches(fmt::format("s{}", i)),
                                 {inertial(1, {0, 0, 0}, {1, 1, 1})}));
  const System system = compiled(scene);
  const Trajectory path = run(system, settings("rk4", 0.01, 0.01));
  EXPECT_NEAR(path.poses.back().p.z(), -0.5 * 9.81 * 1e-4, 1e-15);
  EXPECT_TRUE(path.certificate.trusted) << path.certificate.reason;
  SimulationSettings many = settings("rk4", 100, 0.01);
  many.output_interval = 0.01;
  for (const SimulationSettings& how : {many, settings("cvode", 1, 0.01)}) {
    const auto out = simulate(system, system.initial, how);
    ASSERT_FALSE(out);
    EXPECT_NE(out.error().message().find("of memory; "), std::string::npos) << out.error().message();
  }
}

TEST(Compile, ResolvesThousandsOfChainedCouplings) {
  const int n = 20000;
  Scene scene;
  for (int i = 0; i < n; ++i) {
    Solid& cart = scene.solids.emplace_back(
        solid(fmt::format("s{}", i), "world",
              {slide(fmt::format("x{}", i), Vector3d::UnitX(), i == n - 1 ? 3. : 0.)},
              {inertial(1, {0, 0, 0}, {1, 1, 1})}));
    if (i == n - 1) continue;
    cart.switches[0].q = cart.switches[0].v = {};
    cart.switches[0].motion = Coupled{fmt::format("x{}", i + 1), Polynomial{{1e-4, 1}}};
  }
  const auto whole = without_coupled_switches(scene);
  ASSERT_TRUE(whole) << whole.error().message();
  for (int i = 0; i < n; i += 1000)
    EXPECT_NEAR(whole->solids[std::size_t(i)].switches[0].q.at(0), 3 + 1e-4 * (n - 1 - i), 1e-9) << i;
}

}  // namespace
}  // namespace borelli::test
