// ISB frames from landmarks placed around a known frame.
#include "pipeline/body/isb_frames.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "pipeline/body/segment_frames.hpp"
#include "samples/phantom_voxels.hpp"
#include "segmentation/labelling/segment.hpp"

namespace borelli {
namespace {

using Eigen::Matrix3d, Eigen::Vector3d;

// columns X forwards, Y up, Z right, in patient axes (left, back, up), for a turned and bent body
Matrix3d turned() {
  Matrix3d upright;
  upright << 0, 0, -1, -1, 0, 0, 0, 1, 0;
  return Eigen::AngleAxisd(0.4, Vector3d(1, 2, 3).normalized()).toRotationMatrix() * upright;
}

// a landmark from its coordinates (forwards, up, right; mm) in that frame at `origin`
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

TEST(IsbFrames, AreExactForTrunkAndPelvis) {
  // ASIS and PSIS level, in one plane with the line of the hips
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

TEST(IsbFrames, AreExactForLimbsOnBothSides) {
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

TEST(IsbFrames, NameTheirMissingLandmarks) {
  const Phantom body = build_phantom({}).value();
  Landmarks marks = body.landmarks;
  marks.erase("psis_left");
  auto frame = *segment_frame("lower_trunk", marks, body.exact[4]);
  const Matrix3d before = frame.R_WA;
  lay_isb_frame(frame, "lower_trunk", marks);
  EXPECT_EQ(frame.R_WA, before);
  EXPECT_TRUE(frame.axes.ends_with("(not the ISB's, because psis_left is missing)")) << frame.axes;
  EXPECT_TRUE(frame.origin_name.empty());
  auto head = *segment_frame("head", body.landmarks, body.exact[1]);
  lay_isb_frame(head, "head", body.landmarks);
  EXPECT_TRUE(head.axes.ends_with("(the ISB defines none for this segment)")) << head.axes;
}

// The landmarks that segmentation finds suffice for every frame. Their errors of about 5 mm turn a frame by
// up to 4 degrees about long axes of bones and the trunk, and by up to 8 degrees for lines of 40 to 90 mm
// across a forearm or a foot.
TEST(IsbFrames, FromAScanMatchTheExactLandmarks) {
  const Phantom body = build_phantom({}).value();
  GridOptions grid;
  grid.spacing.setConstant(2.5);
  const Scan scan = voxelise(body, phantom_grid(body, grid), {.partial_volume = true, .noise_hu = 20});
  const auto found = segment(scan.grey);
  ASSERT_TRUE(found) << found.error().message();
  for (std::size_t label = 1; label < parts.size(); ++label) {
    const std::string part(parts[label].name);
    auto exact = *segment_frame(part, body.landmarks, body.exact[label]),
         measured = *segment_frame(part, found->landmarks, body.exact[label]);
    lay_isb_frame(exact, part, body.landmarks);
    lay_isb_frame(measured, part, found->landmarks);
    EXPECT_EQ(measured.axes, exact.axes);
    if (exact.origin_name.empty()) {
      EXPECT_TRUE(part == "head" || part == "middle_trunk" || part.starts_with("hand")) << part;
      continue;
    }
    const double deg = 180 / M_PI;
    const bool foot = part.starts_with("foot"), slight = foot || part.starts_with("forearm");
    const int own = foot ? 0 : 1;  // the axis along the segment
    const double along = deg * std::acos(measured.R_WA.col(own).dot(exact.R_WA.col(own))),
                 all = deg * Eigen::AngleAxisd(measured.R_WA.transpose() * exact.R_WA).angle(),
                 origin_mm = 1e3 * (measured.origin - exact.origin).norm();
    std::printf("%-16s axis along it %.1f, all %.1f degrees; origin %.1f mm\n", part.c_str(), along, all,
                origin_mm);
    EXPECT_LT(along, 4) << part;
    EXPECT_LT(all, slight ? 8 : 4) << part;
    EXPECT_LT(origin_mm, 10) << part;
  }
}

}  // namespace
}  // namespace borelli
