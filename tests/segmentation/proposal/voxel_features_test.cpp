#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "segmentation/proposal/voxel_features.hpp"
#include "tests/segmentation/proposal/drawn_body.hpp"

namespace borelli::proposal_test {
namespace {

std::vector<std::int16_t> rows(const VoxelFeatures& features) {
  const std::size_t width = voxel_feature_names().size();
  const auto& places = features.body().places;
  std::vector<std::int16_t> out(places.size() * width);
  for (std::size_t n = 0; n < places.size(); ++n)
    features.fill(places[n], std::span(out).subspan(n * width, width));
  return out;
}

TEST(VoxelFeatures, AreIndependentOfTheBodysPosition) {
  GreyVolume moved = drawn().grey;
  moved.grid.origin += Eigen::Vector3d(512, -256, 1024);  // exact in floating point
  const CoarseBody one = coarse_body(anatomy_of(drawn().grey, 4, 0)),
                   other = coarse_body(anatomy_of(moved, 4, 0));
  ASSERT_EQ(one.places, other.places);
  EXPECT_EQ(rows(VoxelFeatures(one)), rows(VoxelFeatures(other)));
}

// Nearly all voxels have equal features; a geodesic's start and equally long paths may be chosen differently.
TEST(VoxelFeatures, AreEqualInAMirroredBody) {
  GreyVolume mirror = drawn().grey;
  mirror.grid.axes.row(0) *= -1, mirror.grid.origin[0] *= -1;
  const CoarseBody one = coarse_body(anatomy_of(drawn().grey, 4, 0)),
                   other = coarse_body(anatomy_of(mirror, 4, 0));
  const VoxelFeatures of_one(one), of_other(other);
  const std::size_t width = voxel_feature_names().size();
  std::vector<std::int16_t> row(width), twin(width);
  std::vector<int> unlike(width, 0);
  int compared = 0;
  for (std::size_t n = 0; n < one.places.size(); n += 7) {
    const auto o = static_cast<std::int64_t>(one.places[n]);
    const auto& size = one.grid().size;
    const Eigen::Vector3d p = one.grid().point(o % size[0], o / size[0] % size[1], o / (size[0] * size[1]));
    const Eigen::Vector3d index = other.grid().index({-p[0], p[1], p[2]});
    const auto i = std::lround(index[0]), j = std::lround(index[1]), k = std::lround(index[2]);
    ASSERT_LT(
        (index - Eigen::Vector3d(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)))
            .norm(),
        1e-6);
    const std::size_t at = other.grid().offset(i, j, k);
    ASSERT_TRUE(other.body.voxels[at]);
    of_one.fill(one.places[n], row);
    of_other.fill(at, twin);
    ++compared;
    for (std::size_t f = 0; f < width; ++f) unlike[f] += std::abs(row[f] - twin[f]) > 2;
  }
  ASSERT_GT(compared, 1000);
  for (std::size_t f = 0; f < width; ++f) {
    const std::string& name = voxel_feature_names()[f];
    const bool of_ways =
        name.starts_with("way_") || name.starts_with("section_") || name.starts_with("beyond_");
    if (!of_ways) {
      EXPECT_EQ(unlike[f], 0) << name;
    }
  }
}

TEST(VoxelFeatures, MeasureALineThroughABox) {
  GreyVolume box{{{{40, 40, 40}, 4 * Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero()}, {}},
                 Quantity::hu};
  box.voxels.assign(box.grid.count(), -1000);
  for (std::int64_t k = 8; k < 32; ++k)
    for (std::int64_t j = 10; j < 30; ++j)
      for (std::int64_t i = 12; i < 28; ++i) box.at(i, j, k) = 40;
  const CoarseBody body = coarse_body(anatomy_of(box, 4, 0));
  ASSERT_EQ(body.places.size(), 16U * 20 * 24);
  const VoxelFeatures features(body);
  const auto& names = voxel_feature_names();
  std::vector<std::int16_t> row(names.size());
  features.fill(body.places.front(), row);  // the rightmost, frontmost and lowest corner
  const auto value = [&](const char* name) {
    return row[static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin())];
  };
  EXPECT_EQ(value("run_up"), 24 * 4);
  EXPECT_EQ(value("run_down"), 4);
  EXPECT_EQ(value("run_front"), 4);
  EXPECT_EQ(value("run_back"), 20 * 4);
  EXPECT_EQ(value("run_across_most"), 16 * 4);
  EXPECT_EQ(value("piece_width"), 16 * 4);
  EXPECT_EQ(value("piece_area"), 16 * 20);
  EXPECT_EQ(value("hu"), 40);
  EXPECT_EQ(value("body_12"), 296);  // 8 of 27 voxels
}

}  // namespace
}  // namespace borelli::proposal_test
