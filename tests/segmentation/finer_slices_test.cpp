#include "tests/suite/finer_slices.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

namespace borelli::suite::finer_slices_test {
namespace {

using Labeller = std::function<int(const Eigen::Vector3d&)>;

constexpr int outside = 0, wall = 1, inside = 2;
const std::array<float, 256> grey{0, 1, 0.5F};

// Labels at the middles of voxels of 2 x 2 x `step` mm, around the origin.
Volume<std::int16_t> drawn(const Labeller& label, double step, std::int64_t slices) {
  Volume<std::int16_t> out;
  out.grid.size = {64, 64, slices};
  out.grid.axes = Eigen::Vector3d(2, 2, step).asDiagonal();
  out.grid.origin = -0.5 * out.grid.axes * Eigen::Vector3d(63, 63, double(slices - 1));
  out.voxels.resize(out.grid.count());
  for (std::int64_t k = 0; k < slices; ++k)
    for (std::int64_t j = 0; j < 64; ++j)
      for (std::int64_t i = 0; i < 64; ++i) out.at(i, j, k) = std::int16_t(label(out.grid.point(i, j, k)));
  return out;
}

// A sphere of radius 45 mm that fills 41 mm, off the middle of a slice.
int sphere(const Eigen::Vector3d& p) {
  const double r = (p - Eigen::Vector3d(3, -2, 1.7)).norm();
  return r > 45 ? outside : r > 41 ? wall : inside;
}

// A tube whose axis leans by 45 degrees, wall 4 mm.
int leaning_tube(const Eigen::Vector3d& p) {
  const double r = std::hypot(p.x() - p.z(), p.y());
  return r > 20 ? outside : r > 16 ? wall : inside;
}

double share_wrong(const Volume<std::int16_t>& a, const Volume<std::int16_t>& b) {
  EXPECT_TRUE(a.grid == b.grid);
  double wrong = 0, all = 0;
  for (std::size_t n = 0; n < a.voxels.size(); ++n)
    wrong += a.voxels[n] != b.voxels[n], all += b.voxels[n] != outside;
  return wrong / all;
}

// Each slice `factor` times, on the grid of `exact`.
Volume<std::int16_t> repeated(const Volume<std::int16_t>& labels, int factor,
                              const Volume<std::int16_t>& exact) {
  Volume<std::int16_t> out = exact;
  for (std::size_t n = 0; n < out.voxels.size(); ++n) {
    const std::size_t plane = 64UL * 64UL;
    out.voxels[n] = labels.voxels[n / plane / std::size_t(factor) * plane + n % plane];
  }
  return out;
}

// The sphere's bound is larger, since no slice shows how its caps end.
TEST(FinerSlices, ApproximateShapesBetterThanRepeatedSlices) {
  struct Case {
    Labeller shape;
    double most;  // of the repeated slices' error
  };
  for (const Case& of : {Case{sphere, 0.55}, Case{leaning_tube, 0.34}})
    for (const int factor : {2, 3}) {
      const auto thick = drawn(of.shape, 8, 14), exact = drawn(of.shape, 8.0 / factor, 14 * factor);
      EXPECT_LT(share_wrong(finer_slices(thick, grey, factor), exact),
                of.most * share_wrong(repeated(thick, factor, exact), exact))
          << factor;
    }
}

TEST(FinerSlices, WallsOfLeaningTubesStayClosed) {
  const auto fine = finer_slices(drawn(leaning_tube, 8, 8), grey, 3);
  for (std::int64_t k = 1; k < fine.grid.size[2] - 1; ++k)
    for (std::int64_t j = 1; j < 63; ++j)
      for (std::int64_t i = 1; i < 63; ++i) {
        if (fine.at(i, j, k) != inside) continue;
        for (const int d : {-1, 1}) {
          EXPECT_NE(fine.at(i + d, j, k), outside);
          EXPECT_NE(fine.at(i, j + d, k), outside);
        }
      }
}

TEST(FinerSlices, KeepWhatDoesNotChange) {
  const auto column = [](const Eigen::Vector3d& p) { return p.head<2>().norm() < 30 ? inside : outside; };
  for (const int factor : {1, 2, 5}) {
    const auto thick = drawn(column, 8, 6);
    EXPECT_EQ(finer_slices(thick, grey, factor).voxels, drawn(column, 8.0 / factor, 6 * factor).voxels);
    EXPECT_EQ(finer_slices(drawn(sphere, 8, 14), grey, factor, 1).voxels,
              finer_slices(drawn(sphere, 8, 14), grey, factor, 5).voxels);
  }
}

}  // namespace
}  // namespace borelli::suite::finer_slices_test
