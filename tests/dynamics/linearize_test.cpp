// Equilibria and their modes against closed forms.
#include "dynamics/constraints/linearize.hpp"

#include "dynamics/constraints/equilibrium.hpp"
#include "dynamics/equations/evaluate.hpp"
#include "scenes.hpp"

namespace borelli::test {
namespace {

/// Point masses m on massless rods l.
Scene double_pendulum() {
  Scene scene;
  scene.solids = {
      solid("upper", "world", {hinge("a", Vector3d::UnitY())}, {inertial(1, {0, 0, -1}, {0, 0, 0})}),
      solid("lower", "upper", {fixed({0, 0, -1}), hinge("b", Vector3d::UnitY())},
            {inertial(1, {0, 0, -1}, {0, 0, 0})})};
  return scene;
}

// w^2 = g/l (2 -+ sqrt 2), with absolute angles in the ratio 1 : +-sqrt 2 (Landau, Lifshitz, Mechanics,
// section 23, problem 2), so relative ones 1 : +-sqrt 2 - 1.
TEST(Modes, OfTheDoublePendulum) {
  const System system = compiled(double_pendulum());
  const Linearization linear = need(linearize(system, system.initial));
  ASSERT_EQ(linear.modes.size(), 2u);
  EXPECT_EQ(linear.stability, Stability::neutral);
  for (int i = 0; i < 2; ++i) {
    const double sign = i == 0 ? -1 : 1, w = std::sqrt(9.81 * (2 + sign * std::sqrt(2)));
    EXPECT_NEAR(linear.modes[i].eigenvalue.imag(), w, 1e-12 * w);
    EXPECT_NEAR(linear.modes[i].eigenvalue.real(), 0, 1e-12 * w);
    EXPECT_NEAR(linear.modes[i].frequency, w / (2 * M_PI), 1e-12 * w);
    const std::complex<double> ratio = linear.modes[i].shape[1] / linear.modes[i].shape[0];
    EXPECT_LT(std::abs(ratio - (-sign * std::sqrt(2) - 1)), 1e-12);
  }
}

TEST(Modes, UpsideDownIsUnstable) {
  const System system = compiled(double_pendulum());
  State state = system.initial;
  state.q[0] = M_PI;
  const Linearization linear = need(linearize(system, state));
  EXPECT_EQ(linear.stability, Stability::unstable);
  // upside down every w^2 is negative: growth rates equal the frequencies
  EXPECT_NEAR(linear.modes.back().eigenvalue.real(), std::sqrt(9.81 * (2 + std::sqrt(2))), 1e-11);
}

// n equal masses between n + 1 equal springs and dampers: w_k = 2 sqrt(k/m) sin(k pi / (2 (n + 1))), damping
// ratio c w_k / (2 k).
TEST(Modes, OfAChainOfSpringsAndDampers) {
  const int n = 6;
  const double m = 0.7, k = 300, c = 0.4;
  Scene scene;
  scene.gravity.setZero();
  for (int i = 0; i < n; ++i)
    scene.solids.push_back(solid(fmt::format("m{}", i), "world",
                                 {slide(fmt::format("x{}", i), Vector3d::UnitX(), i)},
                                 {inertial(m, {0, 0, 0}, {1, 1, 1})}));
  for (int i = 0; i <= n; ++i) {
    const SolidPoint left =
        i == 0 ? SolidPoint{"world", {-1, 0, 0}} : SolidPoint{fmt::format("m{}", i - 1), {0, 0, 0}};
    const SolidPoint right =
        i == n ? SolidPoint{"world", {double(n), 0, 0}} : SolidPoint{fmt::format("m{}", i), {0, 0, 0}};
    scene.efforts.push_back({fmt::format("s{}", i), PointSpring{left, right, k, c, 1}});
  }
  const System system = compiled(scene);
  const Linearization linear = need(linearize(system, system.initial));
  ASSERT_EQ(linear.modes.size(), std::size_t(n));
  EXPECT_EQ(linear.stability, Stability::stable);
  for (int i = 0; i < n; ++i) {
    const double w = 2 * std::sqrt(k / m) * std::sin((i + 1) * M_PI / (2 * (n + 1)));
    EXPECT_NEAR(2 * M_PI * linear.modes[i].frequency, w, 1e-11 * w);
    EXPECT_NEAR(linear.modes[i].damping_ratio, c * w / (2 * k), 1e-11);
    for (int j = 0; j < n; ++j) {  // sines along the chain
      const double shape = std::sin((i + 1) * (j + 1) * M_PI / (n + 1)),
                   first = std::sin((i + 1) * M_PI / (n + 1));
      EXPECT_LT(std::abs(linear.modes[i].shape[j] / linear.modes[i].shape[0] - shape / first), 1e-9);
    }
  }
}

// A top that sleeps is stable while C^2 s^2 > 4 A m g l (Goldstein, Classical Mechanics, 3rd edition,
// equation 5.80); a slower top leaves the vertical as exp(sqrt(4 A m g l - C^2 s^2) t / (2 A)).
TEST(Modes, OfASleepingTop) {
  const double m = 2, l = 0.3, A = 0.25, C = 0.04, g = 9.81;  // A about the tip
  Scene scene;
  scene.solids = {
      solid("top", "world", {ball("tip")}, {inertial(m, {0, 0, l}, {A - m * l * l, A - m * l * l, C})})};
  const System system = compiled(scene);
  const double limit = std::sqrt(4 * A * m * g * l) / C;
  for (const double part : {0.5, 0.999, 1.001, 1.5}) {
    State state = system.initial;
    const double s = part * limit;
    state.v = Vector3d(0, 0, s);
    const Linearization linear = need(linearize(system, state));
    EXPECT_EQ(linear.stability, part < 1 ? Stability::unstable : Stability::neutral) << part;
    const double square = C * C * s * s - 4 * A * m * g * l, root = std::sqrt(std::abs(square)) / (2 * A);
    double growth = 0;
    std::vector<double> frequencies;  // those of the two precessions, seen from the turning top
    for (const Mode& mode : linear.modes) {
      growth = std::max(growth, mode.eigenvalue.real());
      if (mode.eigenvalue.imag() > 1) frequencies.push_back(mode.eigenvalue.imag());
    }
    if (part < 1) {
      EXPECT_NEAR(growth, root, 1e-9 * limit) << part;
    } else {
      EXPECT_LT(growth, 1e-5) << part;
      ASSERT_EQ(frequencies.size(), 2u);
      const double middle = C * s / (2 * A) - s;
      std::vector<double> expected{std::abs(middle + root), std::abs(middle - root)};
      std::sort(expected.begin(), expected.end());
      for (int i = 0; i < 2; ++i) EXPECT_NEAR(frequencies[i], expected[i], 1e-9 * limit) << part;
    }
  }
}

// A bar hung on two parallel rods of length l swings like one pendulum of that length: constraints leave one
// direction of three.
TEST(Modes, OnTheTangentSpaceOfConstraints) {
  const double l = 1.3;
  Scene scene;
  scene.solids = {solid(
      "bar", "world",
      {slide("x", Vector3d::UnitX()), slide("z", Vector3d::UnitZ(), -l), hinge("turn", Vector3d::UnitY())},
      {inertial(3, {0, 0, 0}, {0.2, 0.2, 0.01})})};
  for (const double x : {-0.5, 0.5})
    scene.constraints.push_back(
        {x < 0 ? "left" : "right", Distance{{"bar", {x, 0, 0}}, {"world", {x, 0, 0}}, constant(l)}});
  const System system = compiled(scene);
  const Linearization linear = need(linearize(system, system.initial));
  ASSERT_EQ(linear.modes.size(), 1u);
  EXPECT_NEAR(linear.modes[0].eigenvalue.imag(), std::sqrt(9.81 / l), 1e-12);
  EXPECT_LT(std::abs(linear.modes[0].shape[2]), 1e-12);  // it does not turn
}

TEST(Modes, OfUnsteadyStatesAreRefused) {
  const System system = compiled(double_pendulum());
  State state = system.initial;
  state.q[0] = 0.1;
  EXPECT_NE(linearize(system, state).error().what.find("not steady"), std::string::npos);
  state = system.initial;
  state.v[0] = 1;  // no acceleration, but a velocity
  const auto passing = linearize(system, state);
  ASSERT_FALSE(passing);
  EXPECT_NE(passing.error().what.find("only for an instant"), std::string::npos);
}

// ---- equilibria ----

TEST(Equilibrium, OfAChainHangsDown) {
  Scene scene = chain(5, true, 0.4);
  const System system = compiled(scene);
  const Equilibrium found = need(find_equilibrium(system, system.initial));
  for (int i = 0; i < 5; ++i) EXPECT_NEAR(std::remainder(found.state.q[i], 2 * M_PI), 0, 1e-9);
  EXPECT_EQ(found.state.v.norm(), 0);
  EXPECT_LT(found.imbalance, 1e-10);
}

// At a level pendulum the imbalance is largest: no step along its slope reduces it.
TEST(Equilibrium, OfALevelPendulum) {
  const System system = compiled(chain(1, false, M_PI / 2));
  EXPECT_NEAR(std::remainder(need(find_equilibrium(system, system.initial)).state.q[0], M_PI), 0, 1e-9);
}

// A mass on two springs under its weight, and one on a spring that is far from linear.
TEST(Equilibrium, OfSpringsMatchesTheirClosedForms) {
  Scene scene;
  scene.solids = {
      solid("m", "world", {slide("z", Vector3d::UnitZ(), 0.3)}, {inertial(2, {0, 0, 0}, {1, 1, 1})})};
  scene.efforts = {{"spring", CoordinateSpring{{"z"}, 50, 1, 0.1}}};
  EXPECT_NEAR(need(find_equilibrium(compiled(scene), compiled(scene).initial)).state.q[0],
              0.1 - 2 * 9.81 / 50, 1e-12);
  // a cord of rest length 1 across 2 m, pressed down at its middle: 2 k (s - 1) z / s = m g, s^2 = 1 + z^2
  const double k = 500;
  scene.efforts = {{"left", PointSpring{{"m", {0, 0, 0}}, {"world", {-1, 0, 0}}, k, 0, 1}},
                   {"right", PointSpring{{"m", {0, 0, 0}}, {"world", {1, 0, 0}}, k, 0, 1}}};
  const Equilibrium found = need(find_equilibrium(compiled(scene), compiled(scene).initial));
  const double z = -found.state.q[0], s = std::sqrt(1 + z * z);
  EXPECT_GT(z, 0);
  EXPECT_NEAR(2 * k * (s - 1) * z / s, 2 * 9.81, 1e-9);
}

// The bar on two rods again, from far off; each rod carries half of the weight, and where a third rod makes
// one redundant, they share by least squares.
TEST(Equilibrium, WithConstraintsGivesTheirLoads) {
  const double l = 1.3;
  Scene scene;
  scene.solids = {solid("bar", "world",
                        {slide("x", Vector3d::UnitX(), 0.6), slide("z", Vector3d::UnitZ(), -1.1),
                         hinge("turn", Vector3d::UnitY())},
                        {inertial(3, {0, 0, 0}, {0.2, 0.2, 0.01})})};
  for (const double x : {-0.5, 0.5})
    scene.constraints.push_back(
        {x < 0 ? "left" : "right", Distance{{"bar", {x, 0, 0}}, {"world", {x, 0, 0}}, constant(l)}});
  const Equilibrium found = need(find_equilibrium(compiled(scene), compiled(scene).initial));
  EXPECT_NEAR(found.state.q[0], 0, 1e-9);
  EXPECT_NEAR(found.state.q[1], -l, 1e-11);
  for (int r = 0; r < 2; ++r) EXPECT_NEAR(found.multipliers[r], -3 * 9.81 / 2, 1e-8);
  scene.constraints.push_back({"middle", Distance{{"bar", {0, 0, 0}}, {"world", {0, 0, 0}}, constant(l)}});
  const Equilibrium three = need(find_equilibrium(compiled(scene), compiled(scene).initial));
  EXPECT_NEAR(three.multipliers.sum(), -3 * 9.81, 1e-8);
  EXPECT_NEAR(three.multipliers[0], three.multipliers[1], 1e-7);
  EXPECT_NEAR(three.state.q[1], -l, 1e-9);
}

TEST(Modes, NeedAStateThatMeetsTheConstraints) {
  // a rod of 0.2 m between points 1 m apart
  Scene scene;
  scene.solids = {solid("bob", "world", {slide("x", Vector3d::UnitX()), slide("z", Vector3d::UnitZ(), -1)},
                        {inertial(1, {0, 0, 0}, {0, 0, 0})})};
  scene.constraints = {{"rod", Distance{{"bob", {0, 0, 0}}, {"world", {0, 0, 0}}, constant(0.2)}}};
  const System system = compiled(scene);
  const auto apart = linearize(system, system.initial);
  ASSERT_FALSE(apart);
  EXPECT_NE(apart.error().what.find("constraint 'rod' is violated by "), std::string::npos)
      << apart.error().what;
  EXPECT_NE(violation(system, need(evaluate(system, system.initial))), "");
  const Equilibrium rest = need(find_equilibrium(system, system.initial));
  EXPECT_EQ(violation(system, need(evaluate(system, rest.state))), "");
  EXPECT_NEAR(need(linearize(system, rest.state)).modes.at(0).frequency, std::sqrt(9.81 / 0.2) / (2 * M_PI),
              1e-8);
}

TEST(Modes, NeedEquationsThatDoNotChange) {
  // Upside down on a shaken pivot, the accelerations are zero at all times, but not their derivatives.
  Scene shaken = double_pendulum();
  shaken.solids[0].switches.insert(shaken.solids[0].switches.begin(),
                                   driven(slide("pivot", Vector3d::UnitZ()), Sine{0.01, 300, 0, 0}));
  Scene pushed = double_pendulum();
  pushed.efforts = {{"push", Force{{"upper", {0, 0, 0}}, {0, 0, 0}}},
                    {"wave", Force{{"lower", {0, 0, -1}}, {0, 0.5, 0.3}, Axes::world, Sine{1, 3, 0, 0}}}};
  for (const Scene& scene : {shaken, pushed}) {
    const System system = compiled(scene);
    const auto linear = linearize(system, system.initial);
    ASSERT_FALSE(linear);
    EXPECT_NE(linear.error().what.find("the equations of motion at t = "), std::string::npos)
        << linear.error().what;
  }
  // On a turntable at a steady rate nothing changes: a slide along its radius has w^2 = k/m - rate^2.
  Scene turned;
  turned.gravity.setZero();
  turned.solids = {
      solid("table", "world", {driven(hinge("turn", Vector3d::UnitZ()), linear(0, 2))},
            {inertial(1, {0, 0, 0}, {1, 1, 1})}),
      solid("bead", "table", {slide("r", Vector3d::UnitX())}, {inertial(1, {0, 0, 0}, {0, 0, 0})})};
  turned.efforts = {{"spring", CoordinateSpring{{"r"}, 13, 0, 0}}};
  const System system = compiled(turned);
  EXPECT_NEAR(need(linearize(system, system.initial)).modes.at(0).frequency, 3 / (2 * M_PI), 1e-12);
}

TEST(Equilibrium, SaysIfItHoldsAtItsTimeOnly) {
  Scene scene = double_pendulum();
  EXPECT_EQ(need(find_equilibrium(compiled(scene), compiled(scene).initial)).holds_at, "");
  scene.efforts = {{"wave", Force{{"lower", {0, 0, -1}}, {3, 0, 0}, Axes::world, Sine{1, 3, 0, 0}}}};
  const std::string why = need(find_equilibrium(compiled(scene), compiled(scene).initial)).holds_at;
  EXPECT_TRUE(why.starts_with("the scene changes with time (fastest: effort 'wave'): at t = ")) << why;
  scene.efforts = {{"across", Force{{"lower", {0, 0, -1}}, {0, 3, 0}, Axes::world, Sine{1, 3, 0, 0}}}};
  EXPECT_EQ(need(find_equilibrium(compiled(scene), compiled(scene).initial)).holds_at, "");  // moves nothing
}

// A ball joint hangs down wherever it starts, and any turn about the vertical is an equilibrium.
TEST(Equilibrium, OfABall) {
  Scene scene;
  scene.solids = {
      solid("arm", "world", {ball("joint", Random(3).turn())}, {inertial(2, {0.1, -0.3, 0.5}, {1, 2, 2.5})})};
  const System system = compiled(scene);
  const Equilibrium found = need(find_equilibrium(system, system.initial));
  const Vector3d centre = rotation_matrix(Quaternion(found.state.q.head<4>())) * Vector3d(0.1, -0.3, 0.5);
  EXPECT_LT(centre.head<2>().norm(), 1e-9);
}

TEST(Equilibrium, ExplainsAMissingEquilibrium) {
  Scene falling;
  falling.solids = {solid("stone", "world", {slide("x", Vector3d::UnitX()), slide("fall", Vector3d::UnitZ())},
                          {inertial(2, {0, 0, 0}, {1, 1, 1})})};
  const auto none = find_equilibrium(compiled(falling), compiled(falling).initial);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().where, "coordinate 'fall'");
  EXPECT_NE(none.error().what.find("19.6 (N or N m)"), std::string::npos) << none.error().what;
  Scene moving = chain(2, false);
  moving.solids[0].switches.back() = driven(moving.solids[0].switches.back(), linear(0, 1));
  EXPECT_EQ(find_equilibrium(compiled(moving), compiled(moving).initial).error().where,
            "driven coordinate 'h0'");
  falling.constraints = {{"floor", Limit{{"fall"}, -1.0, {}, 0}}};
  EXPECT_EQ(find_equilibrium(compiled(falling), compiled(falling).initial).error().where,
            "constraint 'floor'");
}

}  // namespace
}  // namespace borelli::test
