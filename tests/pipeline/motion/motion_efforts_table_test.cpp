// Inverse dynamics of recordings with known answers.
#include "pipeline/motion/motion_efforts_table.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "dynamics/formats/scene_file.hpp"

namespace borelli::test::motion_efforts_table_test {
namespace {

template <class T>
T need(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message());
  return std::move(*result);
}

/// A point of 2 kg, 0.7 m below a hinge, moment of inertia 0.3 kg m^2 about its centre.
constexpr const char* pendulum_text = R"(
name = "pendulum"
gravity = [0, 0, -9.81]
[[solid]]
name = "bob"
parent = "world"
joint = {rotation = "y", name = "swing"}
mass = 2
centre = [0, 0, -0.7]
tensor = [0.3, 0.3, 0.3]
)";

System pendulum() { return need(compile(need(parse_scene(pendulum_text, "pendulum.toml")))); }

MotionTable swing(int n, double step) {
  MotionTable table{"swing", {"swing"}, {}, Eigen::MatrixXd(n, 1), true};
  for (int i = 0; i < n; ++i) {
    table.times.push_back(i * step);
    table.values(i, 0) = 180 / std::numbers::pi * 0.8 * std::sin(3 * i * step);
  }
  return table;
}

TEST(MotionEffortsTable, DrivenPendulumHasItsClosedForm) {
  const System system = pendulum();
  const TablePositions motion = need(positions_in(system, swing(2001, 0.001)));
  EXPECT_TRUE(motion.warnings.empty());
  const RecordedEfforts efforts = need(efforts_of(system, motion.positions, {}, {}));
  const double inertia = 0.3 + 2 * 0.7 * 0.7;
  // N m. Rounded positions give second derivatives over steps of 1 ms an error of about 10 * 2.2e-16 / (1
  // ms)^2 * inertia = 2.8e-9 (measured: 2.7e-9). Four times that allows for other libraries.
  const double rounding = 1.1e-8;
  for (std::size_t i = 0; i < efforts.times.size(); ++i) {
    const double t = efforts.times[i];
    if (t < 0.3 || t > 1.7) continue;  // natural ends of the spline
    const double q = 0.8 * std::sin(3 * t);
    const double torque = -9 * inertia * q + 2 * 9.81 * 0.7 * std::sin(q);
    EXPECT_NEAR(efforts.efforts(Eigen::Index(i), 0), torque, rounding);
    EXPECT_NEAR(efforts.powers(Eigen::Index(i), 0), torque * 2.4 * std::cos(3 * t), 2.4 * rounding);
  }
}

TEST(MotionEffortsTable, LoadsInTheBodysFrameTurnWithIt) {
  const System system = pendulum();
  const TablePositions motion = need(positions_in(system, swing(201, 0.01)));
  const auto load = [&](const char* axes) {
    MeasuredForce push{
        "push", {0, 2}, Eigen::Matrix3Xd(3, 2), Eigen::Matrix3Xd(3, 2), Eigen::Matrix3Xd::Zero(3, 2)};
    push.force.colwise() = Eigen::Vector3d(5, 0, 0);
    push.point.colwise() = Eigen::Vector3d(0, 0, -1);
    return ExternalLoad{"bob", axes, "bob", push};
  };
  const Rows without = need(efforts_of(system, motion.positions, {}, {})).efforts;
  const Rows along = need(efforts_of(system, motion.positions, {load("bob")}, {})).efforts;
  const RecordedEfforts fixed = need(efforts_of(system, motion.positions, {load("ground")}, {}));
  for (Eigen::Index i = 0; i < without.rows(); ++i) {
    // about +y, a push along the body's x at z = -1 turns by -5 N m
    EXPECT_NEAR(along(i, 0) - without(i, 0), 5, 1e-12);
    EXPECT_NEAR(fixed.efforts(i, 0) - without(i, 0), 5 * std::cos(fixed.q(i, 0)), 1e-9);
  }
}

TEST(MotionEffortsTable, NamesEffortsOfWrongUnits) {
  const System system = pendulum();
  MotionTable table = swing(201, 0.01);
  EXPECT_TRUE(need(efforts_of(system, need(positions_in(system, table)).positions, {}, {})).warnings.empty());
  table.in_degrees = false;  // degrees that are said to be radians
  const auto warnings =
      need(efforts_of(system, need(positions_in(system, table)).positions, {}, {})).warnings;
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_TRUE(warnings[0].starts_with("the moment of 'swing' reaches ")) << warnings[0];
  // a push of 20 N at a point in mm
  MeasuredForce push{
      "push", {0, 2}, Eigen::Matrix3Xd(3, 2), Eigen::Matrix3Xd(3, 2), Eigen::Matrix3Xd::Zero(3, 2)};
  push.force.colwise() = Eigen::Vector3d(20, 0, 0);
  push.point.colwise() = Eigen::Vector3d(0, 0, -1000);
  const auto far = need(efforts_of(system, need(positions_in(system, swing(201, 0.01))).positions,
                                   {ExternalLoad{"bob", "ground", "ground", push}}, {}))
                       .warnings;
  ASSERT_EQ(far.size(), 1u);
  EXPECT_TRUE(far[0].starts_with("the moment of 'swing' reaches ")) << far[0];
}

TEST(MotionEffortsTable, NamesMissingRows) {
  const System system = pendulum();
  RecordedPositions positions = need(positions_in(system, swing(201, 0.01))).positions;
  constexpr int from = 80, missing = 40;
  positions.times.erase(positions.times.begin() + from, positions.times.begin() + from + missing);
  Rows kept(201 - missing, 1);
  kept << positions.q.topRows(from), positions.q.bottomRows(201 - from - missing);
  positions.q = kept;
  const auto warnings = need(efforts_of(system, positions, {}, {})).warnings;
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_TRUE(warnings[0].starts_with("rows are missing between t = 0.79 s and 1.2 s, 41 of the usual steps"))
      << warnings[0];
}

// A free body with a force that nothing explains: the residuals are that force and its moment.
TEST(MotionEffortsTable, JudgesResidualForceAndMoment) {
  const System system = need(compile(need(parse_scene(R"(
gravity = [0, 0, -10]
[[solid]]
name = "body"
joint = [{translation = "x", name = "x"}, {translation = "y", name = "y"}, {translation = "z", name = "z", value = 1},
  {rotation = "y", name = "pitch"}]
mass = 1
tensor = [1, 1, 1]
)",
                                                      "body.toml"))));
  RecordedPositions still;
  still.q = system.initial.q.transpose().replicate(21, 1);
  for (int i = 0; i < 21; ++i) still.times.push_back(0.01 * i);
  const auto warnings = [&](double force, double x) {
    MeasuredForce push{
        "push", {0, 2}, Eigen::Matrix3Xd(3, 2), Eigen::Matrix3Xd(3, 2), Eigen::Matrix3Xd::Zero(3, 2)};
    push.force.colwise() = Eigen::Vector3d(0, 0, force);
    push.point.colwise() = Eigen::Vector3d(x, 0, 0);
    return need(efforts_of(system, still, {ExternalLoad{"body", "ground", "ground", push}}, {})).warnings;
  };
  EXPECT_TRUE(warnings(10, 0.009).empty());
  ASSERT_EQ(warnings(10, 0.02).size(), 1u);  // 0.2 N m of 10 N times 1 m
  EXPECT_TRUE(warnings(10, 0.02)[0].starts_with("the largest residual moment at the root, 0 N m, is 2 % of "))
      << warnings(10, 0.02)[0];
  EXPECT_TRUE(warnings(11, 0)[0].starts_with("the largest residual force at the root, 1 N, is 9 % of "))
      << warnings(11, 0)[0];
}

// The table has no column for r = 0.1 + 5 x, so r is computed from x. Its moment is I r'' = 5 I x''.
TEST(MotionEffortsTable, ComputesCoupledCoordinatesWithoutColumns) {
  const System system = need(compile(need(parse_scene(R"(
gravity = [0, 0, 0]
[[solid]]
name = "rack"
joint = {translation = "z", name = "x"}
mass = 2
tensor = [1, 1, 1]
[[solid]]
name = "gear"
joint = {rotation = "z", name = "r", coupled = {to = "x", function = [0.1, 5]}}
mass = 1
tensor = [2, 2, 3]
)",
                                                      "gear.toml"))));
  MotionTable table{"x", {"x"}, {}, Eigen::MatrixXd(401, 1), false};
  for (int i = 0; i < 401; ++i) {
    table.times.push_back(0.005 * i);
    table.values(i, 0) = 0.2 * std::sin(3 * 0.005 * i);
  }
  const TablePositions motion = need(positions_in(system, table));
  EXPECT_TRUE(motion.warnings.empty()) << motion.warnings[0];
  const RecordedEfforts efforts = need(efforts_of(system, motion.positions, {}, {}));
  const Eigen::Index middle = 200;
  const double acceleration = -9 * 0.2 * std::sin(3.);
  for (const CoordinateInfo& c : system.coordinates)
    EXPECT_NEAR(efforts.efforts(middle, c.v_index), c.name == "r" ? 3 * 5 * acceleration : 2 * acceleration,
                1e-5);
  EXPECT_TRUE(efforts.residuals.empty());  // the world carries both
}

TEST(MotionEffortsTable, ColumnsMayBePathsOfStates) {
  const System system = pendulum();
  MotionTable table = swing(5, 0.1);
  table.columns[0] = "/jointset/hinge/swing/value";
  EXPECT_TRUE(positions_in(system, table));
  table.columns[0] = "sway";
  EXPECT_FALSE(positions_in(system, table));
  table.columns[0] = "swing";
  table.values(3, 0) = std::nan("");
  EXPECT_FALSE(positions_in(system, table));
}

TEST(MotionEffortsTable, NamesABodyThatTheModelDoesNotHave) {
  const System system = pendulum();
  const TablePositions motion = need(positions_in(system, swing(21, 0.1)));
  const ExternalLoad load{"foot", "ground", "ground", {}};
  const auto refused = efforts_of(system, motion.positions, {load}, {});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().what.find("foot"), std::string::npos);
}

}  // namespace
}  // namespace borelli::test::motion_efforts_table_test
