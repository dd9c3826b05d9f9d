#include "segmentation/grid/work_grid.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "tests/segmentation/grids.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

// trilinear interpolation and means over boxes both preserve a field that is linear in space
TEST(WorkGrid, KeepsALinearFieldOfAnyGrid) {
  const Vector3d slope(2, -3, 1.5);
  for (const bool mirrored : {false, true})
    for (const double shear : {0.0, 1.2}) {
      GreyVolume volume;
      volume.grid = oblique_grid(mirrored, shear);
      volume.grid.size = {60, 40, 12};
      const Vector3d middle = volume.grid.point(Vector3d(29.5, 19.5, 5.5));
      for (std::int64_t k = 0; k < 12; ++k)
        for (std::int64_t j = 0; j < 40; ++j)
          for (std::int64_t i = 0; i < 60; ++i) {
            const Vector3d p = volume.grid.point(i, j, k);
            volume.voxels.push_back(static_cast<std::int16_t>(std::lround(slope.dot(p - middle))));
          }
      const WorkVolume work = resampled(volume, 3);
      int inside = 0;
      for (std::int64_t k = 0; k < work.hu.grid.size[2]; ++k)
        for (std::int64_t j = 0; j < work.hu.grid.size[1]; ++j)
          for (std::int64_t i = 0; i < work.hu.grid.size[0]; ++i) {
            const Vector3d p = work.hu.grid.point(i, j, k);
            const Vector3d index = volume.grid.index(p);
            // a work voxel's corner reaches 2.6 mm: four voxels of the finest axis
            if ((index.array() < 4).any() || index[0] > 55 || index[1] > 35 || index[2] > 7) continue;
            ++inside;
            EXPECT_NEAR(work.hu.at(i, j, k), slope.dot(p - middle), 1.01);  // two roundings to whole numbers
          }
      EXPECT_GT(inside, 20);
    }
}

TEST(WorkGrid, LeftIsLeftInAnyVoxelOrder) {
  // one bright voxel at the patient's left, front and top, in grids with all directions of axes
  for (int flips = 0; flips < 8; ++flips) {
    GreyVolume volume;
    volume.grid.size = {10, 10, 10};
    Vector3d spacing(4, 4, 4);
    for (int c = 0; c < 3; ++c)
      if (flips >> c & 1) spacing[c] = -4;
    volume.grid.axes = spacing.asDiagonal();
    volume.grid.origin = -4.5 * spacing;
    volume.voxels.assign(1000, -1000);
    const Vector3d bright(14, -14, 14);
    const Vector3d index = volume.grid.index(bright);
    volume.at(std::lround(index[0]), std::lround(index[1]), std::lround(index[2])) = 1000;
    const WorkVolume work = resampled(volume, 4);
    std::size_t best = 0;
    for (std::size_t o = 0; o < work.hu.voxels.size(); ++o)
      if (work.hu.voxels[o] > work.hu.voxels[best]) best = o;
    const auto n = work.hu.grid.size;
    const auto i = static_cast<std::int64_t>(best) % n[0], j = static_cast<std::int64_t>(best) / n[0] % n[1],
               k = static_cast<std::int64_t>(best) / n[0] / n[1];
    const Vector3d found = work.hu.grid.point(i, j, k);
    EXPECT_LT((found - bright).norm(), 4) << "flips " << flips;
  }
}

TEST(WorkGrid, PaddingAndTheOutsideAreUnseen) {
  GreyVolume volume;
  volume.grid.size = {20, 20, 20};
  volume.grid.axes = 3 * Eigen::Matrix3d::Identity();
  volume.voxels.assign(8000, 0);
  for (std::int64_t k = 0; k < 20; ++k)
    for (std::int64_t j = 0; j < 20; ++j)
      for (std::int64_t i = 0; i < 5; ++i) volume.at(i, j, k) = -2048;
  const WorkVolume work = resampled(volume, 3);
  const auto at = [&](double x, double y, double z) {
    const Vector3d index = work.hu.grid.index(Vector3d(x, y, z));
    return work.seen.at(std::lround(index[0]), std::lround(index[1]), std::lround(index[2]));
  };
  EXPECT_EQ(at(6, 30, 30), 0);
  EXPECT_EQ(at(30, 30, 30), 1);
  EXPECT_EQ(at(30, 30, 59.9), 0);
}

// grids along the patient's axes use a separate code for means
TEST(WorkGrid, AlignedGridsAverageTheirSamples) {
  std::mt19937 random(3);
  for (const Vector3d& spacing : {Vector3d(1.3, -0.9, 2.1), Vector3d(-3.1, 2.9, -0.5), Vector3d(6, 6, 6)}) {
    GreyVolume volume;
    volume.grid.size = {31, 27, 22};
    volume.grid.axes = spacing.asDiagonal();
    volume.grid.origin = Vector3d(7, -3, 11);
    volume.voxels.resize(volume.grid.count());
    for (auto& voxel : volume.voxels)
      voxel = static_cast<std::int16_t>(static_cast<int>(random() % 2000) - 1000);
    for (std::int64_t k = 0; k < 22; ++k)  // a padded corner and a single padded voxel
      for (std::int64_t j = 0; j < 27; ++j)
        for (std::int64_t i = 0; i < 31; ++i)
          if (i + j < 14 || (i == 20 && j == 20 && k == 10)) volume.at(i, j, k) = -2048;
    const double step = 3;
    const WorkVolume work = resampled(volume, step);
    std::array<int, 3> each{};
    for (int c = 0; c < 3; ++c)
      each[static_cast<std::size_t>(c)] =
          std::clamp(static_cast<int>(std::lround(step / std::abs(spacing[c]))), 1, 4);
    const int all = each[0] * each[1] * each[2];
    int whole = 0, partly = 0, unseen = 0;
    for (std::int64_t k = 0; k < work.hu.grid.size[2]; ++k)
      for (std::int64_t j = 0; j < work.hu.grid.size[1]; ++j)
        for (std::int64_t i = 0; i < work.hu.grid.size[0]; ++i) {
          double sum = 0;
          int held = 0;
          for (int c = 0; c < each[2]; ++c)
            for (int b = 0; b < each[1]; ++b)
              for (int a = 0; a < each[0]; ++a) {
                const Vector3d aside((a + 0.5) / each[0] - 0.5, (b + 0.5) / each[1] - 0.5,
                                     (c + 0.5) / each[2] - 0.5);
                double value = 0;
                if (!sample(volume, volume.grid.index(work.hu.grid.point(i, j, k) + step * aside), value))
                  continue;
                sum += value;
                ++held;
              }
          ++(held == all ? whole : held > 0 ? partly : unseen);
          // an integer; the sums round in another order
          EXPECT_NEAR(work.hu.at(i, j, k), held > 0 ? sum / held : -1000, 0.5 + 1e-9);
          EXPECT_EQ(work.seen.at(i, j, k), 2 * held > all);
        }
    EXPECT_GT(whole, 1000) << spacing.transpose();
    EXPECT_GT(unseen, 500) << spacing.transpose();
    // a single sample is visible or not, never partly
    EXPECT_EQ(partly > 100, all > 1) << spacing.transpose();
  }
}

TEST(WorkGrid, DensitiesBecomeCtNumbers) {
  EXPECT_EQ(hu_of(77, Quantity::hu), 77);
  EXPECT_EQ(hu_of(0, Quantity::density_kgm3), -1000);
  EXPECT_EQ(hu_of(1000, Quantity::density_kgm3), 0);
  // CT numbers of the ICRP 110 media (spongiosa 1205 kg/m3, cortex 1920 kg/m3) are 256 and 1149
  EXPECT_NEAR(hu_of(1205, Quantity::density_kgm3), 256, 1);
  EXPECT_NEAR(hu_of(1920, Quantity::density_kgm3), 1149, 1.5);
}

}  // namespace
}  // namespace borelli
