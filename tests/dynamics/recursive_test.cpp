// The recursive equations against the paper's scan, two independent sets of formulas, on random trees with
// all elements of scenes.
#include "dynamics/equations/recursive.hpp"

#include <Eigen/Eigenvalues>
#include <random>

#include "dynamics/equations/evaluate.hpp"
#include "dynamics/numbers/lanes.hpp"
#include "random_scene.hpp"
#include "recursive_compared.hpp"

namespace borelli::test::recursive_test {
namespace {

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
