// Published problems and closed forms among the samples: Andrews' squeezing mechanism, IFToMM's A01,
// Kapitza's pendulum, the sleeping top, Dzhanibekov's flips.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "scenes.hpp"

namespace borelli::test {
namespace {

using Eigen::Vector3d;

// Hairer and Wanner, Solving ODEs II, VII.7; CWI/Bari test set, problem `andrews`: the angles at 0.03 s.
// Published to 16 digits; computations in long double with three stabilisation gains confirm nine.
TEST(Gallery, AndrewsSqueezerEndsAtThePublishedAngles) {
  const std::pair<const char*, double> published[] = {
      {"beta", 15.81077119629904},   {"theta", -15.75637105984298}, {"gamma", 0.04082224013073101},
      {"phi", -0.5347301163226948},  {"delta", 0.5244099658805304}, {"omega", 0.5347301163226948},
      {"epsilon", 1.048080741042263}};
  const Trajectory t = run(sample("andrews.toml"));
  ASSERT_EQ(t.q.cols(), 7);
  for (const auto& [name, angle] : published) {
    const auto at = std::find_if(t.coordinates.begin(), t.coordinates.end(),
                                 [&, name = name](const CoordinateInfo& c) { return c.name == name; });
    ASSERT_NE(at, t.coordinates.end()) << name;
    // uncertainty of the published values, 2e-9, plus 1e-10 a step over about 100 steps
    EXPECT_NEAR(t.q(t.q.rows() - 1, at->q_index), angle, 1e-8) << name;
  }
  for (const auto& row : t.certificate.residuals) {
    EXPECT_LT(row.position, 1e-9) << row.constraint;
    EXPECT_LT(row.velocity, 1e-9) << row.constraint;
  }
  EXPECT_EQ(t.certificate.residuals.size(), 6u);
}

TEST(Gallery, StepsWithLargeProjectionsAreRepeated) {
  // at a coarse tolerance the fast mechanism makes steps whose error estimate is less than the drift off the
  // constraints; at a fine one the estimate holds
  const auto tried_again = [](double tolerance) {
    Scene scene = sample("andrews.toml");
    scene.simulation.method = "dopri5";
    scene.simulation.tolerance = tolerance;
    const Trajectory t = run(scene);
    return std::any_of(t.certificate.notes.begin(), t.certificate.notes.end(), [](const std::string& note) {
      return note.find(
                 "steps were repeated with a shorter length, because constraint projection moved their "
                 "ends") != std::string::npos;
    });
  };
  EXPECT_TRUE(tried_again(1e-3));
  EXPECT_FALSE(tried_again(1e-8));
}

TEST(Gallery, PointOnACircleMatchesTheBenchmark) {
  const Trajectory t = run(sample("a01.toml"));
  // IFToMM A01; 300 steps at a tolerance of 1e-11 a step, and errors that grow like the time
  EXPECT_NEAR(t.q(t.q.rows() - 1, 0), -.275087462576117, 1e-8);
  EXPECT_NEAR(t.q(t.q.rows() - 1, 1), -.961419205099125, 1e-8);
}

/// l theta'' = (g - a w^2 cos(w t)) theta, the angle from the upright of a pendulum whose pivot moves by a
/// cos(w t) (Mathieu's equation): the angle at `end` for theta = start at rest, by classical Runge-Kutta
/// steps of a 200th period.
double mathieu(double g_over_l, double a_over_l, double w, double start, double end) {
  const auto f = [&](double t, double theta) {
    return (g_over_l - a_over_l * w * w * std::cos(w * t)) * theta;
  };
  const long n = std::lround(std::ceil(end * w * 200 / (2 * std::numbers::pi)));
  const double h = end / static_cast<double>(n);
  double x = start, v = 0;
  for (long i = 0; i < n; ++i) {
    const double t = static_cast<double>(i) * h;
    const double v1 = v, a1 = f(t, x), v2 = v + h / 2 * a1, a2 = f(t + h / 2, x + h / 2 * v1);
    const double v3 = v + h / 2 * a2, a3 = f(t + h / 2, x + h / 2 * v2), v4 = v + h * a3,
                 a4 = f(t + h, x + h * v3);
    x += h / 6 * (v1 + 2 * v2 + 2 * v3 + v4);
    v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
  return x;
}

TEST(Gallery, KapitzasPendulumStaysUprightOnlyAboveItsLimit) {
  const double g = 9.81, a = 0.02, limit = std::sqrt(2 * g) / a;  // limit of w for l = 1: a^2 w^2 = 2 g l
  const auto shaken = [&](double rate, double start, double end) {
    Scene scene = sample("kapitza.toml");
    std::vector<Switch>& joint = scene.solids[0].switches;
    std::get<Sine>(std::get<Driven>(joint[0].motion).functions.at(0)).angular_frequency = rate;
    joint[1].q = {start};
    scene.simulation.end_time = end;
    scene.simulation.tolerance = 1e-11;
    return run(scene);
  };
  // so small that sin(theta) = theta to a relative 1e-10: then Mathieu's equation holds
  for (const double share : {0.5, 2.}) {
    const double rate = limit * std::sqrt(share), start = 1e-5;
    const Trajectory t = shaken(rate, start, 1.5);
    EXPECT_NEAR(t.q(t.q.rows() - 1, 0), mathieu(g, a, rate, start, 1.5), 1e-6 * start) << share;
  }
  // w^2 at twice its limit: the angle stays within the start's for ten swings; the slow frequency is
  // w_slow^2 = a^2 w^2 / (2 l^2) - g / l = g / l, to order a / l (Kapitza 1951)
  const Trajectory kept = shaken(limit * std::sqrt(2), 0.02, 20);
  EXPECT_LT(kept.q.col(0).cwiseAbs().maxCoeff(), 0.02 * 1.05);
  EXPECT_GT(kept.q.col(0).cwiseAbs().maxCoeff(), 0.02 * 0.999);
  // w^2 at half its limit: it falls at the rate sqrt(g / (2 l))
  const Trajectory fallen = shaken(limit * std::sqrt(.5), 0.02, 4);
  EXPECT_GT(fallen.q.col(0).cwiseAbs().maxCoeff(), 1.5);
}

// The tilt of a nearly upright top, its axis (x, y) as xi = x + i y: I1 xi'' - i I3 w xi' - m g l xi = 0.
TEST(Gallery, TopSleepsOnlyAboveItsLimit) {
  const double I1 = 1.5e-3, I3 = 4e-4, mgl = 0.5 * 9.81 * 0.05;
  const double limit = std::sqrt(4 * mgl * I1) / I3;
  EXPECT_NEAR(limit, 95.90, 0.005);
  for (const double share : {1.1, 0.9}) {
    SCOPED_TRACE(share);
    Scene scene = sample("sleeping_top.toml");
    const double w = share * limit, push = 1e-6;
    scene.solids[0].switches[0].v = {push, 0, w};
    scene.simulation.end_time = 1;
    const Trajectory t = run(scene);
    const std::complex<double> i(0, 1),
        root = std::sqrt(std::complex<double>(mgl / I1 - std::pow(I3 * w / (2 * I1), 2)));
    const std::complex<double> r1 = i * (I3 * w / (2 * I1)) + root, r2 = i * (I3 * w / (2 * I1)) - root;
    // pushed about x, the axis first moves to -y: xi' = -i push
    const auto tilt = [&](double at) {
      return -i * push / (r1 - r2) * (std::exp(r1 * at) - std::exp(r2 * at));
    };
    double largest = 0;
    for (std::size_t row = 0; row < t.times.size(); ++row) {
      const Vector3d axis = t.pose(row, 0).R.col(2);
      const std::complex<double> expected = tilt(t.times[row]);
      largest = std::max(largest, std::abs(expected));
      // 1e-11 a step in quaternion and velocity; an unstable top's errors grow by exp(5.2) in a second
      EXPECT_LT(std::abs(std::complex<double>(axis.x(), axis.y()) - expected), 1e-9 * (share < 1 ? 10 : 1))
          << t.times[row];
    }
    if (share > 1) {
      EXPECT_LT(largest, 2 * push / std::abs(root));
    } else {
      EXPECT_GT(largest, 10 * push / std::abs(root));
    }
  }
  // as the sample says: pushed by 0.01 rad/s, it stays within a hundredth of a radian; below the limit it
  // falls
  const auto lowest = [](double w) {
    Scene scene = sample("sleeping_top.toml");
    scene.solids[0].switches[0].v[2] = w;
    const Trajectory t = run(scene);
    double z = 1;
    for (std::size_t row = 0; row < t.times.size(); ++row) z = std::min(z, t.pose(row, 0).R(2, 2));
    return z;
  };
  EXPECT_GT(lowest(1.1 * limit), std::cos(0.01));
  EXPECT_LT(lowest(0.9 * limit), std::cos(0.5));
}

// Landau and Lifshitz, Mechanics, 37: with moments I1 < I2 < I3, energy E and momentum M, M^2 > 2 E I2 or
// below, w2 is an elliptic sine; it passes zero every 2 K(k) / n.
TEST(Gallery, DzhanibekovsPlateFlipsInItsPeriod) {
  Scene scene = sample("spinning_plate.toml");
  scene.simulation.output_interval = 1e-3;
  const Trajectory t = run(scene);
  const double I1 = 1, I2 = 2, I3 = 3, w1 = 1e-3, w2 = 10, w3 = 1e-3;
  const double twice_energy = I1 * w1 * w1 + I2 * w2 * w2 + I3 * w3 * w3;
  const double M2 = std::pow(I1 * w1, 2) + std::pow(I2 * w2, 2) + std::pow(I3 * w3, 2);
  double n2 = (I3 - I2) * (M2 - twice_energy * I1) / (I1 * I2 * I3);
  double k2 = (I2 - I1) * (twice_energy * I3 - M2) / ((I3 - I2) * (M2 - twice_energy * I1));
  if (k2 > 1) k2 = 1 / k2, n2 = (I2 - I1) * (twice_energy * I3 - M2) / (I1 * I2 * I3);
  const double half = 2 * std::comp_ellint_1(std::sqrt(k2)) / std::sqrt(n2);

  std::vector<double> flips;
  const Eigen::Index y = t.v.cols() - 2;
  Vector3d first_momentum;
  for (Eigen::Index row = 0; row < t.v.rows(); ++row) {
    const Vector3d spin = t.v.row(row).tail(3).transpose();
    const Vector3d momentum =
        t.pose(static_cast<std::size_t>(row), 0).R * Vector3d(I1, I2, I3).cwiseProduct(spin);
    if (row == 0) first_momentum = momentum;
    EXPECT_LT((momentum - first_momentum).norm(), 1e-10);
    EXPECT_NEAR(spin.dot(Vector3d(I1, I2, I3).cwiseProduct(spin)), twice_energy, 2e-10);
    if (row == 0) continue;
    // w2 is straight where it passes zero (an odd function about there): 1e-3 s apart the chord is good to
    // 1e-8 s
    const double before = t.v(row - 1, y), after = t.v(row, y);
    if (before * after < 0)
      flips.push_back(t.times[static_cast<std::size_t>(row) - 1] + 1e-3 * before / (before - after));
  }
  ASSERT_GE(flips.size(), 3u);
  for (std::size_t i = 1; i < flips.size(); ++i) EXPECT_NEAR(flips[i] - flips[i - 1], half, 1e-6);
}

}  // namespace
}  // namespace borelli::test
