// The ISB's frames, from landmarks laid about a frame that is known.
#include "pipeline/isb_frames.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "pipeline/segment_frames.hpp"
#include "samples/phantom.hpp"

namespace borelli {
namespace {

using Eigen::Matrix3d, Eigen::Vector3d;

// columns X forwards, Y up, Z right, in patient axes (left, back, up), for a body that stands turned and bent
Matrix3d turned() {
  Matrix3d upright;
  upright << 0, 0, -1, -1, 0, 0, 0, 1, 0;
  return Eigen::AngleAxisd(0.4, Vector3d(1, 2, 3).normalized()).toRotationMatrix() * upright;
}

// a landmark by its coordinates (forwards, up, right; mm) in that frame about `origin`
const Vector3d origin(20, -30, 900);
Landmark at(double x, double y, double z) { return {origin + turned() * Vector3d(x, y, z), 0, 0, "exact"}; }

SegmentFrame laid(const char* segment, const std::string& part, const Landmarks& landmarks) {
  SegmentFrame frame;
  frame.segment = segment;
  lay_isb_frame(frame, part, landmarks);
  return frame;
}

void expect_frame(const SegmentFrame& frame, const Vector3d& from) {
  EXPECT_LT((frame.R_WA - turned()).cwiseAbs().maxCoeff(), 1e-12) << frame.segment << "\n" << frame.R_WA;
  EXPECT_LT((frame.origin - 1e-3 * (origin + turned() * from)).norm(), 1e-12) << frame.segment;
  EXPECT_NE(frame.axes.find("ISB"), std::string::npos);
}

TEST(IsbFrames, TrunkAndPelvis) {
  // ASIS and PSIS in one plane with the hips' line: level, front to back
  expect_frame(laid("lower_trunk", "lower_trunk",
                    {{"asis_left", at(0, 0, -120)},
                     {"asis_right", at(0, 0, 120)},
                     {"psis_left", at(-150, 0, -40)},
                     {"psis_right", at(-150, 0, 40)}}),
               {0, 0, 0});
  // Y through the middles of the upper and the lower pair
  expect_frame(laid("upper_trunk", "upper_trunk",
                    {{"suprasternale", at(60, -20, 0)},
                     {"cervicale", at(-60, 20, 0)},
                     {"xiphion", at(80, -180, 0)},
                     {"t8", at(-80, -200, 0)}}),
               {60, -20, 0});
}

TEST(IsbFrames, LimbsOnBothSides) {
  for (const std::string side : {"_left", "_right"}) {
    const double out = side == "_left" ? -1 : 1;  // lateral, along Z
    Landmarks marks{
        {"shoulder" + side, at(0, 300, 0)},           {"elbow_medial" + side, at(0, 0, -30 * out)},
        {"elbow_lateral" + side, at(0, 0, 30 * out)}, {"hip" + side, at(0, 420, 0)},
        {"knee_medial" + side, at(0, 0, -40 * out)},  {"knee_lateral" + side, at(0, 0, 40 * out)}};
    expect_frame(laid("upper_arm", "upper_arm" + side, marks), {0, 300, 0});
    expect_frame(laid("thigh", "thigh" + side, marks), {0, 420, 0});
    marks["ulnar_styloid" + side] = at(0, -250, 0);
    marks["radial_styloid" + side] = at(0, -255, 50 * out);
    expect_frame(laid("forearm", "forearm" + side, marks), {0, -250, 0});
    marks["medial_malleolus" + side] = at(0, -430, -35 * out);
    marks["lateral_malleolus" + side] = at(0, -450, 35 * out);
    expect_frame(laid("shank", "shank" + side, marks), {0, -440, 0});
    marks["heel" + side] = at(0, 0, 0);
    marks["metatarsal_1" + side] = at(180, 0, -40 * out);
    marks["metatarsal_2" + side] = at(190, 0, -20 * out);
    marks["metatarsal_5" + side] = at(150, 0, 40 * out);
    const SegmentFrame foot = laid("foot", "foot" + side, marks);
    EXPECT_LT((foot.R_WA.col(1) - turned().col(1)).norm(), 1e-12) << side;
    EXPECT_LT((foot.R_WA.col(0) - turned() * Vector3d(1, 0, 0)).norm(), 1e-12) << side;
  }
}

TEST(IsbFrames, SayForWantOfWhatTheyAreNotThere) {
  const Phantom body = build_phantom({}).value();
  auto frame = *segment_frame("lower_trunk", body.landmarks, body.exact[4]);
  const Matrix3d before = frame.R_WA;
  lay_isb_frame(frame, "lower_trunk", body.landmarks);
  EXPECT_EQ(frame.R_WA, before);
  EXPECT_TRUE(frame.axes.ends_with("(not the ISB's, for want of psis_left)")) << frame.axes;
  EXPECT_TRUE(frame.origin_name.empty());
  auto head = *segment_frame("head", body.landmarks, body.exact[1]);
  lay_isb_frame(head, "head", body.landmarks);
  EXPECT_TRUE(head.axes.ends_with("(none of the ISB's for this segment)")) << head.axes;
}

}  // namespace
}  // namespace borelli
