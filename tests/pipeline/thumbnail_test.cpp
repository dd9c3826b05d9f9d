// The small copy of a scan shows functions of the patient's position at the right places.
#include "pipeline/export/thumbnail.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/pipeline/capsule_body.hpp"

namespace borelli {
namespace {

double grey_value(const Thumbnail& copy, std::size_t at) {
  return copy.low + copy.grey[at] / 255.0 * (copy.high - copy.low);
}

template <class Visit>
void each_voxel(const Thumbnail& copy, Visit&& visit) {
  std::size_t at = 0;
  for (std::int64_t k = 0; k < copy.size[2]; ++k)
    for (std::int64_t j = 0; j < copy.size[1]; ++j)
      for (std::int64_t i = 0; i < copy.size[0]; ++i, ++at)
        visit(at, Eigen::Vector3d(copy.origin + copy.spacing * Eigen::Vector3d(static_cast<double>(i),
                                                                               static_cast<double>(j),
                                                                               static_cast<double>(k))));
}

// An oblique, sheared, anisotropic grid, flipped in one axis.
Grid crooked_grid() {
  Grid grid;
  grid.size = {60, 50, 24};
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(0.3, Eigen::Vector3d(0.2, 0.5, 1).normalized()).toRotationMatrix();
  grid.axes = turn * Eigen::Vector3d(2, -2.5, 6).asDiagonal();
  grid.axes.col(2) += 0.25 * 6 * turn.col(1);  // gantry tilt
  grid.origin = {-40, 70, 500};
  return grid;
}

// Trilinear interpolation and means over symmetric samples preserve a linear function of position. The error
// is the source's rounding to whole HU (0.5) plus the byte's step of 10 HU (5).
TEST(Thumbnail, ShowsEveryPointAtItsPlaceOnASkewedGrid) {
  GreyVolume grey;
  grey.grid = crooked_grid();
  LabelMap labels;
  labels.grid = grey.grid;
  const auto ramp = [](const Eigen::Vector3d& p) {
    return 200 + 2.1 * p[0] - 1.4 * p[1] + 0.9 * (p[2] - 560);
  };
  for (std::int64_t k = 0; k < grey.grid.size[2]; ++k)
    for (std::int64_t j = 0; j < grey.grid.size[1]; ++j)
      for (std::int64_t i = 0; i < grey.grid.size[0]; ++i) {
        const Eigen::Vector3d point = grey.grid.point(i, j, k);
        grey.voxels.push_back(static_cast<std::int16_t>(std::lround(ramp(point))));
        labels.voxels.push_back(point[0] > 5 ? 2 : 1);
      }
  for (const std::size_t most : {1'000'000u, 4000u}) {  // as fine as the source, and much coarser
    const Thumbnail copy = thumbnail(&grey, &labels, most, 2);
    double worst = 0;
    std::size_t inside = 0, wrong = 0;
    each_voxel(copy, [&](std::size_t at, const Eigen::Vector3d& point) {
      const Eigen::Vector3d index = grey.grid.index(point);
      // the samples of the mean must lie within the grid: half a voxel of the copy from its border
      const Eigen::Vector3d reach =
          grey.grid.axes.inverse().cwiseAbs() * Eigen::Vector3d::Constant(copy.spacing / 2);
      for (int c = 0; c < 3; ++c)
        if (index[c] < reach[c] ||
            index[c] > static_cast<double>(grey.grid.size[static_cast<std::size_t>(c)] - 1) - reach[c])
          return;
      const double value = std::clamp(ramp(point), copy.low, copy.high);
      worst = std::max(worst, std::abs(grey_value(copy, at) - value));
      ++inside;
      // farther than half a diagonal of a source voxel from the border between labels
      if (std::abs(point[0] - 5) > 4.5) wrong += copy.labels[at] != (point[0] > 5 ? 2 : 1);
    });
    EXPECT_GT(inside, copy.grey.size() / 8);
    EXPECT_LE(worst, 5.51) << most;
    EXPECT_EQ(wrong, 0u) << most;
    EXPECT_LE(copy.grey.size(), most * 11 / 10);
  }
}

TEST(Thumbnail, ContainsOnlyTheBodyWithItsMargin) {
  CapsuleScan scan = capsule_scan(capsule_grid(10));
  const Thumbnail copy = thumbnail(&scan.grey, &scan.labels);
  EXPECT_DOUBLE_EQ(copy.spacing, 10);
  const Eigen::Vector3d last =
      copy.origin + copy.spacing * Eigen::Vector3d(static_cast<double>(copy.size[0] - 1),
                                                   static_cast<double>(copy.size[1] - 1),
                                                   static_cast<double>(copy.size[2] - 1));
  // the capsules reach from -262 to 262 mm, -156 to 125 and -1 to 1725; the grid's own end is at z = -25
  EXPECT_NEAR(copy.origin[0], -262 - 30, 10.1);
  EXPECT_NEAR(last[0], 262 + 30, 10.1);
  EXPECT_NEAR(copy.origin[1], -156 - 30, 10.1);
  EXPECT_NEAR(last[2], 1725 + 30, 10.1);
  std::size_t in_copy = 0, in_scan = 0;
  for (const auto label : copy.labels) in_copy += label != 0;
  for (const auto label : scan.labels.voxels) in_scan += label != 0;
  EXPECT_NEAR(static_cast<double>(in_copy), static_cast<double>(in_scan),
              0.02 * static_cast<double>(in_scan));
}

TEST(Thumbnail, ShowsLabelsAloneAndUnlabelledScans) {
  CapsuleScan scan = capsule_scan(capsule_grid(20));
  const Thumbnail only_labels = thumbnail(nullptr, &scan.labels);
  EXPECT_TRUE(only_labels.grey.empty());
  EXPECT_FALSE(only_labels.labels.empty());
  const Thumbnail only_grey = thumbnail(&scan.grey, nullptr);
  EXPECT_EQ(only_grey.size, scan.grey.grid.size);
  EXPECT_TRUE(only_grey.labels.empty());
  std::ranges::fill(scan.labels.voxels, std::uint8_t{0});
  EXPECT_EQ(thumbnail(&scan.grey, &scan.labels).size, scan.grey.grid.size);
}

// The same body labelled on another, shifted grid: the labels lie at the same positions in the scan. The
// tolerance is the share of the copy's body voxels that lie within half a source voxel of a border.
TEST(Thumbnail, LabelsMayHaveTheirOwnGrid) {
  const CapsuleScan fine = capsule_scan(capsule_grid(8));
  Grid other = capsule_grid(10);
  other.origin += Eigen::Vector3d(3, -2, 4);
  const CapsuleScan coarse = capsule_scan(other);
  const Thumbnail expected = thumbnail(&fine.grey, &fine.labels);
  const Thumbnail copy = thumbnail(&fine.grey, &coarse.labels);
  std::size_t same = 0, body = 0;
  each_voxel(copy, [&](std::size_t at, const Eigen::Vector3d& point) {
    if (copy.labels[at] == 0) return;
    const Eigen::Vector3d steps = (point - expected.origin) / expected.spacing;
    const auto voxel = steps.array().round().cast<std::int64_t>().eval();
    ++body;
    same += copy.labels[at] == expected.labels[static_cast<std::size_t>(
                                   (voxel[2] * expected.size[1] + voxel[1]) * expected.size[0] + voxel[0])];
  });
  EXPECT_GT(static_cast<double>(same), 0.85 * static_cast<double>(body));
}

TEST(Thumbnail, IsIndependentOfThreads) {
  const CapsuleScan scan = capsule_scan(capsule_grid(15));
  const Thumbnail one = thumbnail(&scan.grey, &scan.labels, 50'000, 1);
  const Thumbnail three = thumbnail(&scan.grey, &scan.labels, 50'000, 3);
  EXPECT_EQ(one.grey, three.grey);
  EXPECT_EQ(one.labels, three.labels);
}

}  // namespace
}  // namespace borelli
