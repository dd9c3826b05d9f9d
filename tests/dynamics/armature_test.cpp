// Armature: the rotor inertia of a coordinate, in both sets of equations, in drives, energies and momenta.
#include "dynamics/equations/armature.hpp"

#include <gtest/gtest.h>

#include "dynamics/equations/derivatives.hpp"
#include "dynamics/equations/equations.hpp"
#include "dynamics/equations/evaluate.hpp"
#include "dynamics/formats/scene_file.hpp"
#include "scenes.hpp"

namespace borelli::test {
namespace {

/// A random tree with balls and drives, and an armature on most coordinates.
Scene rotors(unsigned seed) {
  Scene scene = random_tree(seed, {.balls = true, .drives = true});
  Random random(seed + 100);
  for (Solid& solid : scene.solids)
    for (Switch& s : solid.switches)
      if (!std::holds_alternative<Fixed>(s.kind) && random.integer(0, 3) > 0)
        s.armature = random.number(0, 2);
  return scene;
}

Scene without(Scene scene) {
  for (Solid& solid : scene.solids)
    for (Switch& s : solid.switches) s.armature = 0;
  return scene;
}

TEST(Armature, PendulumMatchesHandCalculation) {
  // a point of 2 kg on 1 m, with a rotor of 3 kg m^2: (2 + 3) a = -2 g sin(q)
  Scene scene;
  scene.solids = {
      solid("p", "world", {hinge("q", Vector3d::UnitY(), 0.4, 1.5)}, {inertial(2, {0, 0, -1}, {0, 0, 0})})};
  scene.solids[0].switches[0].armature = 3;
  for (const Equations equations : {Equations::lagrange, Equations::recursive}) {
    scene.simulation.equations = equations;
    const System system = compiled(scene);
    const Evaluation e = need(evaluate(system, system.initial));
    EXPECT_NEAR(e.mass_matrix(0, 0), 5, 1e-14);
    EXPECT_NEAR(e.acceleration[0], -2 * 9.81 * std::sin(0.4) / 5, 1e-14);
    EXPECT_NEAR(e.kinetic_energy, 0.5 * 5 * 1.5 * 1.5, 1e-14);
    EXPECT_NEAR(e.bias[0], 0, 1e-14);
  }
}

TEST(Armature, ChangesOnlyTheDiagonalOfTheMassMatrix) {
  for (unsigned seed = 0; seed < 5; ++seed) {
    const Scene scene = rotors(seed);
    const System system = compiled(scene), bare = compiled(without(scene));
    Random random(seed);
    const State state = random.state(system);
    const Evaluation with = need(evaluate(system, state)), none = need(evaluate(bare, state));
    Eigen::VectorXd expected = Eigen::VectorXd::Zero(system.nv);
    for_each_armature(system, system.parameters, [&](int u, double J) {
      if (u < system.nv) expected[u] = J;
    });
    EXPECT_GT(expected.maxCoeff(), 0);
    const Rows more = with.mass_matrix - none.mass_matrix;
    EXPECT_LT((more - Rows(expected.asDiagonal())).cwiseAbs().maxCoeff(), 1e-13 * with.mass_matrix.norm());
    EXPECT_LT((with.bias - none.bias).norm(), 1e-13 * none.bias.norm());  // free rows: no velocity terms
  }
}

TEST(Armature, BothSetsOfEquationsAgree) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    Scene scene = rotors(seed);
    scene.simulation.equations = Equations::lagrange;
    const System first = compiled(scene);
    scene.simulation.equations = Equations::recursive;
    const System second = compiled(scene);
    Random random(seed);
    const State state = random.state(first);
    Workspace a(first), b(second);
    ASSERT_FALSE(accelerate(first, first.parameters, 0.3, state.q.data(), state.v.data(), {}, a));
    ASSERT_FALSE(accelerate(second, second.parameters, 0.3, state.q.data(), state.v.data(), {}, b));
    // rounding, times the condition of A (up to 1e5 here)
    EXPECT_LT((a.a - b.a).norm(), 1e-10 * a.a.norm()) << "seed " << seed;
    EXPECT_LT((a.drive_efforts - b.drive_efforts).norm(), 1e-10 * a.drive_efforts.norm()) << "seed " << seed;
    EXPECT_NEAR(a.terms.kinetic, b.terms.kinetic, 1e-12 * a.terms.kinetic);
    EXPECT_LT((a.terms.group_kinetic - b.terms.group_kinetic).norm(), 1e-12 * a.terms.kinetic);
  }
}

TEST(Armature, InverseDynamicsIncludesIt) {
  for (unsigned seed = 0; seed < 3; ++seed) {
    const System system = compiled(rotors(seed));
    Random random(seed);
    const State state = random.state(system);
    Eigen::VectorXd a(system.nv);
    for (double& x : a) x = random.number(-2, 2);
    const Evaluation e = need(evaluate(system, state));
    const InverseDynamics inverse = need(inverse_dynamics(system, state, a));
    const Eigen::VectorXd expected = e.mass_matrix * a + e.bias - e.generalized_efforts;
    EXPECT_LT((inverse.efforts - expected).norm(), 1e-12 * expected.norm());
    EXPECT_LT((inverse.efforts_by_a - e.mass_matrix).norm(), 1e-12 * e.mass_matrix.norm());
    // da/dtau = 1/A, rotors and all
    const Rows product = need(forward_derivatives(system, state)).acceleration_by_efforts * e.mass_matrix;
    EXPECT_LT((product - Rows::Identity(system.nv, system.nv)).norm(), 1e-9);
  }
}

TEST(Armature, DriveEffortIncludesTheRotor) {
  // q = t^2: 2 rad/s^2 on a point of 2 kg at 1 m and a rotor of 3 kg m^2 take 10 N m
  Scene scene;
  scene.gravity.setZero();
  scene.solids = {solid("p", "world", {driven(hinge("q", Vector3d::UnitZ()), Polynomial{{0, 0, 1}})},
                        {inertial(2, {1, 0, 0}, {0, 0, 0})})};
  scene.solids[0].switches[0].armature = 3;
  for (const Equations equations : {Equations::lagrange, Equations::recursive}) {
    scene.simulation.equations = equations;
    const System system = compiled(scene);
    EXPECT_NEAR(need(evaluate(system, system.initial)).drive_efforts[0], 10, 1e-13);
  }
}

TEST(Armature, KeepsEnergyBalanceAndMomentum) {
  // two free solids on a geared hinge: inner rotors change no momentum of the whole
  Scene scene;
  const Inertial body = inertial(1, {0.1, 0.2, 0}, {0.1, 0.2, 0.25});
  scene.solids = {solid("a", "world", free_switches("a"), {body}),
                  solid("b", "a", {fixed({1, 0, 0}), hinge("h", Vector3d::UnitY(), 0.3, 4)}, {body})};
  scene.solids[0].switches[3].v = {1, 2, -1};
  scene.solids[1].switches[1].armature = 0.5;
  scene.simulation.end_time = 2;
  scene.simulation.tolerance = 1e-9;
  const auto conserved = [](const Trajectory& t) { return t.certificate.conserved.size(); };
  const Trajectory inner = need(simulate(compiled(scene)));
  EXPECT_TRUE(inner.certificate.trusted) << inner.certificate.reason;
  EXPECT_EQ(conserved(inner), 2u);  // linear and angular, held against the bodies' own
  // a rotor between the solid and the world takes momentum from it, and none is promised
  scene.solids[0].switches[0].armature = 2;
  const Trajectory outer = need(simulate(compiled(scene)));
  EXPECT_TRUE(outer.certificate.trusted) << outer.certificate.reason;
  EXPECT_EQ(conserved(outer), 0u);
}

TEST(Armature, MasslessSolidWithArmatureMoves) {
  Scene scene;
  scene.solids = {solid("r", "world", {hinge("q", Vector3d::UnitY())}, {})};
  EXPECT_FALSE(compile(scene));  // moves no mass
  scene.solids[0].switches[0].armature = 4;
  for (const Equations equations : {Equations::lagrange, Equations::recursive}) {
    scene.simulation.equations = equations;
    const System system = compiled(scene);
    EXPECT_NEAR(need(evaluate(system, system.initial, Eigen::VectorXd::Constant(1, 6))).acceleration[0], 1.5,
                1e-15);
  }
}

TEST(Armature, RoundTripsThroughSceneFiles) {
  const std::string text = need(write_scene(rotors(3)));
  EXPECT_NE(text.find("armature"), std::string::npos);
  const Scene back = need(parse_scene(text, "s.toml"));
  EXPECT_EQ(need(write_scene(back)), text);
  EXPECT_EQ(compiled(back).parameters.armatures, compiled(rotors(3)).parameters.armatures);
  const auto bad = parse_scene(
      "[[solid]]\nname='a'\njoint={rotation='y',armature=-1}\nmass=1\ntensor=[1,1,1]\n", "s.toml");
  ASSERT_FALSE(bad);
  EXPECT_NE(bad.error().message().find("armature is -1"), std::string::npos) << bad.error().message();
  Scene wrong = rotors(3);
  for (Switch& s : wrong.solids[0].switches) s.armature = std::nan("");
  EXPECT_FALSE(compile(wrong));
}

}  // namespace
}  // namespace borelli::test
