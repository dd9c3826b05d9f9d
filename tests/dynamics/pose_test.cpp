// Rigid transforms and quaternions against Eigen's own.
#include "dynamics/numbers/pose.hpp"

#include "scenes.hpp"

namespace borelli::test {
namespace {

// sums of a few products of numbers near 1
constexpr double rounding = 1e-14;

TEST(Pose, ComposesAndInvertsLikeEigensTransforms) {
  Random random(1);
  for (int i = 0; i < 20; ++i) {
    const Pose a{rotation_matrix(random.turn()), random.vector(2)},
        b{rotation_matrix(random.turn()), random.vector(2)};
    const Eigen::Isometry3d A = Eigen::Translation3d(a.p) * Eigen::Quaterniond(a.R);
    const Eigen::Isometry3d B = Eigen::Translation3d(b.p) * Eigen::Quaterniond(b.R);
    const Vector3d p = random.vector(3);
    EXPECT_LT(((a * b * p) - (A * B * p)).norm(), 10 * rounding);
    EXPECT_LT(((a.inverse() * p) - (A.inverse() * p)).norm(), 10 * rounding);
  }
}

TEST(Quaternion, MultipliesAndRotatesLikeEigens) {
  Random random(2);
  for (int i = 0; i < 20; ++i) {
    const Quaternion a = random.turn(), b = random.turn();
    const Eigen::Quaterniond A(a[0], a[1], a[2], a[3]), B(b[0], b[1], b[2], b[3]);
    EXPECT_LT((rotation_matrix(a) - A.toRotationMatrix()).norm(), rounding);
    const Eigen::Quaterniond AB = A * B;
    EXPECT_LT((product(a, b) - Quaternion(AB.w(), AB.x(), AB.y(), AB.z())).norm(), rounding);
    EXPECT_LT((product(a, conjugate(a)) - identity_quaternion()).norm(), rounding);
  }
}

TEST(Quaternion, OfAMatrixGivesTheSameRotation) {
  Random random(3);
  for (int i = 0; i < 20; ++i) {
    const Matrix3d R = rotation_matrix(random.turn());
    const Quaternion q = quaternion(R);
    EXPECT_GE(q[0], 0);
    EXPECT_NEAR(q.norm(), 1, rounding);
    EXPECT_LT((rotation_matrix(q) - R).norm(), rounding);
  }
}

}  // namespace
}  // namespace borelli::test
