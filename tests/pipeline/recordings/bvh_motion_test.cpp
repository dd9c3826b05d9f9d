// Joint poses of BVH files against rotations by hand and against Python with NumPy (4 by 4 matrices, one per
// channel, multiplied from left to right).
#include "pipeline/recordings/bvh_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "tests/paths.hpp"

namespace borelli::test::bvh_motion_test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

BvhMotion bvh_of(const std::string& root, const std::string& joint, const std::string& row) {
  const auto motion =
      parse_bvh("HIERARCHY ROOT a { " + root + " JOINT b { " + joint +
                    " End Site { OFFSET 0 0 2 } } }\nMOTION\nFrames: 1\nFrame Time: 0.1\n" + row,
                "a.bvh");
  EXPECT_TRUE(motion) << (motion ? "" : motion.error().message());
  return motion.value_or(BvhMotion{});
}

TEST(BvhMotion, JointsOfAWalkMatchAnotherProgram) {
  const std::string file = test::shared_folder() + "/motion/walk1.bvh";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not there";
  const auto motion = read_bvh(file);
  ASSERT_TRUE(motion) << motion.error().message();
  const auto markers = bvh_markers(*motion, 0.1, file);
  ASSERT_TRUE(markers) << markers.error().message();
  EXPECT_EQ(markers->names.size(), 91U);
  EXPECT_EQ(markers->times[13], 13 * 0.041667);
  EXPECT_FALSE(markers->up);
  const struct {
    int frame;
    std::string joint;
    Vector3d place;  // dm
  } expected[] = {{0, "Hand_L", {2.419174581481, -0.370966391758, 9.615537665372}},
                  {0, "Thumb3_R_end", {-2.357478507726, 0.535622735053, 8.165989017273}},
                  {0, "LoLeg_L", {0.556289773820, 0.612441690195, 4.854776580003}},
                  {0, "Foot_R", {-1.020839901614, 0.382405561343, 1.736450874274}},
                  {13, "Hand_L", {2.424862142844, -0.111704365200, 9.476233767579}},
                  {13, "Thumb3_R_end", {-2.410126624733, 0.167377997724, 8.270211053178}},
                  {13, "LoLeg_L", {0.515693580985, 0.370373842881, 4.871993333096}},
                  {13, "Foot_R", {-1.013224266343, 0.937440850073, 1.916268928538}}};
  for (const auto& [frame, joint, place] : expected) {
    const auto at = std::find(markers->names.begin(), markers->names.end(), joint) - markers->names.begin();
    EXPECT_LT((markers->frames[frame].col(at) - 0.1 * place).norm(), 1e-12) << joint;  // 12 decimals
  }
  // MakeHuman's body is 1.64 m from soles to crown in decimetres
  EXPECT_EQ(guessed_bvh_unit(*motion), 0.1);
}

TEST(BvhMotion, RotationsMultiplyFromLeftToRight) {
  // Rz(90) Rx(90): x to y, y to z, z to x
  const auto zx = bvh_of("OFFSET 0 0 0 CHANNELS 2 Zrotation Xrotation", "OFFSET 0 1 0 CHANNELS 0", "90 90");
  const auto poses = bvh_poses(zx, 0);
  Matrix3d R;
  R << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  EXPECT_LT((poses[0].R - R).norm(), 1e-15);
  EXPECT_LT((poses[1].p - Vector3d(0, 0, 1)).norm(), 1e-15);
  EXPECT_LT((poses[2].p - Vector3d(2, 0, 1)).norm(), 1e-15);
  // Rx(90) Rz(90): x to z, y to -x, z to -y
  const auto xz = bvh_of("OFFSET 0 0 0 CHANNELS 2 Xrotation Zrotation", "OFFSET 0 1 0 CHANNELS 0", "90 90");
  R << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  EXPECT_LT((bvh_poses(xz, 0)[0].R - R).norm(), 1e-15);
  // Y alone, negative
  const auto y = bvh_of("OFFSET 0 0 0 CHANNELS 1 Yrotation", "OFFSET 0 1 0 CHANNELS 0", "-90");
  R << 0, 0, -1, 0, 1, 0, 1, 0, 0;
  EXPECT_LT((bvh_poses(y, 0)[0].R - R).norm(), 1e-15);
}

TEST(BvhMotion, AllOrdersEqualTheProductOfTheirMatrices) {
  const double degree = std::acos(-1.) / 180;
  const auto about = [&](char axis, double angle) {
    const double c = std::cos(angle * degree), s = std::sin(angle * degree);
    Matrix3d R = Matrix3d::Identity();
    const int i = (axis - 'X' + 1) % 3, j = (axis - 'X' + 2) % 3;
    R(i, i) = R(j, j) = c, R(i, j) = -s, R(j, i) = s;
    return R;
  };
  for (const std::string order : {"XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX", "ZXZ", "YXY"}) {
    std::string channels = "OFFSET 0 0 0 CHANNELS 3";
    for (const char axis : order) channels += std::string(" ") + axis + "rotation";
    const auto motion = bvh_of(channels, "OFFSET 1 2 3 CHANNELS 0", "20 -70 115");
    const Matrix3d R = about(order[0], 20) * about(order[1], -70) * about(order[2], 115);
    const auto poses = bvh_poses(motion, 0);
    EXPECT_LT((poses[0].R - R).norm(), 1e-14) << order;
    EXPECT_LT((poses[1].p - R * Vector3d(1, 2, 3)).norm(), 1e-14) << order;
  }
}

TEST(BvhMotion, AJointsOwnRotationDoesNotMoveIt) {
  const auto motion = bvh_of("OFFSET 1 2 3 CHANNELS 4 Zrotation Xposition Yposition Zposition",
                             "OFFSET 5 0 0 CHANNELS 1 Zrotation", "90 10 20 30 180");
  const auto poses = bvh_poses(motion, 0, BvhPositions::added);
  EXPECT_EQ(poses[0].p, Vector3d(11, 22, 33));
  EXPECT_LT((poses[1].p - Vector3d(11, 27, 33)).norm(), 1e-14);
}

TEST(BvhMotion, DataDecideWhetherPositionsReplaceTheOffset) {
  const std::string positions = " CHANNELS 3 Xposition Yposition Zposition";
  // deviations from the offset, as in Biovision's definition
  const auto added = bvh_of("OFFSET 0 95 0" + positions, "OFFSET 10 0 0" + positions, "3 -2 1 0.5 0 0.25");
  EXPECT_FALSE(replaces_offset(added, 0));
  EXPECT_EQ(bvh_poses(added, 0)[1].p, Vector3d(13.5, 93, 1.25));
  // the full position in the parent
  const auto whole = bvh_of("OFFSET 0 95 0" + positions, "OFFSET 10 0 0" + positions, "3 93 1 10.5 0 0.25");
  EXPECT_TRUE(replaces_offset(whole, 0));
  EXPECT_TRUE(replaces_offset(whole, 1));
  EXPECT_EQ(bvh_poses(whole, 0)[1].p, Vector3d(13.5, 93, 1.25));
  // and if the caller says so
  EXPECT_EQ(bvh_poses(whole, 0, BvhPositions::added)[0].p, Vector3d(3, 188, 1));
  EXPECT_EQ(bvh_poses(added, 0, BvhPositions::replaced)[0].p, Vector3d(3, -2, 1));
  // an axis without a channel keeps its offset
  const auto part = bvh_of("OFFSET 1 95 7 CHANNELS 1 Yposition", "OFFSET 10 0 0", "94");
  EXPECT_EQ(bvh_poses(part, 0)[0].p, Vector3d(1, 94, 7));
}

TEST(BvhMotion, TheUnitIsGuessedFromTheHeightOfTheRestPose) {
  for (const auto& [height, metres] : {std::pair{"1.7", 1.}, {"17", 0.1}, {"170", 0.01}, {"1700", 0.001}}) {
    const auto motion =
        bvh_of("OFFSET 9999 0 0", std::string("OFFSET 0 ") + height + " 0 CHANNELS 1 Xrotation", "0");
    EXPECT_EQ(guessed_bvh_unit(motion), metres) << height;
  }
  EXPECT_FALSE(guessed_bvh_unit(bvh_of("OFFSET 0 0 0", "OFFSET 0 5000 0 CHANNELS 1 Xrotation", "0")));
}

TEST(BvhMotion, MarkersNeedFramesAndAUnit) {
  const auto motion = bvh_of("OFFSET 0 0 0", "OFFSET 0 1 0 CHANNELS 1 Xrotation", "0");
  EXPECT_TRUE(bvh_markers(motion, 1, "a.bvh"));
  EXPECT_EQ(bvh_markers(motion, 0, "a.bvh").error().message(),
            "a.bvh: has a unit of 0 m, expected a positive number");
  BvhMotion still = motion;
  still.values.resize(0, 1);
  EXPECT_EQ(bvh_markers(still, 1, "a.bvh").error().message(), "a.bvh: contains no frame of motion");
}

}  // namespace
}  // namespace borelli::test::bvh_motion_test
