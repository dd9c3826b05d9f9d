// A, B and Q: B against the paper's equation 11; all against Lagrange's equations of a double pendulum by
// hand; and the terms of driven coordinates.
#include "dynamics/equations/lagrange.hpp"

#include "dynamics/equations/equations.hpp"
#include "dynamics/equations/evaluate.hpp"
#include "scenes.hpp"
#include "second_derivative.hpp"

namespace borelli::test {
namespace {

/// dA_ig/dq_j over the extended coordinates, from first and second derivatives of the positions (the
/// derivation of equation 13 that the paper's scan adds up).
double mass_matrix_derivative(const System& system, const Kinematics& k, int i, int g, int j) {
  double sum = 0;
  for (int b = 1; b < int(system.bodies.size()); ++b) {
    const Body& body = system.bodies[b];
    const auto place = [&](int u) {
      for (int n = 0; n < body.support_count; ++n)
        if (system.branches().support[body.first_support + n] == u) return n;
      return -1;
    };
    const int pi = place(i), pg = place(g), pj = place(j);
    if (pi < 0 || pg < 0 || pj < 0) continue;
    const auto first = [&](int n, int c) {
      return Vector3d(k.row(system, b, c)[n], k.row(system, b, c + 1)[n], k.row(system, b, c + 2)[n]);
    };
    const SecondDerivative di = second_derivative(system, k, b, pi, pj),
                           dg = second_derivative(system, k, b, pg, pj);
    const Inertial& inertial = system.parameters.inertials[b];
    const Matrix3d I = k.bodies[b].X.R * inertial.tensor * k.bodies[b].X.R.transpose();
    const Vector3d Wi = first(pi, 3), Wg = first(pg, 3), Wj = first(pj, 3);
    sum += inertial.mass * (di.v.dot(first(pg, 0)) + first(pi, 0).dot(dg.v));
    sum += di.w.dot(I * Wg) + Wi.dot(I * dg.w);
    sum += Wi.dot(Wj.cross(I * Wg) - I * Wj.cross(Wg));  // the tensor turns with the solid
  }
  return sum;
}

// Scalar coordinates only, where the velocities are rates of coordinates; time enters by driven ones, whose
// rates are the extended velocities and whose accelerations add A a.
TEST(Lagrange, BiasEqualsThePapersEquation11) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    const System system = compiled(random_tree(seed, {.balls = false, .drives = true}));
    State state = Random(seed + 50).state(system);
    state.t = 0.4;
    Workspace w(system, Equations::lagrange);
    ASSERT_FALSE(update_terms(system, system.parameters, state.t, state.q.data(), state.v.data(), w));
    const Kinematics& k = w.kinematics;
    const Rows A = w.terms.A.selfadjointView<Eigen::Lower>();
    for (int i = 0; i < system.size(); ++i) {
      double B = 0;
      for (int j = 0; j < system.size(); ++j) {
        B += A(i, j) * k.acceleration[j];
        for (int g = 0; g < system.size(); ++g)
          B +=
              k.u[j] * k.u[g] *
              (mass_matrix_derivative(system, k, i, g, j) - 0.5 * mass_matrix_derivative(system, k, j, g, i));
      }
      // rounding of hundreds of terms up to 1e2
      EXPECT_NEAR(w.terms.B[i], B, 1e-11) << "seed " << seed << ", coordinate " << i;
    }
  }
}

TEST(Lagrange, MassMatrixDerivativeMatchesDifferences) {  // the test above relies on it
  const System system = compiled(random_tree(3, {}));
  const State state = Random(53).state(system);
  const auto terms = [&](const Eigen::VectorXd& q) {
    Workspace w(system, Equations::lagrange);
    EXPECT_FALSE(update_terms(system, system.parameters, 0, q.data(), state.v.data(), w));
    return w;
  };
  const double h = 1e-5;
  const Workspace now = terms(state.q);
  for (int j = 0; j < system.nv; ++j) {
    const Workspace behind = terms(state.q - h * Eigen::VectorXd::Unit(system.nq, j));
    const Workspace ahead = terms(state.q + h * Eigen::VectorXd::Unit(system.nq, j));
    for (int i = 0; i < system.nv; ++i)
      for (int g = 0; g <= i; ++g)
        EXPECT_NEAR(mass_matrix_derivative(system, now.kinematics, i, g, j),
                    (ahead.terms.A(i, g) - behind.terms.A(i, g)) / (2 * h), 1e-7);
  }
}

/// Lagrange's equations of two bars on parallel hinges, written out (e.g. Craig, Introduction to Robotics,
/// section 6.7): the accelerations of the hinge angles.
Eigen::Vector2d double_pendulum(double m1, double m2, double l1, double c1, double c2, double I1, double I2,
                                const Eigen::Vector2d& q, const Eigen::Vector2d& v) {
  const double g = 9.81, h = m2 * l1 * c2 * std::sin(q[1]), c = m2 * l1 * c2 * std::cos(q[1]);
  Eigen::Matrix2d M;
  M(0, 0) = I1 + m1 * c1 * c1 + I2 + m2 * (l1 * l1 + c2 * c2) + 2 * c;
  M(0, 1) = M(1, 0) = I2 + m2 * c2 * c2 + c;
  M(1, 1) = I2 + m2 * c2 * c2;
  const double weight2 = m2 * g * c2 * std::sin(q[0] + q[1]);
  const Eigen::Vector2d rest(
      h * (2 * v[0] * v[1] + v[1] * v[1]) - (m1 * c1 + m2 * l1) * g * std::sin(q[0]) - weight2,
      -h * v[0] * v[0] - weight2);
  return M.inverse() * rest;
}

Scene two_bars(double m1, double m2) {
  Scene scene = chain(2, false);
  scene.solids[0].inertials = {inertial(m1, {0, 0, -0.5}, m1 * Vector3d(1.0 / 12, 1.0 / 12, 1e-3))};
  scene.solids[1].inertials = {inertial(m2, {0, 0, -0.3}, m2 * Vector3d(0.05, 0.05, 1e-3))};
  return scene;
}

TEST(Lagrange, DoublePendulumObeysItsExplicitEquations) {
  Random random(9);
  for (double m2 : {0.2, 1.0, 5.0, 1e6, 1e-6}) {  // mass ratios to a million either way
    const System system = compiled(two_bars(1, m2));
    for (int i = 0; i < 5; ++i) {
      const State state = random.state(system);
      const Evaluation ours = need(evaluate(system, state));
      const Eigen::Vector2d a = double_pendulum(1, m2, 1, 0.5, 0.3, 1.0 / 12, 0.05 * m2, state.q, state.v);
      // rounding, times the condition of M: about 10 times the ratio of the masses
      EXPECT_LT((ours.acceleration - a).norm(), 1e-14 * a.norm() * (100 + 10 * m2)) << m2;
    }
  }
}

TEST(Lagrange, KineticEnergyIsHalfTheMassMatrixTwiceTheVelocity) {
  const System system = compiled(random_tree(5, {.balls = true, .drives = true}));
  const State state = Random(6).state(system);
  Workspace w(system, Equations::lagrange);
  ASSERT_FALSE(update_terms(system, system.parameters, 0.2, state.q.data(), state.v.data(), w));
  const Rows A = w.terms.A.selfadjointView<Eigen::Lower>();
  const double kinetic = 0.5 * w.kinematics.u.dot(A * w.kinematics.u);
  EXPECT_NEAR(w.terms.kinetic, kinetic, 1e-13 * kinetic);
}

// A bead on a hoop that turns about its vertical diameter with f(t) (Goldstein, Classical Mechanics,
// section 2.4 and exercises): m r^2 a = m r^2 f'^2 sin cos - m g r sin; the drive exerts d/dt (m r^2 sin^2
// f').
TEST(Lagrange, BeadOnADrivenHoopGivesTheDriveTorque) {
  const double m = 0.3, r = 0.7, g = 9.81;
  Scene scene;
  scene.solids = {
      solid("hoop", "world", {driven(hinge("turn", Vector3d::UnitZ()), Polynomial{{0.1, 2, 1.5}})}, {}),
      solid("bead", "hoop", {hinge("angle", Vector3d::UnitY())}, {inertial(m, {0, 0, -r}, {0, 0, 0})})};
  const System system = compiled(scene);
  ASSERT_EQ(system.nv, 1);
  State state{.t = 0.5, .q = Eigen::VectorXd::Constant(1, 0.8), .v = Eigen::VectorXd::Constant(1, -1.1)};
  const double rate = 2 + 3 * 0.5, acceleration = 3, s = std::sin(0.8), c = std::cos(0.8);
  const Evaluation e = need(evaluate(system, state));
  EXPECT_NEAR(e.acceleration[0], rate * rate * s * c - g / r * s, 1e-13);
  EXPECT_NEAR(e.drive_efforts[0], m * r * r * (2 * s * c * -1.1 * rate + s * s * acceleration), 1e-13);
  EXPECT_NEAR(e.kinetic_energy, 0.5 * m * r * r * (1.1 * 1.1 + s * s * rate * rate), 1e-13);
}

TEST(Lagrange, DrivenBallExertsTheTorqueOfItsMotion) {
  // Euler's equations in the body: torque = I w' + w x I w, with w and w' of the prescribed turn by
  // differences
  Scene scene;
  scene.gravity.setZero();
  const Inertial body = inertial(1, {0, 0, 0}, {1, 2, 2.5});
  Switch turn = ball("turn");
  turn.q.clear();
  turn.v.clear();
  turn.motion = Driven{{Sine{0.5, 2, 0.1, 0}, Polynomial{{0.2, 0.3, 0.4}}, Sine{0.8, 1, 0, 0.2}}};
  scene.solids = {solid("body", "world", {turn}, {body})};
  const System system = compiled(scene);
  const auto at_time = [&](double t) {
    Workspace w(system, Equations::lagrange);
    EXPECT_FALSE(accelerate(system, system.parameters, t, nullptr, nullptr, {}, w));
    return w;
  };
  const double t = 0.7, h = 1e-5;
  const Workspace now = at_time(t), behind = at_time(t - h), ahead = at_time(t + h);
  const Matrix3d& R = now.kinematics.bodies[1].X.R;
  const Matrix3d W =
      R.transpose() * (ahead.kinematics.bodies[1].X.R - behind.kinematics.bodies[1].X.R) / (2 * h);
  const Vector3d w(W(2, 1), W(0, 2), W(1, 0));
  const Vector3d wdot = (ahead.kinematics.u - behind.kinematics.u) / (2 * h);
  const Vector3d torque = body.tensor * wdot + w.cross(body.tensor * w);
  EXPECT_LT((now.drive_efforts - torque).norm(), 1e-8);  // h^2 times third derivatives
}

}  // namespace
}  // namespace borelli::test
