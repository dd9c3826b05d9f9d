// Limbs of equal structure, which the recursive equations compute side by side in lanes, against the paper's
// scan.
#include "dynamics/equations/recursive.hpp"

#include "random_scene.hpp"
#include "recursive_compared.hpp"

namespace borelli::test::recursive_test {
namespace {

// Limbs of equal structure are computed in lanes. Two to nine limbs with different numbers are attached to
// solids of a random scene and to the world; some have springs, forces or rotors, some hang from massless
// solids, and parameters change afterwards.
TEST(Recursive, IdenticalLimbsEqualLagrange) {
  int compared = 0, massless_trees = 0, lanes_used[Quad::count + 1] = {};
  for (unsigned seed = 0; seed < 60; ++seed) {
    Scene scene = RandomScene(seed, 5, false).scene;
    Random random(seed + 900), light(seed + 1700);
    const int forms = random.integer(1, 3);
    for (int form = 0; form < forms; ++form) {
      const bool begins_massless = light.integer(0, 2) == 0;
      std::array<int, 3> kinds, before, armed;
      for (int i = 0; i < 3; ++i) {
        kinds[i] = random.integer(0, 3);
        before[i] = i == 0 ? 0 : random.integer(0, i - 1);
        armed[i] = random.integer(0, 3) == 0;
      }
      const bool at_world = random.integer(0, 1), principal = random.integer(0, 1);
      const int count = random.integer(2, 9);
      for (int limb = 0; limb < count; ++limb)
        for (int i = 0; i < 3; ++i) {
          const auto named = [&](int n) { return fmt::format("limb{}_{}_{}", form, limb, n); };
          std::vector<Switch> switches;
          if (random.integer(0, 2))
            switches.push_back(fixed(random.vector(0.5), random.integer(0, 1) ? rotation_matrix(random.turn())
                                                                              : Eigen::Matrix3d::Identity()));
          switches.push_back(kinds[i] == 0   ? hinge("q" + named(i), random.direction())
                             : kinds[i] == 1 ? slide("q" + named(i), random.direction())
                             : kinds[i] == 2
                                 ? Switch{Screw{random.direction(), random.number(-1, 1)}, "q" + named(i)}
                                 : ball("q" + named(i)));
          if (armed[i]) switches.back().armature = random.number(0.1, 1);
          Inertial inertial = random.inertia().inertial();
          if (principal) inertial.tensor = Eigen::Matrix3d(inertial.tensor.diagonal().asDiagonal());
          std::vector<Inertial> elements{inertial};
          if (i == 0 && begins_massless) elements.clear();
          scene.solids.push_back(solid(named(i),
                                       i > 0      ? named(before[i])
                                       : at_world ? "world"
                                                  : fmt::format("s{}", random.integer(0, 4)),
                                       switches, elements));
        }
      scene.efforts.push_back({fmt::format("pull{}", form),
                               Force{{fmt::format("limb{}_1_2", form), random.vector(1)}, random.vector(3)}});
    }
    if (seed % 3 == 0) scene.efforts.clear();
    const auto system = compile(scene);
    if (!system) continue;
    for (const SideBySide& side : Articulation(*system).trees) {
      ++lanes_used[side.trees.count];
      massless_trees += !system->bodies[side.trees.bodies[0][0]].massive;
    }
    State state = Random(seed + 500).state(*system);
    state.t = 0.3;
    compare(*system, state, fmt::format("seed {}", seed));
    Parameters changed = system->parameters;
    for (double& armature : changed.armatures)
      if (random.integer(0, 3) == 0) armature = random.integer(0, 1) ? random.number(0.1, 1) : 0;
    for (SwitchKind& kind : changed.kinds)
      if (auto* turn = std::get_if<Rotation>(&kind)) turn->axis = random.direction();
    for (Inertial& inertial : changed.inertials) inertial.mass *= random.number(0.5, 2);
    for (Placement& placement : changed.placements)
      if (random.integer(0, 3) == 0)
        placement = Placement({rotation_matrix(random.turn()), random.vector(0.5)});
    compare(*system, changed, state, fmt::format("seed {}, changed", seed));
    ++compared;
  }
  EXPECT_GT(compared, 30);
  EXPECT_GT(massless_trees, 10);
  for (int lanes = 2; lanes <= Quad::count; ++lanes) EXPECT_GT(lanes_used[lanes], 10) << lanes;
}

// Ball joints at the parent's origin pass only mass to the parent; hinges pass more, which must not remain
// for the next evaluation.
TEST(Recursive, IdenticalBallsAtTheOriginEqualLagrange) {
  int balls_first = 0;
  for (const bool listed_first : {true, false}) {
    Random random(7);
    Scene scene;
    scene.gravity = random.vector(10);
    scene.solids.push_back(solid("trunk", "world", free_switches("trunk"), {random.inertia().inertial()}));
    for (const bool balls : {listed_first, !listed_first})
      for (int i = 0; i < 2; ++i) {
        const std::string name = fmt::format("{}{}", balls ? "ball" : "hinge", i);
        std::vector<Switch> switches{ball("q" + name)};
        if (!balls) switches = {fixed(random.vector(0.5)), hinge("q" + name, random.direction())};
        scene.solids.push_back(solid(name, "trunk", switches, {random.inertia().inertial()}));
      }
    const System system = compiled(scene);
    const Articulation articulation(system);
    ASSERT_EQ(articulation.trees.size(), 2);
    const int step = articulation.trees[0].steps[0].steps[0];
    balls_first += std::holds_alternative<Ball>(system.parameters.kinds[step]);
    compare(system, random.state(system), listed_first ? "balls first" : "hinges first");
  }
  EXPECT_EQ(balls_first, 1);
}

// With Welds::kept, a base that is welded to the world is a body. The limbs on it still start at rest.
TEST(Recursive, IdenticalLimbsOnWeldedBasesEqualLagrange) {
  for (const int welded : {1, 2}) {
    Random random(11);
    Scene scene;
    scene.gravity = random.vector(10);
    std::string carrier = "world";
    for (int i = 0; i < welded; ++i) {
      const std::string name = fmt::format("base{}", i);
      scene.solids.push_back(solid(name, carrier, {fixed(random.vector(0.5), rotation_matrix(random.turn()))},
                                   {random.inertia().inertial()}));
      carrier = name;
    }
    for (int i = 0; i < 3; ++i) {
      const std::string arm = fmt::format("arm{}", i), hand = fmt::format("hand{}", i);
      scene.solids.push_back(solid(arm, carrier,
                                   {fixed(random.vector(0.5)), hinge("q" + arm, random.direction())},
                                   {random.inertia().inertial()}));
      scene.solids.push_back(solid(hand, arm,
                                   {fixed(random.vector(0.5)), hinge("q" + hand, random.direction())},
                                   {random.inertia().inertial()}));
    }
    const System system = need(compile(scene, Welds::kept));
    ASSERT_EQ(Articulation(system).trees.size(), 1);
    compare(system, random.state(system), fmt::format("{} welded", welded));
  }
}

// Hands on ball joints, in lanes, on arms and on the world: values cached in body axes are updated when
// inertials change.
TEST(Recursive, PendantsUseChangedInertials) {
  for (const bool on_arms : {true, false}) {
    Random random(3);
    Scene scene;
    scene.gravity = random.vector(10);
    scene.solids.push_back(solid("trunk", "world", free_switches("trunk"), {random.inertia().inertial()}));
    for (int i = 0; i < 4; ++i) {
      const std::string arm = fmt::format("arm{}", i), hand = fmt::format("hand{}", i);
      if (on_arms)
        scene.solids.push_back(
            solid(arm, "trunk", {fixed(random.vector(0.5)), ball("q" + arm)}, {random.inertia().inertial()}));
      scene.solids.push_back(solid(hand, on_arms ? arm : "world",
                                   {fixed(random.vector(0.5)), ball("q" + hand)},
                                   {random.inertia().inertial()}));
    }
    for (const bool pulled : {false, true}) {
      if (pulled) scene.efforts = {{"pull", Force{{"hand1", random.vector(1)}, random.vector(3)}}};
      const System system = compiled(scene);
      const State state = random.state(system);
      Pair w(system);
      ASSERT_EQ(w.recursive.articulation.trees.size(), 1);
      const Eigen::VectorXd efforts = Eigen::VectorXd::LinSpaced(system.nv, -1, 2);
      Parameters p = system.parameters;
      const SideBySide& side = w.recursive.articulation.trees[0];
      const int hand = side.trees.bodies.back()[2], step = side.steps.back().steps[2];
      for (int which = 0; which <= 8; ++which) {
        SCOPED_TRACE(which);
        Inertial& inertial = p.inertials[hand];
        if (which == 1) inertial.mass *= 3;
        if (which == 2) inertial.centre[1] += 0.2;
        if (which == 3) inertial.tensor(2, 2) *= 1.5;
        if (which == 4) p.gravity = random.vector(10);
        if (which == 5) inertial = {2, {0, 0, 0.3}, Eigen::Vector3d(1, 1, 4e-5).asDiagonal()};  // thin
        if (which == 6) inertial = random.inertia().inertial();
        if (which == 7) p.armatures[step] = 0.3;
        if (which == 8) p.armatures[step] = 0;
        for (const double* given : {efforts.data(), static_cast<const double*>(nullptr)}) {
          ASSERT_FALSE(accelerate(system, p, 0, state.q.data(), state.v.data(), {}, w.lagrange, given));
          ASSERT_FALSE(accelerate(system, p, 0, state.q.data(), state.v.data(), {}, w.recursive, given));
          EXPECT_EQ(side.steps.back().link.hangs, which != 5 && which != 7);
          EXPECT_LT(relative(w.recursive.a, w.lagrange.a), 1e-11);
        }
      }
    }
  }
}

// A rack of independent pendulums: values cached from their parameters are updated when these change.
TEST(Recursive, PendulumsUseChangedParameters) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    Scene scene;
    scene.gravity = random.vector(10);
    for (int i = 0; i < 7; ++i) {
      Switch turn = hinge(fmt::format("q{}", i), random.direction());
      if (random.integer(0, 1)) turn.armature = random.number(0.1, 1);
      scene.solids.push_back(solid(fmt::format("bar{}", i), "world",
                                   {fixed(random.vector(1e3), rotation_matrix(random.turn())), turn},
                                   {random.inertia().inertial()}));
    }
    const System system = compiled(scene);
    const State state = random.state(system);
    const double *q = state.q.data(), *v = state.v.data();
    Pair w(system);
    ASSERT_TRUE(w.recursive.articulation.trees.size() == 2 && w.recursive.articulation.trees[0].swings);
    Parameters p = system.parameters;
    const int body = random.integer(1, 7), step = system.bodies[body].first_step;
    const auto change = [&](int which) {
      if (which == 1) p.gravity = random.vector(10);
      if (which == 2) p.placements[step] = Placement({rotation_matrix(random.turn()), random.vector(5)});
      if (which == 3) std::get<Rotation>(p.kinds[step]).axis = random.direction();
      if (which == 4) p.inertials[body] = random.inertia().inertial();
      if (which == 5) p.inertials[body].tensor(2, 2) *= 1.5;
      if (which == 6) p.armatures[step] += 0.5;
    };
    const auto same = [&](const Workspace& a, const Workspace& b) {
      EXPECT_LT(relative(a.a, b.a), 1e-12);
      EXPECT_NEAR(a.terms.kinetic, b.terms.kinetic, 1e-12 * b.terms.kinetic);
      EXPECT_LT(relative(a.terms.group_kinetic, b.terms.group_kinetic), 1e-12);
      EXPECT_LT(relative(a.terms.group_potential, b.terms.group_potential), 1e-12);
      for (std::size_t i = 1; i < system.bodies.size(); ++i) {
        EXPECT_LT(relative(a.kinematics.bodies[i].g, b.kinematics.bodies[i].g), 1e-12);
        EXPECT_LT(relative(a.kinematics.bodies[i].X.R, b.kinematics.bodies[i].X.R), 1e-12);
        EXPECT_LT(relative(a.kinematics.bodies[i].v, b.kinematics.bodies[i].v), 1e-12);
      }
    };
    for (int which = 0; which <= 6; ++which) {
      SCOPED_TRACE(which);
      change(which);
      ASSERT_FALSE(accelerate(system, p, 0, q, v, {}, w.lagrange));
      ASSERT_FALSE(accelerate(system, p, 0, q, v, {}, w.recursive, nullptr, Wanted::accelerations));
      EXPECT_TRUE(w.recursive.articulation.trees[0].swung);
      EXPECT_LT(relative(w.recursive.a, w.lagrange.a), 1e-12);
      complete(system, p, w.recursive);
      same(w.recursive, w.lagrange);
    }
    // a pendulum without inertia about its axis is named
    p.inertials[body] = {1, Vector3d::Zero(), Eigen::Matrix3d::Zero()};
    p.armatures[step] = 0;
    const Fault fault = accelerate(system, p, 0, q, v, {}, w.recursive, nullptr, Wanted::accelerations);
    EXPECT_EQ(fault.kind, Fault::Kind::singular_mass);
    EXPECT_EQ(fault.index, system.steps[step].u);
  }
}

}  // namespace
}  // namespace borelli::test::recursive_test
