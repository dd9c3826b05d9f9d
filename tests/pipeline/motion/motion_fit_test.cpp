// Fits of whole recordings that were made from known motions.
#include "pipeline/motion/motion_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "dynamics/equations/evaluate.hpp"
#include "dynamics/formats/scene_file.hpp"

namespace borelli::test::motion_fit_test {
namespace {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;

template <class T>
T need(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message());
  return std::move(*result);
}

/// A free trunk with a hinged arm.
constexpr const char* body_text = R"(
name = "body"
gravity = [0, 0, -9.81]
[[solid]]
name = "trunk"
parent = "world"
joint = [{translation = "x", name = "x"}, {translation = "y", name = "y"}, {translation = "z", name = "z"}, {ball = true, name = "turn"}]
mass = 30
centre = [0, 0, 0]
tensor = [1, 1, 1]
[[solid]]
name = "arm"
parent = "trunk"
joint = [{fixed = [0.2, 0, 0.4]}, {rotation = "y", name = "elbow", range = [-0.5, 2]}]
mass = 3
centre = [0.2, 0, 0]
tensor = [0.1, 0.1, 0.1]
[[marker]]
name = "front"
solid = "trunk"
point = [0.1, 0, 0.1]
[[marker]]
name = "left"
solid = "trunk"
point = [0, 0.2, -0.2]
[[marker]]
name = "top"
solid = "trunk"
point = [0, 0.05, 0.5]
[[marker]]
name = "hand"
solid = "arm"
point = [0.5, 0.1, 0]
[[marker]]
name = "not recorded"
solid = "arm"
point = [0.1, 0.1, 0]
)";

struct Body {
  Scene scene = need(parse_scene(body_text, "body.toml"));
  System system = need(compile(scene));
  int index(const std::string& name) const {
    for (const CoordinateInfo& c : system.coordinates)
      if (c.name == name) return c.q_index;
    throw std::runtime_error(name);
  }
  /// The recording of a motion of the arm, the trunk at a heading.
  MarkerMotion recording(double heading) const {
    MarkerMotion out;
    out.names = {"stick", "hand", "top", "left", "front"};
    State state = system.initial;
    for (int i = 0; i < 20; ++i) {
      state.q[index("x")] = 0.05 * i;
      state.q.segment<4>(index("turn")) << std::cos(heading / 2), 0, 0, std::sin(heading / 2);
      state.q[index("elbow")] = elbow(i);
      out.times.push_back(0.1 * i);
      Matrix3Xd frame = Matrix3Xd::Zero(3, 5);
      for (Eigen::Index m = 1; m < 5; ++m)
        for (const Marker& marker : scene.markers)
          if (marker.name == out.names[std::size_t(m)])
            frame.col(m) = need(point_motion(system, state, marker.at)).position;
      out.frames.push_back(frame);
    }
    return out;
  }
  static double elbow(int i) { return 0.5 + 0.4 * std::sin(0.3 * i); }
};

bool tells(const MotionFit& fit, const std::string& what) {
  for (const std::string& warning : fit.warnings)
    if (warning.find(what) != std::string::npos) return true;
  return false;
}

TEST(MotionFit, FollowsTheSharedMarkers) {
  const Body body;
  MarkerMotion recording = body.recording(0.3);
  recording.frames[4].col(1).setConstant(std::numeric_limits<double>::quiet_NaN());  // the hand is not seen
  recording.frames[7].setConstant(std::numeric_limits<double>::quiet_NaN());
  const MotionFit fit = need(fit_motion(body.scene, body.system, recording, {}));
  EXPECT_EQ(fit.markers, (std::vector<std::string>{"hand", "top", "left", "front"}));
  EXPECT_TRUE(tells(fit, "stick"));
  EXPECT_TRUE(tells(fit, "not recorded"));
  EXPECT_TRUE(tells(fit, "1 of 20 frames"));
  ASSERT_EQ(fit.times.size(), 19u);
  EXPECT_LT(fit.rms(), 1e-8);
  for (std::size_t f = 0; f < fit.times.size(); ++f) {
    const int frame = int(std::lround(fit.times[f] / 0.1));
    if (frame == 4) continue;
    EXPECT_NEAR(fit.q(Eigen::Index(f), body.index("elbow")), Body::elbow(frame), 1e-7);
    EXPECT_NEAR(fit.q(Eigen::Index(f), body.index("x")), 0.05 * frame, 1e-8);
  }
  EXPECT_TRUE(std::isnan(fit.errors(4, 0)));
  const MotionTable table = table_of(body.system, fit);
  const auto column = std::find(table.columns.begin(), table.columns.end(), "elbow") - table.columns.begin();
  EXPECT_NEAR(table.values(0, column), Body::elbow(0) * 180 / std::numbers::pi, 1e-5);
}

TEST(MotionFit, SaysThatMarkersLieTooFar) {
  const Body body;
  const MarkerMotion right = body.recording(0.3);
  EXPECT_EQ(misfit(need(fit_motion(body.scene, body.system, right, {})).rms(), right), "");
  const auto changed = [&](const Eigen::Matrix3d& by) {
    MarkerMotion out = right;
    for (Matrix3Xd& frame : out.frames) frame = by * frame;
    return out;
  };
  // in cm, with another axis upwards, mirrored
  for (const Eigen::Matrix3d& by :
       {Eigen::Matrix3d(100 * Eigen::Matrix3d::Identity()),
        Eigen::Matrix3d(Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitX()).matrix() *
                        Eigen::Vector3d(1, -1, 1).asDiagonal())}) {
    const MarkerMotion wrong = changed(by);
    const std::string said = misfit(need(fit_motion(body.scene, body.system, wrong, {})).rms(), wrong);
    EXPECT_TRUE(said.starts_with("the markers lie ")) << said;
  }
}

TEST(MotionFit, FindsABodyThatFacesTheOtherWay) {
  const Body body;
  for (double heading : {std::numbers::pi, -1.7, 2.6}) {
    const MotionFit fit = need(fit_motion(body.scene, body.system, body.recording(heading), {}));
    EXPECT_LT(fit.rms(), 1e-8) << heading;
  }
}

TEST(MotionFit, TurnsARecordingWhoseYAxisPointsUp) {
  const Body body;
  MarkerMotion recording = body.recording(0.3);
  recording.up = Vector3d::UnitY();
  Eigen::Matrix3d to_y_up;
  to_y_up << 1, 0, 0, 0, 0, 1, 0, -1, 0;  // z becomes y
  for (Matrix3Xd& frame : recording.frames) frame = to_y_up * frame;
  const MotionFit fit = need(fit_motion(body.scene, body.system, recording, {}));
  EXPECT_LT(fit.rms(), 1e-8);
  EXPECT_NEAR(fit.q(10, body.index("x")), 0.5, 1e-8);
  EXPECT_NEAR(fit.q(10, body.index("z")), 0, 1e-8);
}

TEST(MotionFit, SaysThatACoordinateIsAtItsRange) {
  Body body;
  for (Solid& solid : body.scene.solids)
    for (Switch& one : solid.switches)
      if (one.coordinate == "elbow") one.ranges = {{-0.5, 0.6}};
  body.system = need(compile(body.scene));
  const MotionFit fit = need(fit_motion(body.scene, body.system, body.recording(0.3), {}));
  EXPECT_TRUE(tells(fit, "elbow is at an end of its range"));
  EXPECT_LE(fit.q.col(body.index("elbow")).maxCoeff(), 0.6 + 1e-12);
}

TEST(MotionFit, RefusesARecordingOfAnotherModel) {
  const Body body;
  MarkerMotion recording = body.recording(0.3);
  recording.names = {"a", "b", "c", "d", "e"};
  EXPECT_FALSE(fit_motion(body.scene, body.system, recording, {}));
  MotionFitRequest later;
  later.time_range = {50, 60};
  EXPECT_FALSE(fit_motion(body.scene, body.system, body.recording(0.3), later));
}

}  // namespace
}  // namespace borelli::test::motion_fit_test
