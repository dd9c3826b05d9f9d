// Generalized-alpha beyond its order (method_orders_test.cpp): damping of stiff modes by its spectral radius,
// positions on the constraints within the step, and a heavy top's motion.
#include "dynamics/methods/generalized_alpha.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "scenes.hpp"

namespace borelli::test {
namespace {

/// A mass of 1 kg on a spring of w^2 N/m, 1 m out.
Scene oscillator(double w) {
  Scene scene;
  scene.gravity.setZero();
  scene.solids = {
      solid("mass", "world", {slide("x", Vector3d::UnitX(), 1)}, {inertial(1, {0, 0, 0}, {0, 0, 0})})};
  scene.efforts = {{"spring", CoordinateSpring{{"x"}, w * w, 0, 0}}};
  return scene;
}

/// The largest eigenvalue, by size, of (x, h v, h^2 a) from step to step for x'' = -w^2 x (Chung and Hulbert
/// 1993, equations 10 to 16; with the same signs of am and af).
double spectral_radius(double r, double hw) {
  const double am = (2 * r - 1) / (r + 1), af = r / (r + 1), gamma = 0.5 - am + af,
               beta = std::pow(gamma + 0.5, 2) / 4, k = hw * hw;
  // x1 - beta a1 = x0 + v0 + (1/2 - beta) a0,  v1 - gamma a1 = v0 + (1 - gamma) a0,
  // (1 - am) a1 + am a0 = -k ((1 - af) x1 + af x0)
  Eigen::Matrix3d next, now;
  next << 1, 0, -beta, 0, 1, -gamma, k * (1 - af), 0, 1 - am;
  now << 1, 1, 0.5 - beta, 0, 1, 1 - gamma, -k * af, 0, -am;
  return (next.inverse() * now).eval().eigenvalues().cwiseAbs().maxCoeff();
}

TEST(GeneralizedAlpha, DampsModesByItsSpectralRadius) {
  for (double r : {0., 0.5, 0.9, 1.}) {
    // infinitely stiff: the radius itself, to 1 / (h w)^2 times the multiplicity of the eigenvalue, three
    EXPECT_NEAR(spectral_radius(r, 1e9), r, 1e-4);
    for (double hw : {0.3, 3., 100.}) {
      const double h = 0.01;
      SimulationSettings how = settings("generalized_alpha", 2, h);
      how.spectral_radius = r;
      how.output_interval = 0;
      how.energy_threshold = 1e9;  // it loses energy by design
      const Trajectory path = run(oscillator(hw / h), how);
      // amplitude as the norm of (x, v / w), which rotates and shrinks
      const auto amplitude = [&](Eigen::Index i) {
        double most = 0;
        for (Eigen::Index k = i; k < i + 40; ++k)
          most = std::max(most, std::hypot(path.q(k, 0), path.v(k, 0) * h / hw));
        return most;
      };
      const double radius = spectral_radius(r, hw);
      if (std::pow(radius, 160) < 1e-12) {  // gone
        EXPECT_LT(amplitude(150), 1e-9) << r << ", " << hw;
        continue;
      }
      // the largest of forty steps depends on the phase, by a few per cent in 120 steps
      EXPECT_NEAR(std::pow(amplitude(160) / amplitude(40), 1. / 120), radius, 5e-3) << r << ", " << hw;
    }
  }
}

TEST(GeneralizedAlpha, IsOfSecondOrderOnAHeavyTop) {
  // Arnold and Bruels' heavy top, its centre at 1 s by dop853, at two steps: second order
  Scene top;
  top.solids = {solid("top", "world", {ball("turn", identity_quaternion(), {0, 150, -4.61538})},
                      {inertial(15, {0, 1, 0}, {0.234375, 0.46875, 0.234375})})};
  const Vector3d reference = last(run(top, settings("dop853", 1, 1e-3, 1e-12)).gravity_centre);
  const auto error = [&](double step) {
    SimulationSettings how = settings("generalized_alpha", 1, step);
    how.spectral_radius = 0.9;
    return (Vector3d(last(run(top, how).gravity_centre)) - reference).norm();
  };
  const double coarse = error(2e-3), fine = error(1e-3);
  EXPECT_NEAR(std::log2(coarse / fine), 2, 0.2);
}

TEST(GeneralizedAlpha, MeetsConstraintsWithinTheStep) {
  // a pendulum of two slides and a rod in long steps: projection corrects velocities only
  Scene point;
  point.solids = {solid("point", "world",
                        {slide("x", Vector3d::UnitX(), -1), slide("z", Vector3d::UnitZ(), 0)},
                        {inertial(1, {0, 0, 0}, {0, 0, 0})})};
  point.constraints = {{"rod", Distance{{"point", {0, 0, 0}}, {"world", {0, 0, 0}}, constant(1)}}};
  SimulationSettings how = settings("generalized_alpha", 10, 0.01);
  how.energy_threshold = 1e9;
  const Certificate held = run(point, how).certificate;
  how.method = "rk2";
  const Certificate put_back = run(point, how).certificate;
  EXPECT_LT(held.residuals[0].position, 1e-12);
  EXPECT_LT(held.work_projection_size, put_back.work_projection_size);
}

TEST(GeneralizedAlpha, HandlesStiffnessAndRedundantRows) {
  // a stiff dashpot (rate 1e6 / s, steps of 0.01 s) beside two rods of which one is redundant
  Scene scene;
  scene.solids = {solid("point", "world",
                        {slide("x", Vector3d::UnitX(), -1), slide("z", Vector3d::UnitZ(), 0, -9.81e-6)},
                        {inertial(1, {0, 0, 0}, {0, 0, 0})})};
  scene.efforts = {{"dx", CoordinateSpring{{"x"}, 0, 1e6, 0}}, {"dz", CoordinateSpring{{"z"}, 0, 1e6, 0}}};
  for (const char* name : {"rod", "twin"})
    scene.constraints.push_back({name, Distance{{"point", {0, 0, 0}}, {"world", {0, 0, 0}}, constant(1)}});
  const double end = 10, angle = 2 * std::atan(std::exp(-9.81 * end / 1e6));
  const Trajectory crept = run(scene, settings("generalized_alpha", end, 0.01));
  // it starts at the creeping speed, 1e-5 rad/s, up to (m / c)^2 g
  EXPECT_LT((last(crept.q) - Eigen::Vector2d(-std::sin(angle), -std::cos(angle))).norm(), 1e-10);
}

}  // namespace
}  // namespace borelli::test
