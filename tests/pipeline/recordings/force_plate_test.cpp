#include "pipeline/recordings/force_plate.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "tests/pipeline/recordings/c3d_trial.hpp"

namespace borelli::test::force_plate_test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// A plate of 0.6 m by 0.4 m in the floor (z up), turned by 25 degrees, its z axis into the ground.
ForcePlate turned_plate(int type) {
  ForcePlate plate;
  plate.name = "force plate 1";
  plate.type = type;
  const Matrix3d R_WP =
      (Eigen::AngleAxisd(0.4363, Vector3d::UnitZ()) * Eigen::AngleAxisd(M_PI, Vector3d::UnitX()))
          .toRotationMatrix();
  const Vector3d centre(0.3, -0.2, 0.01);
  const double x[] = {0.3, -0.3, -0.3, 0.3}, y[] = {0.2, 0.2, -0.2, -0.2};
  for (int i = 0; i < 4; ++i) plate.corners.col(i) = centre + R_WP * Vector3d(x[i], y[i], 0);
  return plate;
}

struct Wrench {
  Vector3d force, point, free_moment;  // in laboratory axes: the ground's action on the body
};

// A foot on the plate: 700 N up, friction, and a twist about the normal.
Wrench foot() { return {{35, -60, 700}, {0.35, -0.12, 0.01}, {0, 0, 4.5}}; }

// The channels of types 1, 2 and 4 that this foot gives: forces, and moments about O, the plate's origin.
Eigen::VectorXd channels_of(const ForcePlate& plate, const Wrench& wrench) {
  const Matrix3d R_WP = plate_axes(plate).value();
  const Vector3d force = R_WP.transpose() * wrench.force;
  const Vector3d from_centre = R_WP.transpose() * (wrench.point - plate.corners.rowwise().mean());
  const Vector3d free_moment = R_WP.transpose() * wrench.free_moment;
  Eigen::VectorXd out(6);
  if (plate.type == 1)
    out << force, from_centre.x(), from_centre.y(), free_moment.z();
  else
    out << force, (plate.origin + from_centre).cross(force) + free_moment;
  return out;
}

void expect_foot(const MeasuredForce& force, const Wrench& expected, int sample = 0) {
  EXPECT_LT((force.force.col(sample) - expected.force).norm(), 1e-9);
  EXPECT_LT((force.point.col(sample) - expected.point).norm(), 1e-12);
  EXPECT_LT((force.moment.col(sample) - expected.free_moment).norm(), 1e-9);
}

TEST(ForcePlate, SixChannelsGiveForcePointAndFreeMoment) {
  for (const int type : {1, 2, 4}) {
    ForcePlate plate = turned_plate(type);
    plate.origin = Vector3d(0.002, -0.001, -0.04);  // the surface is 4 cm above O, against z
    plate.channels = channels_of(plate, foot());
    std::vector<std::string> warnings;
    const MeasuredForce force = measured_force(plate, {0.5}, Vector3d::UnitZ(), warnings).value();
    expect_foot(force, foot());
    EXPECT_EQ(force.times, std::vector<double>{0.5});
    EXPECT_GT(force.force(2, 0), 0) << "the ground pushes the body up";
    EXPECT_TRUE(warnings.empty()) << warnings[0];
  }
}

// Four sensors with separate forces: the result must be the sum of the forces and of their moments.
TEST(ForcePlate, EightChannelsOfFourSensorsKeepTheWrench) {
  ForcePlate plate = turned_plate(3);
  const double a = 0.21, b = 0.13, depth = 0.05;
  plate.origin = Vector3d(a, b, -depth);
  const Vector3d sensors[] = {{a, b, depth}, {-a, b, depth}, {-a, -b, depth}, {a, -b, depth}};
  const Vector3d felt[] = {{10, -3, -150}, {-4, 8, -260}, {12, 5, -90}, {-7, -2, -210}};
  Vector3d sum = Vector3d::Zero(), moment = Vector3d::Zero();
  for (int i = 0; i < 4; ++i) sum += felt[i], moment += sensors[i].cross(felt[i]);
  // sensor pairs share a channel only if their arm is equal: x by y, y by x
  plate.channels.resize(8, 1);
  plate.channels << felt[0].x() + felt[1].x(), felt[2].x() + felt[3].x(), felt[0].y() + felt[3].y(),
      felt[1].y() + felt[2].y(), felt[0].z(), felt[1].z(), felt[2].z(), felt[3].z();
  std::vector<std::string> warnings;
  const MeasuredForce out = measured_force(plate, {0}, Vector3d::UnitZ(), warnings).value();
  const Matrix3d R_WP = plate_axes(plate).value();
  const Vector3d centre = plate.corners.rowwise().mean();
  const Vector3d force = out.force.col(0), point = out.point.col(0), free_moment = out.moment.col(0);
  EXPECT_LT((force - R_WP * sum).norm(), 1e-9);
  EXPECT_LT(((point - centre).cross(force) + free_moment - R_WP * moment).norm(), 1e-9);
  EXPECT_LT(std::abs((point - centre).dot(R_WP.col(2))), 1e-12) << "the point lies on the surface";
  EXPECT_LT(free_moment.cross(R_WP.col(2)).norm(), 1e-9) << "the free moment is about the normal";
  EXPECT_TRUE(warnings.empty());

  plate.origin.z() = depth;  // the depth without its sign
  expect_foot(measured_force(plate, {0}, Vector3d::UnitZ(), warnings).value(), {force, point, free_moment});
  EXPECT_TRUE(test::has_warning(warnings, "wrong sign"));

  plate.origin = Vector3d(0, 0, -depth);
  const MeasuredForce nowhere = measured_force(plate, {0}, Vector3d::UnitZ(), warnings).value();
  EXPECT_LT((nowhere.force - out.force).norm(), 1e-9);
  EXPECT_TRUE(std::isnan(nowhere.point(0, 0)) && std::isnan(nowhere.moment(2, 0)));
  EXPECT_TRUE(test::has_warning(warnings, "has no sensor positions in ORIGIN"));
}

TEST(ForcePlate, ReversesAnOriginOfTheWrongSign) {
  ForcePlate plate = turned_plate(2);
  plate.origin = Vector3d(0.002, -0.001, -0.04);
  plate.channels = channels_of(plate, foot());
  plate.origin = -plate.origin;
  std::vector<std::string> warnings;
  expect_foot(measured_force(plate, {0}, Vector3d::UnitZ(), warnings).value(), foot());
  expect_foot(measured_force(plate, {0}, std::nullopt, warnings).value(), foot());
  ASSERT_EQ(warnings.size(), 2);
  EXPECT_NE(warnings[0].find("ORIGIN of force plate 1 has the wrong sign"), std::string::npos);
}

TEST(ForcePlate, ConvertsTheActionOnThePlateToTheGroundReaction) {
  for (const int type : {1, 2}) {
    ForcePlate plate = turned_plate(type);
    plate.channels = -channels_of(plate, foot());
    if (type == 1) plate.channels.middleRows(3, 2) *= -1;  // a point is not negated
    std::vector<std::string> warnings;
    expect_foot(measured_force(plate, {0}, Vector3d::UnitZ(), warnings).value(), foot());
    EXPECT_TRUE(test::has_warning(warnings, "the body's force on the plate"));
  }
}

TEST(ForcePlate, PlateWhoseAxisPointsUpIsReadByItsCorners) {
  ForcePlate plate = turned_plate(2);
  plate.corners.col(1).swap(plate.corners.col(3));  // swaps x and y, so z points up
  plate.origin = Vector3d(0, 0, 0.03);
  plate.channels = channels_of(plate, foot());
  std::vector<std::string> warnings;
  expect_foot(measured_force(plate, {0}, Vector3d::UnitZ(), warnings).value(), foot());
  EXPECT_TRUE(warnings.empty());
}

TEST(ForcePlate, PointAndMomentAreNaNBelowTwentyNewtons) {
  ForcePlate plate = turned_plate(2);
  plate.channels.resize(6, 4);
  for (int i = 0; i < 4; ++i) {
    Wrench wrench = foot();
    wrench.force *= (i == 0 ? 19.9 : i == 1 ? 20.1 : i == 2 ? -30 : 0) / 700;
    plate.channels.col(i) = channels_of(plate, wrench);
  }
  std::vector<std::string> warnings;
  const MeasuredForce out = measured_force(plate, {0, 1, 2, 3}, Vector3d::UnitZ(), warnings).value();
  for (const int i : {0, 2, 3}) EXPECT_TRUE(std::isnan(out.point(0, i)) && std::isnan(out.moment(2, i))) << i;
  EXPECT_NEAR(out.force(2, 0), 19.9, 1e-9);
  EXPECT_LT((out.point.col(1) - foot().point).norm(), 1e-9);
}

TEST(ForcePlate, SubtractsTheBaselineOfAnUnloadedPlate) {
  ForcePlate plate = turned_plate(2);
  const Eigen::VectorXd offset = (Eigen::VectorXd(6) << 5, -7, 12, 0.5, -0.4, 0.3).finished();
  plate.channels.resize(6, 20);
  for (int i = 0; i < 20; ++i)
    plate.channels.col(i) = offset + (i < 10 ? Eigen::VectorXd::Zero(6).eval() : channels_of(plate, foot()));
  plate.unloaded = {2, 9};
  std::vector<std::string> warnings;
  const std::vector<double> times(20, 0);
  const MeasuredForce out = measured_force(plate, times, Vector3d::UnitZ(), warnings).value();
  EXPECT_LT(out.force.col(0).norm(), 1e-9);
  expect_foot(out, foot(), 15);
  EXPECT_TRUE(warnings.empty());

  plate.unloaded = {11, 15};  // someone stands on the plate then
  const MeasuredForce loaded = measured_force(plate, times, Vector3d::UnitZ(), warnings).value();
  EXPECT_NEAR(loaded.force(2, 15), 700 - 12, 1e-9);
  EXPECT_TRUE(test::has_warning(warnings, "carries 688 N"));

  plate.unloaded = {15, 40};  // beyond the recording
  EXPECT_NEAR(measured_force(plate, times, Vector3d::UnitZ(), warnings)->force(2, 15), 700 - 12, 1e-9);
}

TEST(ForcePlate, WallPlatePushesAwayFromTheWall) {
  ForcePlate plate = turned_plate(2);
  const Matrix3d onto_wall = Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitY()).toRotationMatrix();
  plate.corners = onto_wall * plate.corners;  // its z axis now points along -x
  Wrench hand{{80, 5, 12}, onto_wall * foot().point, onto_wall * Vector3d(0, 0, 0.2)};
  plate.channels = channels_of(plate, hand);
  std::vector<std::string> warnings;
  expect_foot(measured_force(plate, {0}, Vector3d::UnitZ(), warnings).value(), hand);
  EXPECT_TRUE(warnings.empty());
}

TEST(ForcePlate, SamplesThatAreNotFiniteStayOutOfThePoint) {
  ForcePlate plate = turned_plate(2);
  plate.channels = channels_of(plate, foot()).replicate(1, 3);
  plate.channels(1, 1) = std::nan("");
  std::vector<std::string> warnings;
  const MeasuredForce out = measured_force(plate, {0, 1, 2}, Vector3d::UnitZ(), warnings).value();
  expect_foot(out, foot(), 2);
  EXPECT_TRUE(std::isnan(out.point(0, 1)));
}

TEST(ForcePlate, RefusesCornersThatAreNoRectangle) {
  const auto refused = [](const ForcePlate& plate, const std::string& words) {
    const auto axes = plate_axes(plate);
    ASSERT_FALSE(axes);
    EXPECT_NE(axes.error().message().find("force plate 1: has "), std::string::npos);
    EXPECT_NE(axes.error().message().find(words), std::string::npos) << axes.error().message();
    std::vector<std::string> warnings;
    EXPECT_FALSE(measured_force(plate, {}, std::nullopt, warnings));
  };
  ForcePlate plate = turned_plate(2);
  plate.channels = Eigen::MatrixXd::Zero(6, 0);
  plate.corners.setZero();
  refused(plate, "0 m and 0 m apart");
  plate = turned_plate(2);
  plate.corners *= 1e6;
  refused(plate, "expected 0.01 to 100 m");
  plate = turned_plate(2);
  plate.corners(0, 2) = std::nan("");
  refused(plate, "apart");
  plate = turned_plate(2);
  plate.corners.col(0) += Vector3d(0.3, 0.1, 0), plate.corners.col(1) += Vector3d(0.3, 0.1, 0);
  refused(plate, "expected a rectangle");
  plate = turned_plate(5);
  std::vector<std::string> warnings;
  EXPECT_EQ(measured_force(plate, {}, std::nullopt, warnings).error().what, "is of type 5, expected 1 to 4");
}

}  // namespace
}  // namespace borelli::test::force_plate_test
