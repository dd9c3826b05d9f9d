// The ellipsoid switch: differences of its poses, a ball whose body stands off (equal radii), a rod that turns
// in a plane of symmetry (closed form), both algorithms, several states at once, files.
#include "dynamics/scene/switch_ellipsoid.hpp"

#include "dynamics/constraints/local_coordinates.hpp"
#include "dynamics/equations/batch.hpp"
#include "dynamics/equations/derivatives.hpp"
#include "dynamics/equations/evaluate.hpp"
#include "scenes.hpp"

namespace borelli::test::ellipsoid_test {
namespace {

Switch ellipsoid(const std::string& name, const Vector3d& radii) {
  Switch out = ball(name);
  out.kind = OnEllipsoid{radii};
  return out;
}

/// A blade on a trunk that turns and slides, with an arm on a ball.
Scene shoulder(const std::vector<Switch>& on_thorax) {
  Scene scene;
  const Inertial mass = inertial(3, {0.02, -0.2, 0.01}, {0.05, 0.01, 0.06});
  std::vector<Switch> blade{fixed({0, 0.3, 0.01}, rotation_about(Vector3d::UnitX(), 0.2))};
  blade.insert(blade.end(), on_thorax.begin(), on_thorax.end());
  scene.solids = {solid("trunk", "world",
                        {slide("lift", Vector3d(1, 2, 2) / 3), hinge("turn", Vector3d::UnitY())}, {mass}),
                  solid("blade", "trunk", blade, {mass}),
                  solid("arm", "blade", {fixed({0.1, 0, 0.05}), ball("shoulder")},
                        {inertial(2, {0.05, 0, -0.1}, {0.02, 0.03, 0.03})})};
  return scene;
}

TEST(OnEllipsoid, TwistAndItsRateAreTheDifferencesOfPoses) {
  const OnEllipsoid over{{0.3, 0.2, 0.45}};
  const Vector3d v(0.7, -1.1, 0.4);
  const double h = 1e-4;
  Random random(1);
  for (int trial = 0; trial < 5; ++trial) {
    const Quaternion start = random.turn();
    Pose X[3];
    Vector3d twist[3][2], rate[2];
    for (int i = 0; i < 3; ++i) {
      const Quaternion q = product(start, exponential(Vector3d((i - 1) * h * v)));
      Vector3d angular[3], linear[3], w_rate, v_rate;
      over.advance(q.data(), v.data(), X[i], angular, linear, w_rate, v_rate);
      twist[i][0] = twist[i][1] = Vector3d::Zero();
      for (int c = 0; c < 3; ++c) {
        twist[i][0] += v[c] * angular[c];
        twist[i][1] += v[c] * linear[c];
      }
      if (i == 1) rate[0] = w_rate, rate[1] = v_rate;
    }
    // central differences: errors of h^2 times third derivatives, below 10
    EXPECT_LT((twist[1][1] - (X[2].p - X[0].p) / (2 * h)).norm(), 1e-7);
    const Matrix3d W = (X[2].R - X[0].R) / (2 * h) * X[1].R.transpose();
    EXPECT_LT((twist[1][0] - Vector3d(W(2, 1), W(0, 2), W(1, 0))).norm(), 1e-7);
    for (int n = 0; n < 2; ++n) {  // as B sees it
      const Vector3d ahead = X[2].R.transpose() * twist[2][n], behind = X[0].R.transpose() * twist[0][n];
      EXPECT_LT((X[1].R * (ahead - behind) / (2 * h) - rate[n]).norm(), 1e-7);
    }
  }
}

// On a sphere the body turns about the centre, a radius away along its own z.
TEST(OnEllipsoid, WithEqualRadiiIsABallWhoseBodyStandsOff) {
  const Scene scenes[] = {shoulder({ellipsoid("blade", Vector3d::Constant(0.3))}),
                          shoulder({ball("blade"), fixed({0, 0, 0.3})})};
  for (const Equations equations : {Equations::recursive, Equations::lagrange}) {
    Eigen::VectorXd accelerations[2], efforts[2];
    for (int i = 0; i < 2; ++i) {
      System system = compiled(scenes[i]);
      system.settings.equations = equations;
      State state = Random(4).state(system);
      accelerations[i] = need(evaluate(system, state)).acceleration;
      efforts[i] =
          need(inverse_dynamics(system, state, Eigen::VectorXd::LinSpaced(system.nv, -1, 2))).efforts;
    }
    EXPECT_LT((accelerations[0] - accelerations[1]).norm(), 1e-12 * accelerations[1].norm());
    EXPECT_LT((efforts[0] - efforts[1]).norm(), 1e-12 * efforts[1].norm());
  }
}

// A body of mass m about B's origin, turned by theta about y: its centre is at (a sin, 0, c cos theta).
// Lagrange's equation: (m (a^2 cos^2 + c^2 sin^2) + I) theta'' + m (c^2 - a^2) sin cos theta'^2 = m g c sin.
TEST(OnEllipsoid, TurnsInAPlaneOfSymmetryAsTheClosedFormSays) {
  const double a = 0.5, c = 0.2, m = 3, I = 0.07, g = 9.81;
  Scene scene;
  scene.gravity = {0, 0, -g};
  scene.solids = {
      solid("a", "world", {ellipsoid("e", {a, 0.9, c})}, {inertial(m, Vector3d::Zero(), {0.05, I, 0.06})})};
  for (const Equations equations : {Equations::recursive, Equations::lagrange}) {
    System system = compiled(scene);
    system.settings.equations = equations;
    for (const double theta : {0.3, 1.2, 2.5, -2.0})
      for (const double rate : {0.0, 1.7, -3.0}) {
        State state = system.initial;
        const Quaternion q = exponential(Vector3d(0, theta, 0));
        std::copy(q.data(), q.data() + 4, state.q.data());
        state.v = Vector3d(0, rate, 0);
        const double s = std::sin(theta), k = std::cos(theta);
        const double expected = (m * g * c * s - m * (c * c - a * a) * s * k * rate * rate) /
                                (m * (a * a * k * k + c * c * s * s) + I);
        const Eigen::VectorXd got = need(evaluate(system, state)).acceleration;
        EXPECT_NEAR(got[1], expected, 1e-13 * (1 + std::abs(expected))) << theta << " " << rate;
        EXPECT_NEAR(got[0], 0, 1e-13);
        EXPECT_NEAR(got[2], 0, 1e-13);
      }
  }
}

TEST(OnEllipsoid, BothAlgorithmsAgreeAndKeepTheEnergy) {
  Scene scene = shoulder({ellipsoid("blade", {0.3, 0.2, 0.4})});
  scene.solids[1].switches[1].v = {0.5, -1, 0.8};
  Eigen::VectorXd accelerations[2];
  for (const Equations equations : {Equations::recursive, Equations::lagrange}) {
    System system = compiled(scene);
    system.settings.equations = equations;
    accelerations[int(equations == Equations::lagrange)] =
        need(evaluate(system, Random(6).state(system))).acceleration;
    SimulationSettings how = settings("dop853", 1, 1e-3, 1e-10);
    how.equations = equations;
    const Trajectory t = run(scene, how);
    EXPECT_TRUE(t.certificate.trusted) << t.certificate.reason;
  }
  EXPECT_LT((accelerations[0] - accelerations[1]).norm(), 1e-12 * accelerations[0].norm());
}

TEST(OnEllipsoid, LanesEqualSingleStates) {
  const System system = compiled(shoulder({ellipsoid("blade", {0.3, 0.2, 0.4})}));
  BatchState states(system);
  BatchWorkspace work(system);
  Random random(3);
  std::vector<State> singles;
  for (int lane = 0; lane < Lanes::count; ++lane) {
    singles.push_back(random.state(system));
    states.set(lane, singles.back());
  }
  ASSERT_TRUE(accelerate<Lanes>(system, system.parameters, states, work));
  for (int lane = 0; lane < Lanes::count; ++lane) {
    singles[lane].t = states.t;
    const Evaluation one = need(evaluate(system, singles[lane]));
    for (int i = 0; i < system.nv; ++i)
      EXPECT_NEAR(work.a[i][lane], one.acceleration[i], 1e-11 * (1 + one.acceleration.norm()));
  }
}

TEST(OnEllipsoid, IsReadWrittenAndRefused) {
  const Scene scene = shoulder({ellipsoid("blade", {0.3, 0.2, 0.4})});
  const Scene back = need(parse_scene(need(write_scene(scene)), "shoulder.toml"));
  EXPECT_EQ(std::get<OnEllipsoid>(back.solids[1].switches[1].kind).radii, Vector3d(0.3, 0.2, 0.4));
  const auto complaint = [](const std::string& joint) {
    const auto read = parse_scene(
        "[[solid]]\nname = \"a\"\nmass = 1\ntensor = [1, 1, 1]\njoint = {" + joint + "}\n", "a.toml");
    if (!read) return read.error().message();
    const auto system = compile(*read);
    return system ? std::string() : system.error().message();
  };
  EXPECT_EQ(complaint("ellipsoid = true, radii = [1, 2, 3]"), "");
  EXPECT_NE(complaint("ellipsoid = true").find("radii"), std::string::npos);
  EXPECT_NE(complaint("ellipsoid = false, radii = [1, 2, 3]").find("expected true"), std::string::npos);
  EXPECT_NE(complaint("ellipsoid = true, radii = [1, 0, 3]").find("positive"), std::string::npos);
}

}  // namespace
}  // namespace borelli::test::ellipsoid_test
