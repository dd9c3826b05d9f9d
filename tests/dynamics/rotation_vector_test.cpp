// The exponential map against Rodrigues' formula, and its derivatives against central differences.
#include "dynamics/numbers/rotation_vector.hpp"

#include "scenes.hpp"

namespace borelli::test {
namespace {

TEST(RotationVector, ExponentialIsRodriguesFormula) {
  Random random(1);
  for (double angle : {0.0, 1e-9, 1e-5, 9e-4, 1.1e-3, 0.5, 3.0, 6.0}) {
    const Vector3d axis = random.direction();
    EXPECT_LT((rotation_matrix(exponential(angle * axis)) - rotation_about(axis, angle)).norm(), 1e-14)
        << angle;
  }
}

TEST(RotationVector, LogarithmInvertsTheExponential) {
  Random random(2);
  for (double angle : {0.0, 1e-12, 1e-7, 1e-6, 1e-3, 0.5, 3.14}) {
    const Vector3d theta = angle * random.direction();
    // relative rounding: small rotations keep their digits
    EXPECT_LT((logarithm(exponential(theta)) - theta).norm(), 1e-15 + 4e-15 * angle) << angle;
  }
}

TEST(RotationVector, LogarithmTakesTheShorterRotation) {
  const Vector3d theta(0, 0, 4);  // 4 rad one way are 2 pi - 4 the other
  EXPECT_LT((logarithm(exponential(theta)) - Vector3d(0, 0, 4 - 2 * M_PI)).norm(), 1e-14);
}

/// Body angular velocity of exp(theta + s rate) at s = 0, by central differences of the rotation matrix:
/// error step^2 = 1e-10 and rounding 1e-16 / step = 1e-11.
Vector3d difference_velocity(const Vector3d& theta, const Vector3d& rate) {
  const double h = 1e-5;
  const Matrix3d plus = rotation_matrix(exponential(theta + h * rate));
  const Matrix3d minus = rotation_matrix(exponential(theta - h * rate));
  const Matrix3d W = rotation_matrix(exponential(theta)).transpose() * (plus - minus) / (2 * h);
  return {W(2, 1), W(0, 2), W(1, 0)};
}

TEST(RotationVector, BodyVelocityMatchesTheMovingMatrix) {
  Random random(3);
  for (double angle : {0.0, 1e-3, 0.049, 0.051, 1.0, 3.0}) {
    const Vector3d theta = angle * random.direction(), rate = random.vector(1),
                   acceleration = random.vector(1);
    const auto [w, wdot] = body_velocity(theta, rate, acceleration);
    EXPECT_LT((w - difference_velocity(theta, rate)).norm(), 1e-9) << angle;
    const double h = 1e-5;
    const auto ahead =
        body_velocity(theta + h * rate + h * h / 2 * acceleration, rate + h * acceleration, acceleration);
    const auto behind =
        body_velocity(theta - h * rate + h * h / 2 * acceleration, rate - h * acceleration, acceleration);
    EXPECT_LT((wdot - (ahead[0] - behind[0]) / (2 * h)).norm(), 1e-9) << angle;
  }
}

TEST(RotationVector, SeriesMatchTheClosedForms) {
  Random random(4);
  const Vector3d axis = random.direction(), rate = random.vector(1), acceleration = random.vector(1);
  // on both sides of the switch of formulas at 0.05 rad, values differ only by their slope times 1e-9
  const auto below = body_velocity((0.05 - 5e-10) * axis, rate, acceleration);
  const auto above = body_velocity((0.05 + 5e-10) * axis, rate, acceleration);
  EXPECT_LT((below[0] - above[0]).norm(), 2e-9);
  EXPECT_LT((below[1] - above[1]).norm(), 2e-9);
  // and at 0.01 rad
  EXPECT_LT(
      (rotation_vector_rate((0.01 - 5e-12) * axis, rate) - rotation_vector_rate((0.01 + 5e-12) * axis, rate))
          .norm(),
      2e-11);
}

TEST(RotationVector, RateInvertsBodyVelocity) {
  Random random(5);
  for (double angle : {0.0, 1e-4, 0.009, 0.011, 1.0, 3.0, 5.0}) {
    const Vector3d theta = angle * random.direction(), rate = random.vector(1);
    const Vector3d w = body_velocity(theta, rate, Vector3d::Zero())[0];
    EXPECT_LT((rotation_vector_rate(theta, w) - rate).norm(), 1e-13) << angle;
  }
}

}  // namespace
}  // namespace borelli::test
