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
