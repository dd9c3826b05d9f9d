// The recursive equations against the paper's scan, two independent sets of formulas, on random trees with
// all elements of scenes.
#include "dynamics/equations/recursive.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <random>

#include "dynamics/equations/equations.hpp"
#include "dynamics/equations/evaluate.hpp"
#include "dynamics/equations/inverse_dynamics.hpp"
#include "dynamics/numbers/lanes.hpp"
#include "random_scene.hpp"

namespace borelli::test::recursive_test {
namespace {

/// The largest difference relative to the largest entry.
double relative(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  if (b.size() == 0) return 0;
  return (a - b).cwiseAbs().maxCoeff() / std::max(1e-3, b.cwiseAbs().maxCoeff());
}

double condition(const Eigen::MatrixXd& A) {
  const Eigen::VectorXd s = A.jacobiSvd().singularValues();
  return s[0] / s[s.size() - 1];
}

struct Pair {
  Workspace lagrange, recursive;
  explicit Pair(const System& system)
      : lagrange(system, Equations::lagrange), recursive(system, Equations::recursive) {}
};

Eigen::VectorXd efforts_for(const System& system, const Parameters& p, const State& state,
                            const Eigen::VectorXd& a, Workspace& w) {
  Eigen::VectorXd out(system.nv);
  inverse_dynamics(system, p, p.inertials, state.t, state.q.data(), state.v.data(), a.data(), w.kinematics,
                   w.efforts, w.articulation, out.data());
  return out;
}

void compare(const System& system, const Parameters& p, const State& state, const std::string& which) {
  Pair w(system);
  const Fault fault = update_terms(system, p, state.t, state.q.data(), state.v.data(), w.lagrange);
  const Fault same = update_terms(system, p, state.t, state.q.data(), state.v.data(), w.recursive);
  const int free = system.nv;
  const Rows free_A = Rows(w.lagrange.terms.A.selfadjointView<Eigen::Lower>()).topLeftCorner(free, free);
  if (fault || same || condition(free_A) > 1e10) {
    // a coordinate depends on others, exactly or up to rounding
    EXPECT_GT(condition(free_A), 1e10) << which;
    EXPECT_TRUE(!fault || fault.kind == Fault::Kind::singular_mass) << which;
    const Fault again = accelerate(system, p, state.t, state.q.data(), state.v.data(), {}, w.recursive);
    EXPECT_EQ(again.index, same.index) << which;
    return;
  }
  const LagrangeTerms &l = w.lagrange.terms, &r = w.recursive.terms;
  // sums of about a hundred terms: 1e-14 each of the largest
  const Rows A = l.A.selfadjointView<Eigen::Lower>();
  EXPECT_LT(relative(r.A.selfadjointView<Eigen::Lower>(), A), 1e-12) << which;
  EXPECT_LT(relative(r.B, l.B), 1e-12) << which;
  EXPECT_LT(relative(r.Q, l.Q), 1e-12) << which;
  EXPECT_NEAR(r.kinetic, l.kinetic, 1e-12 * l.kinetic) << which;
  EXPECT_NEAR(r.potential, l.potential, 1e-12 * (1 + std::abs(l.potential))) << which;
  EXPECT_LT(relative(r.group_kinetic, l.group_kinetic), 1e-12) << which;
  EXPECT_LT(relative(r.group_potential, l.group_potential), 1e-12) << which;
  EXPECT_LT(relative(w.recursive.rows.L, w.lagrange.rows.L), 1e-12) << which;
  EXPECT_LT(relative(w.recursive.rows.E, w.lagrange.rows.E), 1e-12) << which;
  for (std::size_t b = 1; b < system.bodies.size(); ++b) {
    if (!system.bodies[b].touched) continue;
    const BodyMotion &ml = w.lagrange.kinematics.bodies[b], &mr = w.recursive.kinematics.bodies[b];
    EXPECT_LT(relative(mr.v, ml.v) + relative(mr.vdot, ml.vdot) + relative(mr.wdot, ml.wdot), 3e-12) << which;
  }

  const Eigen::VectorXd wanted = Eigen::VectorXd::LinSpaced(free, 2, -1);
  const Eigen::VectorXd moved = A.topLeftCorner(free, free) * wanted;
  EXPECT_LT((efforts_for(system, p, state, wanted, w.recursive) - (moved + (l.B - l.Q).head(free)))
                .cwiseAbs()
                .maxCoeff(),
            1e-12 * (moved.cwiseAbs().maxCoeff() + l.B.cwiseAbs().maxCoeff() + l.Q.cwiseAbs().maxCoeff()))
      << which;

  // rounding of the terms (about 10 units) times the conditions of A and of the rows
  const int n = system.nv;
  double amplified = condition(A.topLeftCorner(n, n));
  if (system.rows > 0) amplified *= condition(w.lagrange.rows.L.leftCols(n));
  const double bound = 10 * 2.3e-16 * amplified;
  const Eigen::VectorXd efforts = Eigen::VectorXd::LinSpaced(system.nv, -1, 2);
  for (const double* given : {efforts.data(), static_cast<const double*>(nullptr)}) {
    ASSERT_FALSE(accelerate(system, p, state.t, state.q.data(), state.v.data(), {}, w.lagrange, given));
    ASSERT_FALSE(accelerate(system, p, state.t, state.q.data(), state.v.data(), {}, w.recursive, given));
    EXPECT_LT(relative(w.recursive.a, w.lagrange.a), bound) << which;
    EXPECT_LT(relative(w.recursive.multipliers, w.lagrange.multipliers), bound) << which;
    EXPECT_NEAR(w.recursive.power.total(), w.lagrange.power.total(),
                bound * (1 + std::abs(w.lagrange.power.total())))
        << which;
    // the equations hold to rounding of their largest term, however badly conditioned A is
    const Eigen::VectorXd residual = A.topLeftCorner(n, n) * w.recursive.a + l.B.head(n) - l.Q.head(n) -
                                     w.lagrange.rows.L.leftCols(n).transpose() * w.recursive.multipliers;
    const double part =
        A.cwiseAbs().maxCoeff() * w.recursive.a.cwiseAbs().maxCoeff() + l.B.cwiseAbs().maxCoeff() +
        l.Q.cwiseAbs().maxCoeff() +
        (system.rows ? w.lagrange.rows.L.cwiseAbs().maxCoeff() * w.recursive.multipliers.cwiseAbs().maxCoeff()
                     : 0);
    EXPECT_LT(residual.cwiseAbs().maxCoeff(), 1e-12 * part) << which;
    if (system.driven_nv > 0) {  // these are sums of such terms, which may nearly cancel
      EXPECT_LT((w.recursive.drive_efforts - w.lagrange.drive_efforts).cwiseAbs().maxCoeff(), bound * part)
          << which;
    }
  }

  // terms that a step leaves out are the same when computed afterwards
  const LagrangeTerms all = w.recursive.terms;
  const std::vector<BodyMotion> bodies = w.recursive.kinematics.bodies;
  Workspace later(system, Equations::recursive);
  ASSERT_FALSE(accelerate(system, p, state.t, state.q.data(), state.v.data(), {}, later, nullptr,
                          Wanted::accelerations));
  EXPECT_EQ(relative(later.a, w.recursive.a), 0) << which;
  complete(system, p, later);
  EXPECT_EQ(later.terms.kinetic, all.kinetic) << which;
  EXPECT_EQ(relative(later.terms.group_potential, all.group_potential), 0) << which;
  for (std::size_t b = 1; b < bodies.size(); ++b) {
    if (!system.bodies[b].touched) continue;
    EXPECT_TRUE(later.kinematics.bodies[b].g == bodies[b].g && later.kinematics.bodies[b].v == bodies[b].v)
        << which;
  }
}

void compare(const System& system, const State& state, const std::string& which) {
  compare(system, system.parameters, state, which);
}

void compare_random(int solids, bool constrained, Welds welds = Welds::merged, bool acted = true) {
  int compared = 0;
  for (unsigned seed = 0; seed < 60; ++seed) {
    Scene scene = RandomScene(seed, solids, constrained).scene;
    if (!acted) scene.efforts.clear();
    const auto system = compile(scene, welds);
    if (!system || system->nv == 0) continue;  // compile() refuses coordinates that move no mass
    State state = Random(seed + 500).state(*system);
    state.t = 0.3;
    compare(*system, state, fmt::format("seed {}, {} solids", seed, solids));
    ++compared;
  }
  EXPECT_GT(compared, 30);
}

TEST(Recursive, EqualsLagrangeOnSmallRandomScenes) { compare_random(3, false); }
TEST(Recursive, EqualsLagrangeOnRandomScenes) { compare_random(12, false); }
TEST(Recursive, EqualsLagrangeOnConstrainedRandomScenes) { compare_random(12, true); }
TEST(Recursive, EqualsLagrangeWithWeldsKept) { compare_random(12, false, Welds::kept); }
TEST(Recursive, EqualsLagrangeUnderWeightAlone) { compare_random(12, false, Welds::merged, false); }
TEST(Recursive, EqualsLagrangeOnLongChains) {
  const System system = compiled(chain(30, true));
  compare(system, Random(1).state(system), "chain");
}

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

// Given accelerations do not remain for a call without any.
TEST(Recursive, ForgetsGivenAccelerations) {
  for (const Equations equations : {Equations::lagrange, Equations::recursive}) {
    const System system = compiled(RandomScene(1, 6, false).scene);
    const State state = Random(501).state(system);
    const Eigen::VectorXd a = Eigen::VectorXd::Constant(system.nv, 7);
    const auto move = [&](const double* given, Kinematics& k) {
      update_kinematics<double>(system, system.parameters, system.parameters.inertials, state.t,
                                state.q.data(), state.v.data(), given, k);
    };
    Kinematics once(system, equations), again(system, equations);
    move(nullptr, once);
    move(a.data(), again);
    EXPECT_NE(again.bodies.back().vdot, once.bodies.back().vdot);
    move(nullptr, again);
    EXPECT_EQ(again.acceleration, once.acceleration);
    for (std::size_t b = 1; b < system.bodies.size(); ++b)
      EXPECT_TRUE(again.bodies[b].vdot == once.bodies[b].vdot && again.bodies[b].wdot == once.bodies[b].wdot)
          << b;
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

// A link without mass between two balls turns about the line through their centres without resistance, in every
// pose and at every scale. Rounding leaves a pivot that need not be small beside its diagonal entry.
TEST(Recursive, LinkWithoutMassBetweenBallsIsNamedSingular) {
  for (unsigned seed = 0; seed < 300; ++seed) {
    Random random(seed);
    Scene scene;
    scene.solids = {
        solid("base", "world", {hinge("h", random.vector(1).normalized())}, {random.inertia().inertial()}),
        solid("link", "base", {fixed(random.vector(0.3)), ball("b1")}, {}),
        solid("end", "link", {fixed(random.vector(std::pow(10., random.number(-2, 1)))), ball("b2")},
              {random.inertia().inertial()})};
    const System system = compiled(scene);
    const State state = random.state(system);
    for (const Equations equations : {Equations::lagrange, Equations::recursive}) {
      Workspace w(system, equations);
      const Fault fault = accelerate(system, system.parameters, 0, state.q.data(), state.v.data(), {}, w);
      EXPECT_EQ(fault.kind, Fault::Kind::singular_mass) << seed;
    }
  }
}

// The mass matrix needs poses only: with drives that carry free coordinates, balls and many branches.
TEST(Recursive, MassMatrixNeedsOnlyPoses) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    const System system = compiled(random_tree(seed, {.balls = true, .drives = true}));
    const Parameters& p = system.parameters;
    const State state = Random(seed).state(system);
    Workspace moving(system, Equations::recursive);
    Kinematics kinematics(system, Equations::recursive);
    LagrangeTerms terms(system);
    ASSERT_FALSE(update_terms(system, p, 0.2, state.q.data(), state.v.data(), moving));
    Recursion recursion(system);
    update_kinematics<double>(system, p, p.inertials, 0.2, state.q.data(), nullptr, nullptr, kinematics);
    find_mass_matrix(system, p, p.inertials, kinematics, recursion, terms);
    const Rows same = moving.terms.A.triangularView<Eigen::Lower>(),
               A = terms.A.triangularView<Eigen::Lower>();
    EXPECT_LT(relative(A, same), 1e-14) << seed;
  }
}

// Mass ratios of a million, a kilometre from the world's origin. Rounding may grow by the distance in lengths
// of the scene (1e3), not more.
TEST(Recursive, EqualsLagrangeFarFromTheOrigin) {
  Scene scene = chain(6, true);
  scene.solids[0].switches.insert(scene.solids[0].switches.begin(), fixed({1000, 500, -300}));
  scene.solids[2].inertials[0].mass = 1e6;
  const System system = compiled(scene);
  const State state = Random(2).state(system);
  Pair w(system);
  for (Workspace* one : {&w.lagrange, &w.recursive})
    ASSERT_FALSE(accelerate(system, system.parameters, 0, state.q.data(), state.v.data(), {}, *one));
  const double error = relative(w.recursive.a, w.lagrange.a);
  const Rows A = w.lagrange.terms.A.selfadjointView<Eigen::Lower>();
  EXPECT_LT(error, 1e3 * 10 * 2.3e-16 * std::sqrt(condition(A)));
}

// The same chain far away needs the same efforts to the last digits, since links are placed relative to each
// other.
TEST(Recursive, InverseDynamicsLosesNoDigitsFarFromTheOrigin) {
  Scene scene = chain(6, true);
  const System near = compiled(scene);
  scene.solids[0].switches.insert(scene.solids[0].switches.begin(), fixed({1e6, 5e5, -3e5}));
  const System far = compiled(scene);
  const State state = Random(2).state(near);
  const Eigen::VectorXd a = Eigen::VectorXd::LinSpaced(near.nv, -1, 2);
  Workspace w(near), away(far);
  EXPECT_LT(relative(efforts_for(far, far.parameters, state, a, away),
                     efforts_for(near, near.parameters, state, a, w)),
            1e-14);
}

TEST(Recursive, NamesACoordinateWithoutInertia) {
  // two hinges about one axis in one point: the first can always follow the second
  Scene scene;
  scene.solids = {solid("a", "world", {hinge("first", Vector3d::UnitY())}, {}),
                  solid("b", "a", {hinge("second", Vector3d::UnitY())}, {link()})};
  for (Equations equations : {Equations::lagrange, Equations::recursive}) {
    scene.simulation.equations = equations;
    const auto refused = evaluate(compiled(scene), compiled(scene).initial);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().where, "coordinate 'first'");
  }
}

// A bar's moment about its own axis may be arbitrarily small: it is inertia, not rounding.
TEST(Recursive, ThinBarRotatesAboutItsAxis) {
  Scene scene;
  scene.gravity.setZero();
  scene.solids = {solid("bar", "world", {hinge("spin", Vector3d::UnitZ())},
                        {inertial(1, {0, 0, -0.5}, {1.0 / 12, 1.0 / 12, 1e-15})})};
  scene.efforts = {{"turn", Torque{{"bar"}, {0, 0, 1e-15}, Axes::world, constant(1), {}}}};
  for (Equations equations : {Equations::lagrange, Equations::recursive}) {
    scene.simulation.equations = equations;
    const System system = compiled(scene);
    EXPECT_NEAR(need(evaluate(system, system.initial)).acceleration[0], 1, 1e-12);
  }
}

// A hinge carries a slide along its own arc, so only its own inertia resists it. The carried mass at a
// distance leaves rounding.
TEST(Recursive, NamesInertiaLostInRounding) {
  const Vector3d out(1.1, 0.3, 0), along = Vector3d::UnitZ().cross(out).normalized();
  for (const double own : {1e-15, 1e-6}) {
    Scene scene;
    scene.solids = {solid("arm", "world", {hinge("turn", Vector3d::UnitZ())},
                          {inertial(1e-9, Vector3d::Zero(), {own, own, own})}),
                    solid("bead", "arm", {fixed(out), slide("glide", along)},
                          {inertial(1.7, Vector3d::Zero(), {1e-16, 1e-16, 1e-16})})};
    scene.efforts = {{"turn", Torque{{"arm"}, {0, 0, own}, Axes::world, constant(1), {}}}};
    for (Equations equations : {Equations::lagrange, Equations::recursive}) {
      scene.simulation.equations = equations;
      const System system = compiled(scene);
      const auto evaluated = evaluate(system, system.initial);
      if (own < 1e-14) {
        ASSERT_FALSE(evaluated) << evaluated->acceleration.transpose();
        EXPECT_NE(evaluated.error().what.find("mass matrix is singular"), std::string::npos)
            << evaluated.error().what;
      } else {
        // up to the rounding of 1.7 kg at 1.14 m, 1e-16 of it, over 1e-6
        EXPECT_NEAR(need(evaluated).acceleration[0], 1, 1e-9);
      }
    }
  }
}

// The bound for judging accelerations is at least the body's inertia about any axis.
TEST(Recursive, InertiaBoundIsNotBelowTheInertia) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> number(-1, 1);
  for (int i = 0; i < 100; ++i) {
    const Vector3d size(number(random), number(random), number(random));
    const Matrix3d turn = Eigen::Quaterniond(number(random), number(random), number(random), number(random))
                              .normalized()
                              .toRotationMatrix();
    const double mass = 1 + number(random);
    const Vector3d centre(number(random), number(random), number(random));
    const Matrix3d cloud = turn * Vector3d(size.cwiseAbs2()).asDiagonal() * turn.transpose();
    const Inertial inertial{mass, centre, cloud.trace() * Matrix3d::Identity() - cloud};
    const Matrix3d about =
        inertial.tensor + mass * (centre.squaredNorm() * Matrix3d::Identity() - centre * centre.transpose());
    const double largest = Eigen::SelfAdjointEigenSolver<Matrix3d>(about).eigenvalues()[2];
    const InertiaBound<double> bound = bound_of(inertial);
    EXPECT_EQ(bound.mass, mass);
    EXPECT_GE(bound.polar_inertia(), largest);
    EXPECT_LE(bound.polar_inertia(), 2 * inertial.tensor.trace() + 3 * mass * centre.squaredNorm());
    // in lanes, for each lane
    VariedInertial<Lanes> eight;
    std::vector<Inertial> each;
    for (int lane = 0; lane < Lanes::count; ++lane) {
      const double part = 1. / (1 + lane);
      each.push_back({part * mass, part * centre, part * inertial.tensor});
      eight.set(lane, each[lane]);
    }
    eight.settle();
    const InertiaBound<Lanes> bounds = bound_of(eight);
    for (int lane = 0; lane < Lanes::count; ++lane) {
      EXPECT_EQ(bounds.polar_inertia()[lane], bound_of(each[lane]).polar_inertia());
      EXPECT_EQ(bounds.mass[lane], each[lane].mass);
    }
  }
}

// Ball joints are eliminated as a symmetric 3x3 matrix, or axis by axis if it is nearly singular.
TEST(Recursive, BallsOfThinBarsEqualLagrange) {
  for (const double thin : {1e-2, 1e-4, 1e-6}) {
    Scene scene;
    for (int i = 0; i < 4; ++i) {
      Switch ball;
      ball.kind = Ball{};
      ball.coordinate = fmt::format("b{}", i);
      if (i == 2) ball.armature = 0.3;
      scene.solids.push_back(solid(fmt::format("s{}", i), i == 0 ? "world" : fmt::format("s{}", i - 1),
                                   {fixed({0.1, 0.2, -1}), ball},
                                   {inertial(1, {0, 0, -0.5}, {1.0 / 12, 1.0 / 12, thin})}));
    }
    const System system = compiled(scene);
    compare(system, Random(5).state(system), fmt::format("thin by {}", thin));
  }
}

TEST(Recursive, SimulationsEqualLagrange) {
  for (bool constrained : {false, true}) {
    Scene scene = constrained ? chain(4, true, 0.3) : roundabout();
    if (constrained)
      scene.constraints = {{"rod", Distance{{"l3", {0, 0, -1}}, {"world", Vector3d::Zero()}, constant(3.5)}}};
    scene.solids[0].switches.back().v = {1};
    SimulationSettings how = settings("rk4", 1, 1e-3);
    how.equations = Equations::lagrange;
    const Trajectory lagrange = run(scene, how);
    how.equations = Equations::recursive;
    const Trajectory recursive = run(scene, how);
    // a thousand steps of rounding (some units of 10 rad each), which the motion may magnify tenfold
    EXPECT_LT((last(recursive.q) - last(lagrange.q)).norm(), 1e-10);
    EXPECT_TRUE(recursive.certificate.trusted) << recursive.certificate.reason;
  }
}

}  // namespace
}  // namespace borelli::test::recursive_test
