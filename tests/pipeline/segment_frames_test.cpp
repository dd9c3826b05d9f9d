#include "pipeline/body/segment_frames.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>

#include "samples/phantom.hpp"
#include "segmentation/vocabulary/parts.hpp"

namespace borelli::segment_frames_test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

const Phantom& standing() {
  static const Phantom phantom = build_phantom({}).value();
  return phantom;
}

InertiaRow row_of(const Phantom& phantom, std::string_view part) {
  InertiaRow row;
  row.part = part;
  row.inertial = phantom.exact[static_cast<std::size_t>(part_label(part))];
  row.frame = segment_frame(part, phantom.landmarks, row.inertial);
  return row;
}

TEST(SegmentFrames, PointForwardUpAndRight) {
  for (std::size_t label = 1; label < parts.size(); ++label) {
    const InertiaRow row = row_of(standing(), parts[label].name);
    ASSERT_TRUE(row.frame) << row.part;
    const Matrix3d& R = row.frame->R_WA;
    EXPECT_TRUE((R * R.transpose()).isIdentity(1e-12)) << row.part;
    EXPECT_NEAR(R.determinant(), 1, 1e-12) << row.part;
    // the phantom stands with arms 12 degrees and feet 8 degrees out; patient axes: x left, y back, z up
    EXPECT_GT(R.col(1).dot(Vector3d(0, 0, 1)), 0.9) << row.part;
    if (row.part.starts_with("hand")) {  // the palms face the thighs
      EXPECT_GT(R.col(0).dot(Vector3d(row.part == "hand_left" ? -1 : 1, 0, 0)), 0.9) << row.part;
    } else {
      EXPECT_GT(R.col(0).dot(Vector3d(0, -1, 0)), 0.9) << row.part;
      EXPECT_GT(R.col(2).dot(Vector3d(-1, 0, 0)), 0.9) << row.part;
    }
    EXPECT_GT(row.frame->length(), 0.05) << row.part;
    EXPECT_NE(row.frame->axes, "") << row.part;
  }
}

TEST(SegmentFrames, NameEndpointsAndCutsOfPublishedRows) {
  for (std::size_t label = 1; label < parts.size(); ++label) {
    const InertiaRow row = row_of(standing(), parts[label].name);
    const auto* published = published_segment("deleva1996", "male", row.frame->segment, row.frame->from,
                                              row.frame->to, row.frame->cuts);
    ASSERT_TRUE(published) << row.part << " " << row.frame->from << "-" << row.frame->to;
    // the phantom has de Leva's lengths, scaled by up to 3 % so that they add up to its stature
    EXPECT_NEAR(row.frame->length() / published->length, 1, 0.05) << row.part;
  }
  EXPECT_EQ(segment_frame("thigh_left", standing().landmarks, {}, "bone")->cuts, "bone");
}

TEST(SegmentFrames, MirrorTheBodysSides) {
  for (const std::string segment : {"upper_arm", "forearm", "thigh", "shank", "foot"}) {
    const auto left = anatomical_numbers(row_of(standing(), segment + "_left"));
    const auto right = anatomical_numbers(row_of(standing(), segment + "_right"));
    ASSERT_TRUE(left && right);
    // in axes with Z to the right on both sides, the products with z change their sign
    Matrix3d mirrored = right->tensor;
    for (const auto& [r, c] : {std::pair{0, 2}, {2, 0}, {1, 2}, {2, 1}}) mirrored(r, c) *= -1;
    // exact to 1e-8, the accuracy of the phantom's cut solids
    EXPECT_LT((left->tensor - mirrored).cwiseAbs().maxCoeff(), 1e-7 * left->tensor.maxCoeff()) << segment;
    EXPECT_NEAR(left->length, right->length, 1e-9) << segment;
    EXPECT_NEAR(left->centre_along, right->centre_along, 1e-7) << segment;
  }
}

TEST(SegmentFrames, RotateWithTheBody) {
  const Matrix3d R = Eigen::AngleAxisd(0.4, Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  const Vector3d shift(0.1, -0.2, 0.3);
  Phantom turned = standing();
  for (auto& [name, landmark] : turned.landmarks) landmark.point = R * landmark.point + 1000 * shift;
  for (auto& inertial : turned.exact) inertial = inertial.expressed_in(R, shift);
  for (std::size_t label = 1; label < parts.size(); ++label) {
    const auto before = anatomical_numbers(row_of(standing(), parts[label].name));
    const auto after = anatomical_numbers(row_of(turned, parts[label].name));
    ASSERT_TRUE(before && after) << parts[label].name;
    EXPECT_LT((before->tensor - after->tensor).cwiseAbs().maxCoeff(), 1e-12) << parts[label].name;
    EXPECT_LT((before->radii - after->radii).cwiseAbs().maxCoeff(), 1e-12) << parts[label].name;
    EXPECT_NEAR(before->centre_along, after->centre_along, 1e-12) << parts[label].name;
  }
}

TEST(SegmentFrames, FollowAFlexedKnee) {
  PhantomOptions options;
  options.pose_deg["knee_left_flexion"] = 60;
  const Phantom bent = build_phantom(options).value();
  const Matrix3d straight = segment_frame("shank_left", standing().landmarks, {})->R_WA;
  const Matrix3d flexed = segment_frame("shank_left", bent.landmarks, {})->R_WA;
  const Eigen::AngleAxisd turn(Matrix3d(flexed * straight.transpose()));
  EXPECT_NEAR(turn.angle(), 60 * std::numbers::pi / 180,
              0.02);  // the standing thigh leans by a degree or two
  // flexion turns the shank backwards, which is negative about the axis that points right
  EXPECT_LT(turn.axis().dot(Vector3d(-1, 0, 0)), -0.98);
}

TEST(SegmentFrames, ReplaceOrNameMissingLandmarks) {
  EXPECT_FALSE(segment_frame("thigh_left", {}, {}));
  EXPECT_FALSE(segment_frame("lower_trunk", {}, {}));
  EXPECT_FALSE(segment_frame("liver", standing().landmarks, {}));
  Landmarks some = standing().landmarks;
  some.erase("knee_lateral_left");
  some.erase("lateral_malleolus_left");
  const auto thigh = segment_frame("thigh_left", some, {});
  ASSERT_TRUE(thigh);
  EXPECT_NE(thigh->axes.find("because the epicondyles are missing"), std::string::npos);
  some.erase("ankle_left");
  EXPECT_FALSE(segment_frame("shank_left", some, {}));
  some = standing().landmarks;
  some.erase("suprasternale");
  EXPECT_EQ(segment_frame("upper_trunk", some, {})->from, "CERV");
  some.erase("xiphion");
  EXPECT_EQ(segment_frame("upper_trunk", some, {})->from, "");
  EXPECT_EQ(segment_frame("upper_trunk", some, {})->length(), 0);
  some["xiphion"] = {standing().landmarks.find("xiphion")->second.point, 20, 0,
                     "proportion: between neck and hips"};
  const auto trunk = segment_frame("middle_trunk", some, {});
  const auto notes = endpoint_notes(*trunk, "middle_trunk", some);
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_EQ(notes[0], "XYPH is not visible; it was placed by proportion");
  EXPECT_TRUE(endpoint_notes(*trunk, "middle_trunk", some, "xiphion placed by proportion").empty());
}

TEST(SegmentFrames, TrunkEndpointsNeedNoNeck) {
  const auto whole = segment_frame("middle_trunk", standing().landmarks, {});
  Landmarks some = standing().landmarks;
  some.erase("neck");
  const auto frame = segment_frame("middle_trunk", some, {});
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->from, "XYPH");
  EXPECT_EQ(frame->from_point, whole->from_point);
  EXPECT_EQ(frame->long_axis, -Vector3d::UnitZ());  // falls back to the patient's axes
  EXPECT_DOUBLE_EQ(frame->length(), frame->from_point.z() - frame->to_point.z());
  EXPECT_NE(frame->axes.find("because the neck"), std::string::npos);
  some.erase("omphalion");  // without it neither axes nor length
  EXPECT_FALSE(segment_frame("middle_trunk", some, {}));
}

}  // namespace
}  // namespace borelli::segment_frames_test
