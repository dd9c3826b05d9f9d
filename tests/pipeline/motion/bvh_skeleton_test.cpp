// Skeletons written as BVH, compared with the original poses. They are read back by an independent reader (a
// loop over the words with 4 by 4 matrices, after the published definition) and by the library's, which is
// tested against NumPy.
#include "pipeline/motion/bvh_skeleton.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <numbers>
#include <sstream>

#include "pipeline/motion/recorded_trajectory.hpp"
#include "pipeline/recordings/bvh_motion.hpp"
#include "tests/pipeline/motion/phantom_recording.hpp"

namespace borelli::test::bvh_skeleton_test {
namespace {

using Eigen::Affine3d;
using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double degree = std::numbers::pi / 180;
// angles reach the text in degrees: a rounding of 360 * 2^-52 degrees over a chain of eight joints is 1e-14
// rad
constexpr double rounding = 1e-12;

template <class T>
T need(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message());
  return std::move(*result);
}

/// Forward kinematics of one frame straight from the text: world transforms by joint.
std::map<std::string, Affine3d> posed_by_text(const std::string& text, int frame) {
  struct Joint {
    std::string name;
    int parent = -1;
    Vector3d offset;
    std::vector<std::string> channels;
  };
  std::istringstream words(text);
  std::vector<Joint> joints;
  std::vector<int> open;
  int ends = 0;  // braces of End Sites
  for (std::string word; words >> word && word != "MOTION";) {
    if (word == "ROOT" || word == "JOINT") {
      joints.push_back({"", open.empty() ? -1 : open.back(), Vector3d::Zero(), {}});
      words >> joints.back().name;
      open.push_back(int(joints.size()) - 1);
    } else if (word == "End") {
      ends = 1;
    } else if (word == "OFFSET") {
      Vector3d offset;
      words >> offset[0] >> offset[1] >> offset[2];
      if (!ends) joints.back().offset = offset;
    } else if (word == "CHANNELS") {
      int count = 0;
      words >> count;
      for (joints.back().channels.resize(std::size_t(count)); auto& channel : joints.back().channels)
        words >> channel;
    } else if (word == "}") {
      if (ends)
        ends = 0;
      else
        open.pop_back();
    }
  }
  std::string skipped;
  for (int i = 0; i < 5; ++i) words >> skipped;  // Frames: n Frame Time: s
  std::map<std::string, Affine3d> world;
  for (int row = 0; row <= frame; ++row)
    for (const Joint& joint : joints) {
      Affine3d X = Affine3d::Identity();
      X.translate(joint.offset);
      for (const std::string& channel : joint.channels) {
        double value = 0;
        words >> value;
        const Vector3d axis = Vector3d::Unit(channel[0] - 'X');
        if (channel.ends_with("position"))
          X.translate(value * axis);
        else
          X.rotate(AngleAxisd(value * degree, axis));
      }
      world[joint.name] = joint.parent < 0 ? X : world.at(joints[std::size_t(joint.parent)].name) * X;
    }
  return world;
}

/// A pendulum on a cart that slides along y: gravity along -z, the rod's frame at the hinge.
Scene cart() {
  Scene scene;
  Solid rod, cart;
  rod.name = "rod";
  rod.parent = "cart";
  rod.switches = {{.kind = Fixed{{Matrix3d::Identity(), {0, 0, 0.5}}}},
                  {.kind = Rotation{Vector3d::UnitX()}, .coordinate = "swing", .q = {0}}};
  rod.inertials = {{1, {0, 0, -0.4}, Matrix3d::Identity() * 0.01}};
  cart.name = "cart";
  cart.switches = {{.kind = Translation{Vector3d::UnitY()}, .coordinate = "slide", .q = {0}}};
  cart.inertials = {{1, {0, 0, 0}, Matrix3d::Identity() * 0.01}};
  scene.solids = {rod, cart};  // the child first, as scene files allow
  return scene;
}

RecordedPositions rows_of(const System& system, const std::vector<double>& times,
                          const std::map<std::string, std::vector<double>>& values) {
  RecordedPositions out;
  out.times = times;
  out.q.resize(std::ssize(times), system.nq);
  for (const CoordinateInfo& c : system.coordinates)
    for (std::size_t i = 0; i < times.size(); ++i) out.q(Eigen::Index(i), c.q_index) = values.at(c.name)[i];
  return out;
}

// With z up, BVH's y is the world's z and BVH's z is the world's -y. A slide of 0.3 m along y becomes -30 cm
// along z; a turn about x stays a turn about x.
TEST(BvhSkeleton, CartAndRodMatchHandCalculation) {
  const Scene scene = cart();
  const System system = need(compile(scene));
  const auto positions = rows_of(system, {0, 0.1}, {{"slide", {0.1, 0.3}}, {"swing", {0, 40 * degree}}});
  const BvhMotion bvh = need(bvh_skeleton(scene, posed_trajectory(system, positions)));
  ASSERT_EQ(bvh.joints.size(), 3U);
  EXPECT_EQ(bvh.joints[0].name, "cart");
  EXPECT_EQ(bvh.joints[0].offset, Vector3d::Zero());
  EXPECT_EQ(bvh.joints[1].name, "rod");
  EXPECT_LT((bvh.joints[1].offset - Vector3d(0, 50, 0)).norm(), rounding);
  EXPECT_TRUE(bvh.joints[2].end_site);
  EXPECT_LT((bvh.joints[2].offset - Vector3d(0, -80, 0)).norm(), rounding);  // twice the gravity centre
  EXPECT_DOUBLE_EQ(bvh.frame_time, 0.1);
  Eigen::MatrixXd expected(2, 9);           // positions, z x y; z x y
  expected << 0, 0, -10, 0, 0, 0, 0, 0, 0,  //
      0, 0, -30, 0, 0, 0, 0, 40, 0;
  EXPECT_LT((bvh.values - expected).cwiseAbs().maxCoeff(), 1e-10) << bvh.values;
}

// A rod that turns several times passes the singular Euler angles; its values rise without jumps.
TEST(BvhSkeleton, FullTurnsStayContinuous) {
  Scene scene = cart();
  const System system = need(compile(scene));
  std::vector<double> times, slide, swing;
  for (int i = 0; i <= 48; ++i) {
    times.push_back(i / 24.0);
    slide.push_back(0);
    swing.push_back(i * 15 * degree);
  }
  const auto positions = rows_of(system, times, {{"slide", slide}, {"swing", swing}});
  const BvhMotion bvh = need(bvh_skeleton(scene, posed_trajectory(system, positions)));
  for (Eigen::Index i = 0; i <= 48; ++i) EXPECT_NEAR(bvh.values(i, 7), 15.0 * double(i), 1e-9);
}

// Poses between uneven times are interpolated along the arc, so a steady turn stays steady.
TEST(BvhSkeleton, UnevenTimesBecomeEqualSteps) {
  const Scene scene = cart();
  const System system = need(compile(scene));
  const std::vector<double> times{0, 0.1, 0.2, 0.25, 0.4, 0.5};
  std::vector<double> slide, swing;
  for (const double t : times) slide.push_back(t), swing.push_back(2 * t);
  const auto positions = rows_of(system, times, {{"slide", slide}, {"swing", swing}});
  const BvhMotion bvh = need(bvh_skeleton(scene, posed_trajectory(system, positions)));
  ASSERT_EQ(bvh.values.rows(), 6);
  EXPECT_NEAR(bvh.frame_time, 0.1, 1e-12);
  for (Eigen::Index i = 0; i < 6; ++i) {
    EXPECT_NEAR(bvh.values(i, 2), -10.0 * double(i), 1e-9);
    EXPECT_NEAR(bvh.values(i, 7), 0.2 * double(i) / degree, 1e-9);
  }
}

TEST(BvhSkeleton, BodyReadBackHasTheSolidsPoses) {
  const Phantom phantom = build_phantom({}).value();
  const Scene scene = still_body(exact_parts(phantom), phantom.landmarks);
  const System system = need(compile(scene));
  const Trajectory motion = posed_trajectory(system, bending(system, {{"lower_trunk_turn", 100},
                                                                      {"hip_left", 60},
                                                                      {"knee_left", 80},
                                                                      {"neck", 30},
                                                                      {"shoulder_right", 170},
                                                                      {"elbow_right", 90},
                                                                      {"ankle_left", 20}}));
  const BvhMotion bvh = need(bvh_skeleton(scene, motion));
  const std::string text = need(bvh_text(bvh, "body.bvh"));
  const BvhMotion read = need(parse_bvh(text, "body.bvh"));
  ASSERT_EQ(read.values.rows(), std::ssize(motion.times));
  Matrix3d turn;  // z up to y up
  turn << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  for (const std::size_t frame : {std::size_t(0), std::size_t(17), motion.times.size() - 1}) {
    const auto by_text = posed_by_text(text, int(frame));
    const auto by_reader = bvh_poses(read, Eigen::Index(frame));
    for (std::size_t s = 0; s < motion.solids.size(); ++s) {
      const Pose X = motion.pose(frame, s);
      const Vector3d place = 100 * turn * X.p;
      const Matrix3d axes = turn * X.R * turn.transpose();
      const Affine3d& told = by_text.at(motion.solids[s]);
      EXPECT_LT((told.translation() - place).norm(), 200 * rounding) << motion.solids[s];  // cm
      EXPECT_LT((told.linear() - axes).norm(), rounding) << motion.solids[s];
      const auto joint =
          std::ranges::find(read.joints, motion.solids[s], &BvhJoint::name) - read.joints.begin();
      EXPECT_LT((by_reader[std::size_t(joint)].p - place).norm(), 200 * rounding) << motion.solids[s];
    }
  }
}

TEST(BvhSkeleton, RefusesAnotherScenesMotion) {
  const Scene scene = cart();
  const System system = need(compile(scene));
  Trajectory motion =
      posed_trajectory(system, rows_of(system, {0, 1}, {{"slide", {0, 0}}, {"swing", {0, 0}}}));
  motion.solids[0] = "other";
  EXPECT_FALSE(bvh_skeleton(scene, motion));
  EXPECT_FALSE(bvh_skeleton(scene, Trajectory{}));
}

}  // namespace
}  // namespace borelli::test::bvh_skeleton_test
