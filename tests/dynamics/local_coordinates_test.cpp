// The rate of the local coordinates against central differences of the positions that they give.
#include "dynamics/constraints/local_coordinates.hpp"

#include "scenes.hpp"

namespace borelli::test {
namespace {

TEST(LocalCoordinates, RateReproducesTheVelocities) {
  const System system = compiled(random_tree(2, {.balls = true}));
  Random random(8);
  const State state = random.state(system);
  Eigen::VectorXd x(system.nv), rate(system.nv);
  for (double& one : x) one = random.number(-1.2, 1.2);
  local_rate(system, x.data(), state.v.data(), rate.data());
  const double h = 1e-6;
  Eigen::VectorXd behind(system.nq), now(system.nq), ahead(system.nq);
  const auto positions = [&](double s, Eigen::VectorXd& q) {
    const Eigen::VectorXd at = x + s * rate;
    from_local_coordinates(system, state.q.data(), at.data(), q.data());
  };
  positions(-h, behind);
  positions(0, now);
  positions(h, ahead);
  for (const CoordinateInfo& info : system.coordinates) {
    const auto qdot = (ahead - behind).segment(info.q_index, info.q_size) / (2 * h);
    if (info.q_size == 1) {
      EXPECT_NEAR(qdot[0], state.v[info.v_index], 1e-9);
      continue;
    }
    Quaternion w;  // dq/dt = q (0, w) / 2
    w << 0, state.v.segment<3>(info.v_index);
    const Quaternion expected = product(now.segment<4>(info.q_index), w) / 2;
    EXPECT_LT((Eigen::Vector4d(qdot) - expected).norm(), 1e-9);  // rounding 1e-16 / h
    EXPECT_NEAR(now.segment<4>(info.q_index).norm(), 1, 1e-15);
  }
}

}  // namespace
}  // namespace borelli::test
