// First and second derivatives of the positioning functions against central differences, on random trees with
// every switch, free and driven.
#include "dynamics/equations/kinematics.hpp"

#include <algorithm>

#include "dynamics/constraints/local_coordinates.hpp"
#include "scenes.hpp"
#include "second_derivative.hpp"

namespace borelli::test {
namespace {

class KinematicsOfTrees : public testing::TestWithParam<int> {
 protected:
  KinematicsOfTrees()
      : system(compiled(random_tree(unsigned(GetParam()), {.balls = true, .drives = true}))),
        state(Random(77).state(system)) {
    state.t = 0.3;
  }
  /// At time t + s, having moved for s with constant velocities.
  Kinematics after(double s) const {
    Eigen::VectorXd q = state.q;
    const Eigen::VectorXd x = s * state.v;
    from_local_coordinates(system, state.q.data(), x.data(), q.data());
    Kinematics k(system);
    update_kinematics(system, system.parameters, state.t + s, q.data(), state.v.data(), k);
    return k;
  }
  System system;
  State state;
  // of central differences: h^2 times third derivatives (about 100 here), and rounding / h
  static constexpr double h = 1e-5, tolerance = 1e-7;
};

TEST_P(KinematicsOfTrees, VelocitiesAreTheRatesOfPoses) {
  const Kinematics behind = after(-h), now = after(0), ahead = after(h);
  for (std::size_t b = 1; b < system.bodies.size(); ++b) {
    EXPECT_LT((now.bodies[b].v - (ahead.bodies[b].g - behind.bodies[b].g) / (2 * h)).norm(), tolerance);
    const Matrix3d W = (ahead.bodies[b].X.R - behind.bodies[b].X.R) / (2 * h) * now.bodies[b].X.R.transpose();
    EXPECT_LT((now.bodies[b].w - Vector3d(W(2, 1), W(0, 2), W(1, 0))).norm(), tolerance);
  }
}

TEST_P(KinematicsOfTrees, AccelerationsAreTheRatesOfVelocities) {
  const Kinematics behind = after(-h), now = after(0), ahead = after(h);
  for (std::size_t b = 1; b < system.bodies.size(); ++b) {
    EXPECT_LT((now.bodies[b].vdot - (ahead.bodies[b].v - behind.bodies[b].v) / (2 * h)).norm(), tolerance);
    EXPECT_LT((now.bodies[b].wdot - (ahead.bodies[b].w - behind.bodies[b].w) / (2 * h)).norm(), tolerance);
  }
}

TEST_P(KinematicsOfTrees, SecondDerivativesMatchDifferencesOfTheFirst) {
  const Kinematics now = after(0);
  for (int j = 0; j < system.nv; ++j) {  // along each free unit velocity
    const auto moved = [&](double s) {
      Eigen::VectorXd q = state.q;
      const Eigen::VectorXd x = s * Eigen::VectorXd::Unit(system.nv, j);
      from_local_coordinates(system, state.q.data(), x.data(), q.data());
      Kinematics k(system);
      update_kinematics(system, system.parameters, state.t, q.data(), state.v.data(), k);
      return k;
    };
    const Kinematics behind = moved(-h), ahead = moved(h);
    for (int b = 1; b < int(system.bodies.size()); ++b) {
      const Body& body = system.bodies[b];
      const int* support = system.branches().support.data() + body.first_support;
      const int place = int(std::find(support, support + body.support_count, j) - support);
      for (int i = 0; i < body.support_count; ++i) {
        Eigen::Matrix<double, 6, 1> difference;
        for (int c = 0; c < 6; ++c)
          difference[c] = (ahead.row(system, b, c)[i] - behind.row(system, b, c)[i]) / (2 * h);
        Eigen::Matrix<double, 6, 1> exact = Eigen::Matrix<double, 6, 1>::Zero();
        if (place < body.support_count) {
          const SecondDerivative d = second_derivative(system, now, b, i, place);
          exact << d.v, d.w;
        }
        EXPECT_LT((exact - difference).norm(), tolerance) << "body " << b << ", " << i << " by " << place;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Random, KinematicsOfTrees, testing::Range(0, 8));

}  // namespace
}  // namespace borelli::test
