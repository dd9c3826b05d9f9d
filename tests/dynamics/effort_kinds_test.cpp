// Limit springs, controllers, drags and a user's own effort against closed forms. (passes_test checks their
// potentials and power, derivatives_test their derivatives.)
#include "dynamics/scene/effort.hpp"

#include <complex>

#include "dynamics/equations/evaluate.hpp"
#include "dynamics/equations/passes.hpp"
#include "dynamics/formats/scene_file.hpp"
#include "scenes.hpp"

namespace borelli::test::effort_kinds_test {
namespace {

// Adaptive steps of 1e-11 in runs of about a hundred steps.
constexpr double tolerance = 1e-8;

SimulationSettings fine(double end) { return settings("dopri5", end, 1e-3, 1e-11); }

/// A slider of 2 kg without weight.
Scene slider(double q, double v) {
  Scene scene;
  scene.gravity.setZero();
  scene.solids = {
      solid("cart", "world", {slide("x", Vector3d::UnitX(), q, v)}, {inertial(2, {0, 0, 0}, {1, 1, 1})})};
  return scene;
}

// m x'' = -k x (1 + c x') gives v dv / (1 + c v) = -k/m x dx. So v / c - log(1 + c v) / c^2 has the same
// value when entering and leaving (Hunt and Crossley, equation 6 with exponent 1).
TEST(LimitSpring, ReturnsTheSpeedOfTheClosedForm) {
  const double c = 0.3;
  const auto invariant = [&](double v) { return v / c - std::log1p(c * v) / (c * c); };
  for (const double speed : {0.5, 1.0, 5.0}) {
    Scene scene = slider(0.8, speed);
    scene.efforts = {{"stop", LimitSpring{{"x"}, 5000, c, {{-1, 1}}}}};
    const Trajectory motion = run(scene, fine(1 / speed));
    ASSERT_TRUE(motion.certificate.trusted) << motion.certificate.reason;
    double low = -1 / c + 1e-12, high = 0;  // bisection for the speed out
    for (int i = 0; i < 200; ++i) {
      const double v = (low + high) / 2;
      (invariant(v) > invariant(speed) ? low : high) = v;
    }
    ASSERT_LT(std::abs(last(motion.q)[0]), 1);  // it is on its way back
    EXPECT_NEAR(last(motion.v)[0], low, tolerance * speed) << speed;
    EXPECT_NEAR(motion.certificate.work_efforts, low * low - speed * speed, 1e-7 * speed * speed);
  }
}

TEST(LimitSpring, NeverPullsAndStartsAtZero) {
  Scene scene = slider(0, 0);
  scene.efforts = {{"stop", LimitSpring{{"x"}, 100, 0.5, {}}}};
  scene.solids[0].switches[0].ranges = {{-0.2, 0.1}};
  const System system = compiled(scene);
  const auto effort = [&](double q, double v) {
    State state = system.initial;
    state.q[0] = q, state.v[0] = v;
    return need(evaluate(system, state)).generalized_efforts[0];
  };
  EXPECT_EQ(effort(0.05, 1), 0);
  EXPECT_DOUBLE_EQ(effort(0.3, 0), -20);
  EXPECT_DOUBLE_EQ(effort(-0.3, 0), 10);
  EXPECT_DOUBLE_EQ(effort(0.3, 1), -30);  // entering: more
  EXPECT_DOUBLE_EQ(effort(-0.3, 1), 5);   // leaving: less
  EXPECT_EQ(effort(0.3, -2.5), 0);        // pulled back fast: none
  EXPECT_EQ(effort(-0.3, 2.5), 0);
  EXPECT_LT(std::abs(effort(0.1 + 1e-9, 1)), 1e-6);
}

TEST(LimitSpring, KeepsABallInItsRanges) {
  Scene scene;
  Switch joint = ball("joint");
  joint.v = {3, 4, -5};
  joint.ranges = {{-0.5, 0.4}, {-0.3, 0.3}, {-1, 0.2}};
  scene.solids = {solid("arm", "world", {joint}, {inertial(2, {0, 0, -0.4}, {0.03, 0.03, 0.01})})};
  const double stiffness = 2000;
  scene.efforts = {{"stops", LimitSpring{{"joint"}, stiffness, 0.2, {}}}};
  SimulationSettings how = fine(4);
  how.output_interval = 0;
  const Trajectory motion = run(scene, how);
  EXPECT_TRUE(motion.certificate.trusted) << motion.certificate.reason;
  // depth at which the spring would store all energy: the weight's 2 m g l and the start's kinetic energy
  const double energy = motion.kinetic[0] + 2 * 2 * 9.81 * 0.4, depth = std::sqrt(2 * energy / stiffness);
  double farthest = 0;
  for (Eigen::Index row = 0; row < motion.q.rows(); ++row)
    for (int i = 0; i < 3; ++i) {
      const double x = ranged_value(motion.q.row(row).data(), 4, i);
      farthest = std::max({farthest, x - joint.ranges[i].upper, joint.ranges[i].lower - x});
    }
  EXPECT_LT(farthest, depth);
  EXPECT_GT(farthest, 0.01);  // it reached the stops
  // the stops dissipated the missing energy
  const double lost =
      motion.kinetic[0] + motion.potential[0] - motion.kinetic.back() - motion.potential.back();
  EXPECT_GT(lost, 0.1);
  EXPECT_NEAR(motion.certificate.work_efforts, -lost, 1e-7 * energy);
}

// m e'' + kd e' + kp e = -m target'', started on its steady solution.
TEST(PdController, FollowsASineAsInClosedForm) {
  const double m = 2, kp = 50, kd = 3, amplitude = 0.4, w = 6;
  const std::complex<double> off = m * amplitude * w * w / std::complex<double>(kp - m * w * w, kd * w);
  const auto answer = [&](double t) {  // q and its rate: the imaginary parts
    const std::complex<double> turn = std::polar(1.0, w * t), q = (amplitude + off) * turn;
    return std::pair(q.imag(), (std::complex<double>(0, w) * q).imag());
  };
  Scene scene = slider(answer(0).first, answer(0).second);
  scene.efforts = {{"control", PdController{{"x"}, kp, kd, {Sine{amplitude, w, 0, 0}}}}};
  const Trajectory motion = run(scene, fine(3));
  EXPECT_TRUE(motion.certificate.trusted) << motion.certificate.reason;
  EXPECT_NEAR(last(motion.q)[0], answer(3).first, tolerance);
  EXPECT_NEAR(last(motion.v)[0], answer(3).second, tolerance);
}

TEST(PdController, BringsABallToItsTarget) {
  Scene scene;
  scene.gravity.setZero();
  scene.solids = {solid("arm", "world", {ball("joint", identity_quaternion(), {1, -2, 3})},
                        {inertial(2, {0, 0, 0}, {0.03, 0.05, 0.04})})};
  const Vector3d target(0.3, -1.2, 0.7);
  scene.efforts = {
      {"control",
       PdController{{"joint"}, 4, 0.8, {constant(target[0]), constant(target[1]), constant(target[2])}}}};
  const Trajectory motion = run(scene, fine(10));
  EXPECT_TRUE(motion.certificate.trusted) << motion.certificate.reason;
  const Quaternion end = last(motion.q).head<4>();
  EXPECT_LT((logarithm(end) - target).norm(),
            1e-6);  // exp(-10 s kp / kd) is 2e-22, so only the steps' error remains
}

TEST(Drag, SlowsTranslationAsInClosedForm) {
  const double m = 2, k = 0.7, v0 = 3, t = 2;
  Scene scene = slider(0, v0);
  scene.efforts = {{"oil", Drag{{"cart", {0, 0, 0}}, k, 0}}};
  EXPECT_NEAR(last(run(scene, fine(t)).v)[0], v0 * std::exp(-k * t / m), tolerance);
  scene.efforts = {{"air", Drag{{"cart", {0, 0, 0}}, 0, k}}};
  EXPECT_NEAR(last(run(scene, fine(t)).v)[0], v0 / (1 + k * v0 * t / m), tolerance);
  // falling in air: v = v_end tanh(g t / v_end)
  scene = slider(0, 0);
  scene.gravity = {9.81, 0, 0};
  scene.efforts = {{"air", Drag{{"cart", {0, 0, 0}}, 0, k}}};
  const double v_end = std::sqrt(m * 9.81 / k);
  const Trajectory fall = run(scene, fine(t));
  EXPECT_NEAR(last(fall.v)[0], v_end * std::tanh(9.81 * t / v_end), tolerance);
  EXPECT_TRUE(fall.certificate.trusted) << fall.certificate.reason;
  EXPECT_TRUE(fall.certificate.conserved.empty());
}

TEST(Drag, SlowsRotation) {
  Scene scene;
  scene.solids = {solid("wheel", "world", {hinge("turn", Vector3d::UnitZ(), 0, 10)},
                        {inertial(1, {0, 0, 0}, {0.1, 0.1, 0.2})})};
  scene.efforts = {{"oil", AngularDrag{{"wheel"}, 0.3, 0}}};
  EXPECT_NEAR(last(run(scene, fine(1)).v)[0], 10 * std::exp(-0.3 / 0.2), tolerance);
  scene.efforts = {{"air", AngularDrag{{"wheel"}, 0, 0.3}}};
  const Trajectory motion = run(scene, fine(1));
  EXPECT_NEAR(last(motion.v)[0], 10 / (1 + 0.3 * 10 / 0.2), tolerance);
  EXPECT_TRUE(motion.certificate.trusted);
}

// ---- user-defined efforts ----

/// Attraction of site 0 to site 1 by strength / distance^2: a conservative effort in C++.
struct Attraction {
  double strength;
  template <class T>
  void apply(EffortPass<T>& pass) const {
    using std::sqrt;
    const auto a = pass.point(0, {0, 0, 0}), b = pass.point(1, {0, 0, 0});
    const Eigen::Vector3<T> r = b.p - a.p;
    const T d = sqrt(r.squaredNorm());
    const Eigen::Vector3<T> f = strength / (d * d * d) * r;
    pass.force(0, a.p, f);
    pass.force(1, b.p, -f);
    pass.potential(-strength / d);
  }
};

Scene two_planets() {
  Scene scene;
  scene.gravity.setZero();
  const auto planet = [&](const char* name, double mass, double x, double v) {
    return solid(name, "world",
                 {slide(fmt::format("{}.x", name), Vector3d::UnitX(), x),
                  slide(fmt::format("{}.y", name), Vector3d::UnitY(), 0, v)},
                 {inertial(mass, {0, 0, 0}, {1, 1, 1})});
  };
  scene.solids = {planet("a", 3, 0, 0), planet("b", 1, 1, 1.2)};
  scene.efforts = {{"pull", OwnEffort({{"a"}, {"b"}}, {}, Attraction{1.5})}};
  return scene;
}

// Kepler: a = strength / (2 |E|) of the relative motion, period 2 pi sqrt(mu a^3 / strength).
TEST(OwnEffort, GivesKeplerOrbits) {
  const double mu = 3.0 / 4, energy = mu * 1.2 * 1.2 / 2 - 1.5, a = 1.5 / (-2 * energy);
  const double period = 2 * M_PI * std::sqrt(mu * a * a * a / 1.5);
  const Trajectory motion = run(two_planets(), fine(period));
  EXPECT_TRUE(motion.certificate.trusted) << motion.certificate.reason;
  const Eigen::VectorXd q = last(motion.q);
  EXPECT_NEAR(q[2] - q[0], 1, 1e-7);
  EXPECT_NEAR(q[3] - q[1], 0, 1e-7);
  EXPECT_TRUE(motion.certificate.conserved.empty());  // the engine does not know its effect
}

TEST(OwnEffort, CannotBeWrittenAndNeedsALaw) {
  Scene scene = two_planets();
  const auto text = write_scene(scene);
  ASSERT_FALSE(text);
  EXPECT_EQ(text.error().where, "effort 'pull'");
  scene.efforts = {{"none", OwnEffort{}}};
  EXPECT_EQ(compile(scene).error().message(), "effort 'none': has no law; set one in C++");
}

struct Trouble {
  template <class T>
  void apply(EffortPass<T>& pass) const {
    if (pass.time() > 0.5) throw std::runtime_error("the rope is torn");
  }
};

TEST(OwnEffort, ExceptionEndsTheRun) {
  Scene scene = slider(0, 1);
  scene.efforts = {{"rope", OwnEffort({}, {{"x"}}, Trouble{})}};
  const auto motion = simulate(compiled(scene), compiled(scene).initial, fine(1));
  ASSERT_FALSE(motion);
  EXPECT_NE(motion.error().message().find("the rope is torn"), std::string::npos);
}

// ---- in files ----

const std::string arm = R"([[solid]]
name = "arm"
joint = [{ball = true, name = "shoulder"}, {fixed = [0, 0, -1]}, {rotation = "y", name = "elbow", range_deg = [0, 150]},
         {translation = "z", name = "reach"}]
mass = 1
tensor = [1, 1, 1]
centre = [0, 0, 1]
[[effort]]
name = "it"
)";

TEST(EffortKinds, AreReadFromSceneFiles) {
  const auto effort = [](const std::string& text) {
    return need(compile(need(parse_scene(arm + text, "arm.toml")))).parameters.efforts[0].kind;
  };
  auto stop =
      std::get<LimitSpring>(effort("kind = 'limit_spring'\non = 'elbow'\nstiffness = 10\ndissipation = 2\n"));
  ASSERT_EQ(stop.range.size(), 1u);  // the coordinate's own
  EXPECT_DOUBLE_EQ(stop.range[0].upper, 150 * M_PI / 180);
  EXPECT_EQ(stop.dissipation, 2);
  stop =
      std::get<LimitSpring>(effort("kind = 'limit_spring'\non = 'shoulder'\nstiffness = 10\n"
                                   "range_deg = [[-90, 90], [-45, 45], [0, 10]]\n"));
  ASSERT_EQ(stop.range.size(), 3u);
  EXPECT_DOUBLE_EQ(stop.range[1].lower, -M_PI / 4);
  const auto control = std::get<PdController>(
      effort("kind = 'pd_controller'\non = 'reach'\nkp = 10\nkd = 1\ntarget = [1, 2]\n"));
  ASSERT_EQ(control.target.size(), 1u);
  EXPECT_EQ(at(control.target[0], 3).value, 7);
  const auto three =
      std::get<PdController>(effort("kind = 'pd_controller'\non = 'shoulder'\nkp = 10\ntarget = [[0.5], [0, "
                                    "1], {kind = 'sine', amplitude = 2}]\n"));
  ASSERT_EQ(three.target.size(), 3u);
  EXPECT_EQ(at(three.target[1], 3).value, 3);
  EXPECT_EQ(std::get<Drag>(effort("kind = 'drag'\nat = 'arm'\nquadratic = 3\n")).quadratic, 3);
  EXPECT_EQ(std::get<AngularDrag>(effort("kind = 'angular_drag'\non = 'arm'\nlinear = 3\n")).linear, 3);
}

TEST(EffortKinds, AreRefusedWithTheirLine) {
  const auto complaint = [](const std::string& text) {
    const auto scene = parse_scene(arm + text, "arm.toml");
    if (!scene) return scene.error().message();
    const auto system = compile(*scene);
    return system ? "" : system.error().message();
  };
  const std::string here = "arm.toml:8: effort 'it': ";
  EXPECT_EQ(complaint("kind = 'limit_spring'\non = 'elbow'\n"), here + "its stiffness must be positive");
  EXPECT_EQ(complaint("kind = 'limit_spring'\non = 'reach'\nstiffness = 1\n"),
            here + "has no range, and neither has its coordinate; give one of them a range");
  EXPECT_EQ(complaint("kind = 'limit_spring'\non = 'shoulder'\nstiffness = 1\nrange = [0, 1]\n"),
            here + "has one range, but a ball needs three, one per component of its rotation vector");
  EXPECT_EQ(complaint("kind = 'limit_spring'\non = 'elbow'\nstiffness = 1\nrange = [1, 0]\n"),
            here + "its range must give the smaller bound first");
  EXPECT_EQ(complaint("kind = 'limit_spring'\non = 'elbow'\nstiffness = 1\ndissipation = -1\n"),
            here + "its dissipation must not be negative");
  EXPECT_EQ(complaint("kind = 'limit_spring'\non = 'reach'\nstiffness = 1\nrange_deg = [0, 1]\n"),
            "arm.toml:11: range_deg needs a rotation, but 'reach' is a translation");
  EXPECT_EQ(complaint("kind = 'pd_controller'\non = 'shoulder'\nkp = 1\ntarget = [0, 1]\n"),
            here + "acts on a ball; give three targets, one per component of its rotation vector");
  EXPECT_EQ(complaint("kind = 'pd_controller'\non = 'elbow'\nkp = -1\ntarget = 0\n"),
            here + "its gains kp and kd must not be negative");
  EXPECT_EQ(complaint("kind = 'drag'\nat = 'arm'\nlinear = -1\n"),
            here + "its coefficients linear and quadratic must not be negative");
  EXPECT_NE(complaint("kind = 'coordinate_spring'\non = 'shoulder'\n").find("which has three velocities"),
            std::string::npos);
  EXPECT_NE(complaint("kind = 'own'\n").find("there is no kind named \"own\""), std::string::npos);
}

}  // namespace
}  // namespace borelli::test::effort_kinds_test
