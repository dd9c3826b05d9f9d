// Impact laws on rows of balls and on a rod with friction: closed forms.
#include "dynamics/contacts/impact.hpp"

#include <gtest/gtest.h>

namespace borelli {
namespace {

using Eigen::VectorXd;

/// n balls of 1 kg in a row, touching; the first comes with 1 m/s. A contact's velocity is that of the ball
/// ahead minus that of the ball behind.
Shock row_of(int n, double restitution) {
  Shock shock;
  const int count = n - 1;
  shock.surfaces.assign(count, {restitution, 0});
  for (int i = 0; i < count; ++i) shock.pair.push_back(i);
  shock.velocity = VectorXd::Zero(3 * count);
  shock.velocity[0] = -1;
  shock.response = Eigen::MatrixXd::Zero(3 * count, 3 * count);
  for (int i = 0; i < count; ++i) {
    shock.response(3 * i, 3 * i) = 2;
    if (i > 0) shock.response(3 * i, 3 * i - 3) = shock.response(3 * i - 3, 3 * i) = -1;
  }
  return shock;
}

/// Velocities of the balls of such a row from their contacts' impulses.
VectorXd balls(const ShockResult& result, int n) {
  VectorXd v = VectorXd::Zero(n);
  v[0] = 1;
  for (int i = 0; i + 1 < n; ++i) {
    v[i] -= result.impulse[3 * i];
    v[i + 1] += result.impulse[3 * i];
  }
  return v;
}

TEST(Impact, SequentialLawPassesTheSpeedThroughTheCradle) {
  for (const auto law : {RestitutionLaw::newton, RestitutionLaw::poisson}) {
    const ShockResult result = resolve(row_of(5, 1), ImpactLaw::sequential, law, 1e-6);
    ASSERT_TRUE(result.settled);
    EXPECT_LT((balls(result, 5) - VectorXd::Unit(5, 4)).norm(), 1e-14);  // rounding of a few sums
    EXPECT_NEAR(result.lost.sum(), 0, 1e-14);
  }
}

TEST(Impact, SimultaneousLawSplitsTheCradleByNewtonsLaw) {
  // Glocker, Set-valued force laws (2001), and others: (-.6, .4, .4, .4, .4)
  const ShockResult result = resolve(row_of(5, 1), ImpactLaw::simultaneous, RestitutionLaw::newton, 1e-6);
  ASSERT_TRUE(result.settled);
  VectorXd expected(5);
  expected << -0.6, 0.4, 0.4, 0.4, 0.4;
  EXPECT_LT((balls(result, 5) - expected).norm(), 1e-12);  // sweeps end at 1e-13
  EXPECT_NEAR(result.lost.sum(), 0, 1e-12);
  EXPECT_FALSE(result.energetic);
}

TEST(Impact, WithoutRestitutionTheRowMovesTogether) {
  for (const auto law : {ImpactLaw::sequential, ImpactLaw::simultaneous}) {
    const ShockResult result = resolve(row_of(5, 0), law, RestitutionLaw::newton, 1e-6);
    ASSERT_TRUE(result.settled);
    // in sequence, the speeds converge geometrically until they differ by 1e-13
    EXPECT_LT((balls(result, 5) - VectorXd::Constant(5, 0.2)).norm(), 1e-11);
    EXPECT_NEAR(result.lost.sum(), 0.5 - 0.5 * 0.2, 1e-11);
  }
}

/// A uniform rod of 1 kg and 1 m whose end strikes the ground at an angle, coming down at 1 m/s with a slip:
/// the response of its end, 1/m (delta_ij + 12 / l^2 (r x e_i) (r x e_j)).
Shock rod(double angle, double slip, double restitution, double friction) {
  const double x = -0.5 * std::cos(angle), z = -0.5 * std::sin(angle);  // the end, relative to the middle
  Shock shock;
  shock.surfaces = {{restitution, friction}};
  shock.pair = {0};
  shock.velocity = Eigen::Vector3d(-1, slip, 0);
  shock.response = Eigen::Matrix3d::Identity();
  shock.response(0, 0) += 12 * x * x;
  shock.response(1, 1) += 12 * z * z;
  shock.response(0, 1) = shock.response(1, 0) = -12 * x * z;
  return shock;
}

TEST(Impact, SlippingRodEndFollowsItsClosedForm) {
  // friction 0.1 cannot stop 5 m/s: p_n = (1 + e) / (G_nn - mu G_nt), p_t = -mu p_n
  const Shock shock = rod(1, 5, 0.5, 0.1);
  const ShockResult result = resolve(shock, ImpactLaw::sequential, RestitutionLaw::newton, 1e-6);
  const double normal = 1.5 / (shock.response(0, 0) - 0.1 * shock.response(0, 1));
  EXPECT_NEAR(result.impulse[0], normal, 1e-13);
  EXPECT_NEAR(result.impulse[1], -0.1 * normal, 1e-13);
  EXPECT_NEAR(result.velocity[0], 0.5, 1e-13);
  EXPECT_FALSE(result.energetic);
}

TEST(Impact, NoLawAddsEnergy) {
  // Newton's law with friction would add energy in some of these, as the work of the impulses shows
  int scaled = 0;
  for (const auto law : {ImpactLaw::sequential, ImpactLaw::simultaneous})
    for (const auto restitution : {RestitutionLaw::newton, RestitutionLaw::poisson})
      for (const double angle : {0.3, 0.6, 0.9, 1.2})
        for (const double slip : {-3.0, -1.0, -0.3, 0.3, 1.0, 3.0})
          for (const double friction : {0.2, 0.5, 1.0, 2.0}) {
            const Shock shock = rod(angle, slip, 0.9, friction);
            const ShockResult result = resolve(shock, law, restitution, 1e-6);
            ASSERT_TRUE(result.settled) << angle << ' ' << slip << ' ' << friction;
            EXPECT_GE(result.velocity[0], -1e-12);
            const double work = 0.5 * result.impulse.dot(shock.velocity + result.velocity);
            EXPECT_LE(work, 1e-11);
            EXPECT_NEAR(result.lost.sum(), -work, 1e-11);
            const double across = result.impulse.tail<2>().norm();
            EXPECT_LE(across, friction * result.impulse[0] * (1 + 1e-12));
            scaled += result.energetic;
          }
  EXPECT_GT(scaled, 0);  // Kane's case is among them
}

}  // namespace
}  // namespace borelli
