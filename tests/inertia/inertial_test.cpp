#include "inertia/inertial.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace borelli::inertial_test {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;

// A few dozen roundings of numbers of order one.
constexpr double rounding = 1e-14;

Matrix3d symmetric(double xx, double yy, double zz, double xy, double xz, double yz) {
  Matrix3d m;
  m << xx, xy, xz, xy, yy, yz, xz, yz, zz;
  return m;
}

void expect_near(const Inertial& found, const Inertial& expected, double tolerance) {
  EXPECT_NEAR(found.mass, expected.mass, tolerance);
  for (int r = 0; r < 3; ++r) {
    EXPECT_NEAR(found.centre[r], expected.centre[r], tolerance) << "centre " << r;
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(found.tensor(r, c), expected.tensor(r, c), tolerance) << "tensor " << r << c;
  }
}

// The tetrahedron x, y, z >= 0, x + y + z <= 1 of unit density: integral of x^2 is 1/60, of xy 1/120.
const Inertial corner_tetrahedron{1. / 6, Vector3d::Constant(1. / 4),
                                  symmetric(1. / 80, 1. / 80, 1. / 80, 1. / 480, 1. / 480, 1. / 480)};

// The tetrahedron 0 <= x <= y <= z <= 1 of unit density, with its moments integrated by hand about the
// origin: mass 1/6, centre (1, 2, 3)/4; xx 1/60, yy 1/20, zz 1/10, xy 1/40, xz 1/30, yz 1/15.
Inertial kuhn_tetrahedron() {
  Inertial t{1. / 6, Vector3d(1, 2, 3) / 4, Matrix3d::Zero()};
  const Matrix3d about_origin =
      symmetric(1. / 20 + 1. / 10, 1. / 60 + 1. / 10, 1. / 60 + 1. / 20, -1. / 40, -1. / 30, -1. / 15);
  const Vector3d c = t.centre;
  t.tensor = about_origin - t.mass * (c.squaredNorm() * Matrix3d::Identity() - c * c.transpose());
  return t;
}

// The skewed box spanned from the origin by (1, 0, 0), (1/2, 1, 0), (1/4, 1/3, 1), of unit density: with A of
// these columns the second moments about its centre are A A^T / 12.
const Inertial skewed_box{1, Vector3d(7. / 8, 2. / 3, 1. / 2),
                          symmetric(19. / 108, 37. / 192, 349. / 1728, -7. / 144, -1. / 48, -1. / 36)};
// Its half next to the origin, spanned by (1/2, 0, 0) and the other two.
const Inertial skewed_half{1. / 2, Vector3d(5. / 8, 2. / 3, 1. / 2),
                           symmetric(19. / 216, 25. / 384, 241. / 3456, -7. / 288, -1. / 96, -1. / 72)};

struct PointMass {
  double mass;
  Vector3d p;
};

// by definition, in long double
Inertial sum(const std::vector<PointMass>& points) {
  using Vec = Eigen::Matrix<long double, 3, 1>;
  using Mat = Eigen::Matrix<long double, 3, 3>;
  long double mass = 0;
  Vec first = Vec::Zero();
  for (const auto& [m, p] : points) mass += m, first += m * p.cast<long double>();
  const Vec centre = first / mass;
  Mat tensor = Mat::Zero();
  for (const auto& [m, p] : points) {
    const Vec r = p.cast<long double>() - centre;
    tensor += m * (r.squaredNorm() * Mat::Identity() - r * r.transpose());
  }
  return {static_cast<double>(mass), centre.cast<double>(), tensor.cast<double>()};
}

std::vector<PointMass> cloud(unsigned seed, int count) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> mass(0.1, 2), place(-1, 3);
  std::vector<PointMass> points;
  for (int n = 0; n < count; ++n)
    points.push_back({mass(random), {place(random), place(random), place(random)}});
  return points;
}

TEST(Inertial, TranslatedTetrahedronKeepsItsTensor) {
  const Inertial moved = corner_tetrahedron.moved({1, -2, 3});
  expect_near(moved, {1. / 6, Vector3d(5. / 4, -7. / 4, 13. / 4), corner_tetrahedron.tensor}, rounding);
}

TEST(Inertial, TetrahedronHasKnownTensorAboutAPoint) {
  // about the corner: integral of y^2 + z^2 = 1/30, -integral of xy = -1/120
  const Matrix3d corner = corner_tetrahedron.tensor_about(Vector3d::Zero());
  EXPECT_LT(
      (corner - symmetric(1. / 30, 1. / 30, 1. / 30, -1. / 120, -1. / 120, -1. / 120)).cwiseAbs().maxCoeff(),
      rounding);
  // about the point (1, 1, 1): integral of (y-1)^2 + (z-1)^2 = 1/30 - 2/24 - 2/24 + 2/6 = 1/5,
  // -integral of (x-1)(y-1) = -(1/120 - 1/24 - 1/24 + 1/6) = -11/120
  const Matrix3d away = corner_tetrahedron.tensor_about(Vector3d::Ones());
  EXPECT_LT(
      (away - symmetric(1. / 5, 1. / 5, 1. / 5, -11. / 120, -11. / 120, -11. / 120)).cwiseAbs().maxCoeff(),
      rounding);
}

TEST(Inertial, SixTetrahedraAddUpToACube) {
  const Inertial tetrahedron = kuhn_tetrahedron();
  Inertial cube;
  for (const auto& [x, y, z] : {std::array{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}) {
    Matrix3d permutation = Matrix3d::Zero();  // half of these are reflections
    permutation(x, 0) = permutation(y, 1) = permutation(z, 2) = 1;
    cube += tetrahedron.rotated(permutation);
  }
  expect_near(cube, {1, Vector3d::Constant(1. / 2), Matrix3d::Identity() / 6}, rounding);
  EXPECT_LT(
      (cube.tensor_about(Vector3d::Zero()) - symmetric(2. / 3, 2. / 3, 2. / 3, -1. / 4, -1. / 4, -1. / 4))
          .cwiseAbs()
          .maxCoeff(),
      rounding);
}

TEST(Inertial, SkewedBoxSplitsIntoItsHalvesAndMergesAgain) {
  const Inertial other_half = skewed_half.moved({1. / 2, 0, 0});
  expect_near(skewed_box - skewed_half, other_half, rounding);
  expect_near(skewed_box - other_half, skewed_half, rounding);
  expect_near(skewed_half + other_half, skewed_box, rounding);
  expect_near(other_half + skewed_half, skewed_box, rounding);
}

TEST(Inertial, MergesAndSplitsFarFromTheOriginExactly) {
  // 1 km away, products of the centres are 1e6, so merging about the origin would lose 6 of 16 digits. Here
  // only the centres' rounding counts: a few times 1 km * 2^-53 = 1.1e-13 m, times arms of 1 m.
  const Vector3d away(1000, -700, 400);
  const Inertial merged = skewed_half.moved(away) + skewed_half.moved(away + Vector3d(1. / 2, 0, 0));
  expect_near(merged, skewed_box.moved(away), 5e-13);
  expect_near(merged - skewed_half.moved(away), skewed_half.moved(away + Vector3d(1. / 2, 0, 0)), 1e-12);
}

TEST(Inertial, MergeEqualsTheSumOfPointMasses) {
  const auto a = cloud(1, 40), b = cloud(2, 7);
  auto both = a;
  both.insert(both.end(), b.begin(), b.end());
  // tensors of about 200 kg m^2, about 50 roundings of 2e-16 each
  expect_near(sum(a) + sum(b), sum(both), 2e-12);
  expect_near(sum(both) - sum(b), sum(a), 2e-12);
}

TEST(Inertial, EmptySolidIsNeutral) {
  expect_near(Inertial{} + skewed_box, skewed_box, 0);
  expect_near(skewed_box + Inertial{}, skewed_box, 0);
  expect_near(skewed_box - Inertial{}, skewed_box, 0);
  expect_near(skewed_box - skewed_box, Inertial{}, 0);
  expect_near(Inertial{} + Inertial{}, Inertial{}, 0);
}

TEST(Inertial, AnotherFrameEqualsTheSumOfPointsThere) {
  const auto points = cloud(3, 25);
  const Matrix3d R_GF = AngleAxisd(1.1, Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  const Vector3d p_GF(0.3, -4, 2);
  auto there = points;
  for (auto& point : there) point.p = R_GF * point.p + p_GF;
  const Inertial in_F = sum(points), in_G = in_F.expressed_in(R_GF, p_GF);
  expect_near(in_G, sum(there), 2e-12);
  expect_near(in_G.expressed_in(R_GF.transpose(), -R_GF.transpose() * p_GF), in_F, 2e-12);
}

TEST(Inertial, RotationKeepsInvariants) {
  const double trace = 19. / 108 + 37. / 192 + 349. / 1728;
  // the sum of the principal 2x2 minors, from the same fractions
  const double minors = 19. / 108 * 37. / 192 + 19. / 108 * 349. / 1728 + 37. / 192 * 349. / 1728 -
                        49. / 20736 - 1. / 2304 - 1. / 1296;
  const Vector3d moments = skewed_box.principal().moments;
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  for (int n = 0; n < 20; ++n) {
    const Eigen::Quaterniond q(normal(random), normal(random), normal(random), normal(random));
    const Inertial turned = skewed_box.rotated(q.normalized().toRotationMatrix());
    const Matrix3d& I = turned.tensor;
    EXPECT_NEAR(I.trace(), trace, rounding);
    EXPECT_NEAR(0.5 * (I.trace() * I.trace() - (I * I).trace()), minors, rounding);
    EXPECT_LT((turned.principal().moments - moments).cwiseAbs().maxCoeff(), rounding);
    EXPECT_NEAR(turned.centre.norm(), skewed_box.centre.norm(), rounding);
  }
}

TEST(Inertial, PrincipalAxesAreSortedAndRightHanded) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (int n = 0; n < 20; ++n) {
    const Eigen::Quaterniond q(normal(random), normal(random), normal(random), normal(random));
    const Inertial turned = skewed_box.rotated(q.normalized().toRotationMatrix());
    const auto [moments, axes] = turned.principal();
    EXPECT_LE(moments[0], moments[1]);
    EXPECT_LE(moments[1], moments[2]);
    EXPECT_NEAR(axes.determinant(), 1, rounding);
    EXPECT_LT((axes * axes.transpose() - Matrix3d::Identity()).cwiseAbs().maxCoeff(), rounding);
    EXPECT_LT((axes * moments.asDiagonal() * axes.transpose() - turned.tensor).cwiseAbs().maxCoeff(),
              rounding);
  }
}

TEST(Inertial, RotatedBoxHasKnownPrincipalMoments) {
  // box of 3 x 4 x 12 m and 24 kg: moments 24/12 (b^2 + c^2) = 2 * (25, 153, 160)
  const Matrix3d R = AngleAxisd(0.7, Vector3d(2, 1, -1).normalized()).toRotationMatrix();
  const Inertial box = Inertial{24, {1, 2, 3}, Vector3d(320, 306, 50).asDiagonal()}.rotated(R);
  // a few roundings of 320 * 2e-16
  EXPECT_LT((box.principal().moments - Vector3d(50, 306, 320)).cwiseAbs().maxCoeff(), 1e-12);
  const Vector3d radii = box.radii_of_gyration(R);
  EXPECT_NEAR(radii[0], std::sqrt(160. / 12), rounding);
  EXPECT_NEAR(radii[1], std::sqrt(153. / 12), rounding);
  EXPECT_NEAR(radii[2], std::sqrt(25. / 12), rounding);
}

TEST(Inertial, AcceptsPhysicalBodies) {
  EXPECT_TRUE(check_physical(skewed_box, "box"));
  EXPECT_TRUE(check_physical(corner_tetrahedron, "tetrahedron"));
  // a flat plate lies on the border of the triangle inequality
  EXPECT_TRUE(
      check_physical({1, Vector3d::Zero(), Vector3d(1. / 12, 1. / 3, 5. / 12).asDiagonal()}, "plate"));
}

// the error must name the body and the wrong numbers
void expect_refused(const Inertial& inertial, std::initializer_list<const char*> words) {
  const auto answer = check_physical(inertial, "thigh_left");
  ASSERT_FALSE(answer);
  for (const char* word : words)
    EXPECT_NE(answer.error().message().find(word), std::string::npos)
        << word << " in " << answer.error().message();
}

TEST(Inertial, RefusesImpossibleBodiesWithTheirNumbers) {
  expect_refused({-2, Vector3d::Zero(), Matrix3d::Identity()}, {"thigh_left", "-2 kg"});
  expect_refused({0, Vector3d::Zero(), Matrix3d::Identity()}, {"0 kg"});
  expect_refused({1, Vector3d::Zero(), Vector3d(1, 2, 3.5).asDiagonal()}, {"triangle", "3.5", "1 + 2 = 3 "});
  expect_refused({1, Vector3d::Zero(), symmetric(1, 1, 1, 2, 0, 0)}, {"positive definite", "-1,"});
  expect_refused({1, Vector3d(NAN, 0, 0), Matrix3d::Identity()}, {"finite"});
  Matrix3d skew = Matrix3d::Identity();
  skew(0, 1) = 0.25;
  expect_refused({1, Vector3d::Zero(), skew}, {"symmetric", "Ixy 0.25 and Iyx 0"});
  // the triangle inequality concerns principal moments; diagonal entries may satisfy it while those do not
  const Matrix3d R = AngleAxisd(std::numbers::pi / 4, Vector3d::UnitX()).toRotationMatrix();
  expect_refused(Inertial{1, Vector3d::Zero(), Vector3d(1, 2, 3.5).asDiagonal()}.rotated(R),
                 {"triangle", "3.5"});
}

TEST(Inertial, AcceptsBarsAndPointsOnlyIfAllowed) {
  const Inertial bar{1, Vector3d::Zero(), Vector3d(0, 1. / 12, 1. / 12).asDiagonal()};
  const Inertial point{1, Vector3d::Ones(), Matrix3d::Zero()};
  for (const Inertial& body : {bar, point}) {
    EXPECT_FALSE(check_physical(body, "bar or point"));
    EXPECT_TRUE(check_physical(body, "bar or point", Extent::may_be_bar_or_point));
  }
  EXPECT_FALSE(check_physical({1, Vector3d::Zero(), Vector3d(-1e-3, 1, 1).asDiagonal()}, "bar",
                              Extent::may_be_bar_or_point));
}

}  // namespace
}  // namespace borelli::inertial_test
