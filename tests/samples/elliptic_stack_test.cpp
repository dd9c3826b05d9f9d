#include "samples/elliptic_stack.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace borelli::elliptic_stack_test {
namespace {

using Eigen::Matrix3d, Eigen::Matrix4d, Eigen::Vector2d, Eigen::Vector3d;
constexpr double pi = std::numbers::pi;

// The accuracy that EllipticStack states for its moments, relative to the solid's extent and box, with a
// margin for rounding off the origin.
constexpr double quadrature = 1e-10;

Matrix3d skewed() {
  return (Eigen::AngleAxisd(0.7, Vector3d(1, 2, -1).normalized()) *
          Eigen::AngleAxisd(-1.9, Vector3d::UnitY()))
      .toRotationMatrix();
}

// Volume, centre and covariance (mean square about the centre) of a solid given by its moments.
struct Shape {
  double volume;
  Vector3d centre;
  Matrix3d covariance;
  explicit Shape(const Matrix4d& m)
      : volume(m(3, 3)),
        centre(m.topRightCorner<3, 1>() / m(3, 3)),
        covariance(m.topLeftCorner<3, 3>() / m(3, 3) - centre * centre.transpose()) {}
};

TEST(EllipticStack, EllipsoidInAnyPose) {
  const Vector3d centre(310, -45, 1620), semi(70, 80, 210);
  const Matrix3d axes = skewed();
  const Shape found(ellipsoid(centre, semi, axes).moments());
  const double volume = 4 * pi / 3 * semi.prod();
  EXPECT_NEAR(found.volume / volume, 1, quadrature);
  EXPECT_LT((found.centre - centre).norm() / 210, quadrature);
  const Matrix3d covariance = axes * semi.cwiseAbs2().asDiagonal() * axes.transpose() / 5;
  EXPECT_LT((found.covariance - covariance).norm() / covariance.norm(),
            quadrature * 100);  // (centre / size)^2
}

TEST(EllipticStack, CapsuleEqualsACylinderWithTwoHalfBalls) {
  const double r = 13, l = 90;
  const Vector3d from(5, 8, -3), along = skewed().col(2);
  const Shape found(capsule(from, from + l * along, r).moments());
  const double cylinder = pi * r * r * l, ball = 4 * pi / 3 * r * r * r;
  EXPECT_NEAR(found.volume / (cylinder + ball), 1, quadrature);
  // along the axis: the half balls' centroids lie 3/8 r beyond the ends, with (2/5 - 9/64) r^2 about them
  const double d = l / 2 + 3 * r / 8;
  const double axial = cylinder * l * l / 12 + ball * ((0.2 - 9. / 64) * r * r + d * d);
  EXPECT_NEAR(along.dot(found.covariance * along) * found.volume / axial, 1, quadrature);
  const Vector3d across = along.unitOrthogonal();
  const double radial = cylinder * r * r / 4 + ball * r * r / 5;
  EXPECT_NEAR(across.dot(found.covariance * across) * found.volume / radial, 1, quadrature);
}

TEST(EllipticStack, TruncatedEllipticCone) {
  const double h = 120, a0 = 30, b0 = 20, a1 = 12, b1 = 18;
  const Matrix3d axes = skewed();
  const Vector3d from(1, 2, 3);
  const Shape found(cone(from, from + h * axes.col(2), {a0, b0}, {a1, b1}, axes.col(0)).moments());
  // integral of pi a b over the height, a and b linear
  EXPECT_NEAR(found.volume, pi * h * (a0 * b0 + a1 * b1 + (a0 * b1 + a1 * b0) / 2) / 3, 1e-9 * found.volume);
  // a circular cone: its centroid lies at h (R^2 + 2 R r + 3 r^2) / 4 (R^2 + R r + r^2)
  const Shape round(cone(from, from + h * axes.col(2), {a0, a0}, {a1, a1}).moments());
  EXPECT_NEAR(axes.col(2).dot(round.centre - from),
              h * (a0 * a0 + 2 * a0 * a1 + 3 * a1 * a1) / (4 * (a0 * a0 + a0 * a1 + a1 * a1)), 1e-9 * h);
}

// The cap of the unit ball beyond height d: volume pi/3 (1-d)^2 (2+d), centroid 3/4 (1+d)^2/(2+d), and
// mean squares from integrating z^2 pi (1-z^2) and pi/4 (1-z^2)^2. An ellipsoid is its affine image.
TEST(EllipticStack, EllipsoidCutByAPlane) {
  const Vector3d centre(-20, 40, 900), semi(50, 30, 80);
  const Matrix3d axes = skewed();
  for (const double d : {-0.95, -0.3, 0.0, 0.6, 0.97}) {
    const Vector3d u = Vector3d(0.48, -0.6, 0.64);  // unit: the cap's axis in the ball
    const Matrix3d stretch = axes * semi.asDiagonal();
    const Vector3d normal = stretch.inverse().transpose() * u;
    const double offset = (d + normal.dot(centre)) / normal.norm();
    const HalfSpace beyond = HalfSpace{normal.normalized(), offset}.other_side();
    const Shape found(ellipsoid(centre, semi, axes).cut(beyond).moments());

    const double volume = pi / 3 * (1 - d) * (1 - d) * (2 + d);
    const double mean = 0.75 * (1 + d) * (1 + d) / (2 + d);
    const double zz = pi * ((1 - d * d * d) / 3 - (1 - std::pow(d, 5)) / 5) / volume - mean * mean;
    const double xx = pi / 4 * (8. / 15 - (d - 2 * d * d * d / 3 + std::pow(d, 5) / 5)) / volume;
    const Matrix3d covariance =
        stretch * (xx * Matrix3d::Identity() + (zz - xx) * u * u.transpose()) * stretch.transpose();
    // the remainder may be a thousandth of the ellipsoid, to which the accuracy refers
    const double share = 4 / (volume + 1e-9);
    EXPECT_NEAR(found.volume / (volume * semi.prod()), 1, quadrature * share) << d;
    EXPECT_LT((found.centre - centre - stretch * (mean * u)).norm() / 80, quadrature * share) << d;
    EXPECT_LT((found.covariance - covariance).norm() / covariance.norm(), 1e-6) << d;  // (centre / size)^2
  }
}

TEST(EllipticStack, TwoSidesOfACutAddUpToTheWhole) {
  const EllipticStack limb(
      {skewed(), {100, 20, 700}},
      {{-200, 0, 0, 40, 45}, {-120, 3, -2, 50, 52}, {-30, 0, 5, 44, 46}, {60, -4, 0, 60, 50}}, 30, 45);
  const Matrix4d whole = limb.moments();
  for (const double tilt : {0.0, 0.4, 1.2, pi / 2}) {
    // normals from perpendicular to parallel to the axis
    const Vector3d normal = skewed() * Vector3d(std::sin(tilt), 0, std::cos(tilt));
    const HalfSpace half{normal, normal.dot(limb.frame().point({4, 0, -60}))};
    const Matrix4d sum = limb.cut(half).moments() + limb.cut(half.other_side()).moments();
    EXPECT_LT((sum - whole).cwiseAbs().maxCoeff(), 1e-9 * whole.cwiseAbs().maxCoeff()) << tilt;
  }
}

TEST(EllipticStack, HollowedMovedScaledAndMirrored) {
  const EllipticStack outer = ellipsoid({0, 0, 0}, {40, 50, 60}), inner = ellipsoid({0, 0, 0}, {30, 35, 20});
  const HalfSpace half{Vector3d(0.6, 0, 0.8), 5};
  const EllipticStack shell = outer.hollowed(inner).cut(half);
  const Matrix4d expected = outer.cut(half).moments() - inner.cut(half).moments();
  EXPECT_LT((shell.moments() - expected).norm(), 1e-9 * expected.norm());

  Matrix3d mirror = skewed();
  mirror.col(0) *= -1;
  const Frame frame{mirror, {7, -300, 44}};
  Matrix4d place = Matrix4d::Identity();
  place.topLeftCorner<3, 3>() = 1.7 * mirror;
  place.topRightCorner<3, 1>() = 1.7 * frame.origin;
  const Matrix4d moved = shell.moved(frame).scaled(1.7).moments();
  const Matrix4d image = place * expected * place.transpose() * std::pow(1.7, 3);
  EXPECT_LT((moved - image).norm(), 1e-9 * image.norm());
  const Vector3d in(-3, 4, -50), hole(1, 1, 1), beyond(10, 2, 12);
  EXPECT_TRUE(shell.holds(in) && !shell.holds(hole) && !shell.holds(beyond));
  EXPECT_TRUE(shell.moved(frame).holds(frame.point(in)));
  EXPECT_FALSE(shell.moved(frame).holds(frame.point(hole)));
  EXPECT_FALSE(shell.moved(frame).holds(frame.point(beyond)));
}

// A shrunk stack lies inside the original at that depth, measured along the axes.
TEST(EllipticStack, ShrunkStackLiesWithin) {
  const Shape found(ellipsoid({3, 4, 5}, {40, 50, 60}).shrunk(6).moments());
  EXPECT_NEAR(found.volume, 4 * pi / 3 * 34 * 44 * 54, 1e-9 * found.volume);
  const EllipticStack limb({}, {{-90, 0, 0, 40, 45}, {0, 2, 3, 30, 31}, {80, 0, 0, 35, 30}}, 0, 20);
  const EllipticStack core = limb.shrunk(4);
  EXPECT_EQ(core.low(), -90);  // flat ends stay
  EXPECT_EQ(core.high(), 76);
  for (double h = -90; h < 76; h += 3.7) {
    EXPECT_LE(core.section(h).a, limb.section(h).a - 4 + 1e-12);
    EXPECT_LE(core.section(h).b, limb.section(h).b - 4 + 1e-12);
  }
}

// Sections match the given ones and do not overshoot between them.
TEST(EllipticStack, SectionsAreMonotoneThroughTheirKnots) {
  const std::vector<Section> knots{
      {0, 0, 0, 40, 20}, {10, 0, 5, 40, 30}, {30, 0, 5, 70, 25}, {35, 0, 0, 60, 25}};
  const EllipticStack stack({}, knots);
  for (std::size_t i = 0; i + 1 < knots.size(); ++i) {
    EXPECT_NEAR(stack.section(knots[i].height).a, knots[i].a, 1e-12);
    for (double t = 0; t <= 1; t += 0.05) {
      const Ellipse e = stack.section(knots[i].height + t * (knots[i + 1].height - knots[i].height));
      EXPECT_GE(e.a, std::min(knots[i].a, knots[i + 1].a) - 1e-12);
      EXPECT_LE(e.a, std::max(knots[i].a, knots[i + 1].a) + 1e-12);
      EXPECT_GE(e.b, std::min(knots[i].b, knots[i + 1].b) - 1e-12);
      EXPECT_LE(e.b, std::max(knots[i].b, knots[i + 1].b) + 1e-12);
    }
  }
}

}  // namespace
}  // namespace borelli::elliptic_stack_test
