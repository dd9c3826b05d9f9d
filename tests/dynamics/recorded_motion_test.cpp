// Recorded motions against motions with known velocities and accelerations.
#include "dynamics/inverse/recorded_motion.hpp"

#include "scenes.hpp"

namespace borelli::test::recorded_motion_test {
namespace {

/// A slide, a hinge and a ball that follow sines; the ball's turn is exp(x(t)) about changing axes.
State known(double t) {
  State state;
  state.t = t;
  state.q.resize(6);
  const Vector3d x{0.9 * std::sin(2 * t), 0.5 * std::cos(1.5 * t), 0.7 * std::sin(t)};
  state.q << 0.2 * std::sin(3 * t), 0.4 * std::cos(2 * t), 0, 0, 0, 0;
  const double angle = x.norm();
  state.q[2] = std::cos(angle / 2);
  state.q.tail<3>() = std::sin(angle / 2) / angle * x;
  return state;
}

System three_joints() {
  Scene scene;
  scene.name = "three joints";
  scene.solids.push_back(solid(
      "s", "world", {slide("slide", Vector3d::UnitX()), hinge("hinge", Vector3d::UnitZ()), ball("ball")},
      {inertial(1, Vector3d::Zero(), Vector3d(1, 1, 1))}));
  return compiled(scene);
}

/// The ball's angular velocity in body axes, by differences of its rotation.
Vector3d spin(double t) {
  const double h = 1e-5;
  const auto R = [](double at) {
    const State s = known(at);
    return Eigen::Quaterniond(s.q[2], s.q[3], s.q[4], s.q[5]).toRotationMatrix();
  };
  const Matrix3d W = R(t).transpose() * (R(t + h) - R(t - h)) / (2 * h);
  return {W(2, 1), W(0, 2), W(1, 0)};
}

TEST(RecordedMotion, GivesVelocitiesAndAccelerationsOfEveryCoordinate) {
  const System system = three_joints();
  RecordedPositions positions{{}, Rows(401, 6)};
  for (int i = 0; i <= 400; ++i) {
    positions.times.push_back(0.01 * i);
    positions.q.row(i) = known(0.01 * i).q.transpose();
    if (i % 3 == 1) positions.q.row(i).tail<4>() *= -1;  // the same rotation
  }
  const RecordedMotion motion = need(RecordedMotion::of(system, positions, 0));
  State state;
  Eigen::VectorXd a;
  const double h = 1e-4;
  for (double t = 1; t < 3; t += 0.0873) {
    motion.at(t, state, a);
    EXPECT_NEAR(state.q.tail<4>().norm(), 1, 1e-14);
    EXPECT_NEAR(state.v[0], 0.6 * std::cos(3 * t), 1e-8);
    EXPECT_NEAR(a[1], -1.6 * std::cos(2 * t), 1e-6);
    EXPECT_LT((state.v.tail<3>() - spin(t)).norm(), 1e-8);  // differences: h^2
    EXPECT_LT((a.tail<3>() - (spin(t + h) - spin(t - h)) / (2 * h)).norm(), 2e-6);
  }
}

TEST(RecordedMotion, RefusesPositionsOfAnotherSystem) {
  const System system = three_joints();
  EXPECT_FALSE(RecordedMotion::of(system, {{0, 1, 2}, Rows::Zero(3, 5)}, 0));
  EXPECT_FALSE(RecordedMotion::of(system, {{0, 1, 1}, Rows::Ones(3, 6)}, 0));
  EXPECT_FALSE(RecordedMotion::of(system, {{0, 1, 2}, Rows::Ones(3, 6)}, 5));
}

}  // namespace
}  // namespace borelli::test::recorded_motion_test
