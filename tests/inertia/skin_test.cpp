#include "inertia/skin.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "inertia/density.hpp"

namespace borelli::skin_test {
namespace {

using Eigen::Vector3d;

// CT numbers of muscle and air, rounded or not
using Image = Volume<double>;

// A hand (ellipsoid, semi-axes 15, 40, 90 mm, muscle of 50 HU) in air, oblique in a cubic grid of step h: by
// voxel centres, or as box averages (to 1e-3, from 10^3 points in each voxel at the border).
constexpr double hand_hu = 50, air_hu = -1000;
const Vector3d hand_semi(15, 40, 90);

Image draw_hand(double h, bool averages) {
  Image image;
  image.grid.axes *= h;
  const auto n = static_cast<std::int64_t>(std::ceil(230 / h));
  image.grid.size = {n, n, n};
  const Eigen::Matrix3d R = Eigen::AngleAxisd(0.9, Vector3d(1, -2, 0.7).normalized()).toRotationMatrix();
  const Vector3d centre(115.3, 114.9, 115.1);
  const auto level = [&](const Vector3d& p) {
    return (hand_semi.cwiseInverse().asDiagonal() * (R.transpose() * (p - centre))).norm();
  };
  for (std::int64_t k = 0; k < n; ++k)
    for (std::int64_t j = 0; j < n; ++j)
      for (std::int64_t i = 0; i < n; ++i) {
        const Vector3d p =
            h * Vector3d(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
        double inside = level(p) < 1;
        if (averages && std::abs(level(p) - 1) < 0.87 * h / hand_semi.minCoeff()) {
          inside = 0;
          for (int s = 0; s < 1000; ++s)
            inside +=
                1e-3 *
                (level(p + h * (Vector3d(s % 10, s / 10 % 10, s / 100) / 10 - Vector3d::Constant(0.45))) < 1);
        }
        image.voxels.push_back(air_hu + inside * (hand_hu - air_hu));
      }
  return image;
}

// Gaussian blur with standard deviation sigma (mm) along each axis; preserves the sum of CT numbers above
// air.
void blur(Image& image, double sigma) {
  const double h = image.grid.axes(0, 0);
  const auto reach = static_cast<std::int64_t>(std::ceil(5 * sigma / h));
  std::vector<double> kernel;
  for (std::int64_t d = -reach; d <= reach; ++d)
    kernel.push_back(std::exp(-0.5 * std::pow(static_cast<double>(d) * h / sigma, 2)));
  double sum = 0;
  for (const double w : kernel) sum += w;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Image from = image;
    std::array<std::int64_t, 3> v;
    for (v[2] = 0; v[2] < image.grid.size[2]; ++v[2])
      for (v[1] = 0; v[1] < image.grid.size[1]; ++v[1])
        for (v[0] = 0; v[0] < image.grid.size[0]; ++v[0]) {
          double value = 0;
          for (std::int64_t d = -reach; d <= reach; ++d) {
            auto at = v;
            at[axis] = std::clamp<std::int64_t>(at[axis] + d, 0, image.grid.size[axis] - 1);
            value += kernel[static_cast<std::size_t>(d + reach)] / sum * from.at(at[0], at[1], at[2]);
          }
          image.at(v[0], v[1], v[2]) = value;
        }
  }
}

struct Scan {
  LabelMap labels;
  GreyVolume grey;
};

// CT numbers with noise, rounded, and a label map of voxels that are more than half body without noise
Scan scan_of(const Image& image, double noise = 0) {
  Scan scan;
  scan.labels.grid = scan.grey.grid = image.grid;
  std::mt19937 random(1);
  std::normal_distribution<double> draw(0, 1);
  for (const double hu : image.voxels) {
    scan.labels.voxels.push_back(hu > 0.5 * (hand_hu + air_hu));
    scan.grey.voxels.push_back(static_cast<std::int16_t>(std::lround(hu + noise * draw(random))));
  }
  return scan;
}

// density linear from 0 in air to 1050 kg/m^3 in the hand and beyond
DensityCurve straight_curve() { return {"straight", "", {{air_hu, 0}, {hand_hu, 1050}, {1100, 2100}}}; }

double mass_error(const LabelMap& labels, const GreyVolume& grey, BelowAir below) {
  const auto weights = density_weights(Quantity::hu, straight_curve(), below);
  const auto moments = label_moments(labels, grey, *weights);
  const double exact = 1050 * 4. / 3 * std::numbers::pi * hand_semi.prod() * 1e-9;
  return to_inertial((*moments)[1], labels.grid, Sampling::averages).mass / exact - 1;
}

TEST(Skin, GrowingRecoversTwoPercentOfABlurredHand) {
  Image image = draw_hand(2, true);
  blur(image, 1);
  const Scan scan = scan_of(image);
  EXPECT_LT(mass_error(scan.labels, scan.grey, BelowAir::hold), -0.02);
  // nothing lies beyond two rings, four standard deviations; 5e-4 for the occupancy, which has errors of 1e-3
  // per border voxel
  EXPECT_NEAR(mass_error(grow_skin(scan.labels), scan.grey, BelowAir::hold), 0, 5e-4);
}

// For any tightness of the label map: voxels at least half or nine tenths body.
TEST(Skin, VolumeOfABlurredHandEqualsTheEllipsoid) {
  Image image = draw_hand(2, true);
  blur(image, 1);
  Scan scan = scan_of(image);
  const auto weights = density_weights(Quantity::hu, straight_curve(), BelowAir::straight);
  const double exact = 4. / 3 * std::numbers::pi * hand_semi.prod() / scan.grey.grid.voxel_volume();
  for (const double share : {0.5, 0.9}) {
    double counted = 0;
    for (std::size_t o = 0; o < image.voxels.size(); ++o)
      counted += scan.labels.voxels[o] = image.voxels[o] > air_hu + share * (hand_hu - air_hu);
    const auto grown = label_moments(grow_skin(scan.labels, 4), scan.grey, *weights);
    const auto volumes = volumes_with_skin(scan.labels, scan.grey, *weights, *grown, 4);
    ASSERT_TRUE(volumes) << volumes.error().message();
    EXPECT_NEAR(volumes->all[1] / exact, 1, 5e-4) << share;  // as exact as the mass
    EXPECT_GT(volumes->skin[1], 0.1 * exact);
    if (share > 0.5) {
      EXPECT_LT(counted / exact, 0.95);
    }
  }
  scan.labels.voxels.assign(scan.labels.voxels.size(), 0);
  const auto none = label_moments(scan.labels, scan.grey, *weights);
  EXPECT_EQ(volumes_with_skin(scan.labels, scan.grey, *weights, *none)->all[1], 0);
}

TEST(Skin, GrowthAndSheppardCorrectTheTensorOfABlurredHand) {
  const Image image = draw_hand(3, true);
  const Scan scan = scan_of(image);
  const auto weights = density_weights(Quantity::hu, straight_curve());
  const auto grown = label_moments(grow_skin(scan.labels, 0), scan.grey, *weights);
  const auto bare = label_moments(scan.labels, scan.grey, *weights);
  const Vector3d s = (1e-3 * hand_semi).array().square();
  const double mass = 1050 * 4. / 3 * std::numbers::pi * hand_semi.prod() * 1e-9;
  const Vector3d exact = mass / 5 * Vector3d(s[0] + s[1], s[0] + s[2], s[1] + s[2]);
  const Vector3d with = to_inertial((*grown)[1], scan.grey.grid, Sampling::averages).principal().moments;
  const Vector3d without = to_inertial((*bare)[1], scan.grey.grid, Sampling::averages).principal().moments;
  for (int n = 0; n < 3; ++n) {
    EXPECT_NEAR(with[n] / exact[n], 1, 5e-4) << n;    // occupancy: 1e-3 in 5000 border voxels of 9000
    EXPECT_LT(without[n] / exact[n], 1 - 0.02) << n;  // loss without the skin at 3 mm
  }
}

TEST(Skin, NoiseOfAirAveragesOutOnlyWithLinearWeights) {
  const Scan scan = scan_of(draw_hand(2, true), 30);
  const LabelMap grown = grow_skin(scan.labels);
  std::int64_t added = 0, body = 0;
  for (std::size_t n = 0; n < grown.voxels.size(); ++n)
    added += grown.voxels[n] != scan.labels.voxels[n], body += scan.labels.voxels[n] != 0;
  // three deviations of the sum: 30 of 1050 HU over the root of the number of voxels
  const double chance =
      3 * 30. / 1050 * std::sqrt(static_cast<double>(added + body)) / static_cast<double>(body);
  EXPECT_NEAR(mass_error(grown, scan.grey, BelowAir::straight), 0, chance + 5e-4);
  // the positive half of the noise has the mean 30 / sqrt(2 pi) = 12 HU, in about two thirds of the added
  // voxels
  EXPECT_GT(mass_error(grown, scan.grey, BelowAir::hold),
            0.5 * 12. / 1050 * static_cast<double>(added) / static_cast<double>(body));
}

TEST(Skin, BelongsToTheNearestPartOnAnisotropicGrids) {
  LabelMap labels;
  labels.grid.size = {9, 9, 9};
  labels.grid.axes = Vector3d(1, 1, 5).asDiagonal();
  labels.voxels.assign(labels.grid.count(), 0);
  labels.at(4, 4, 4) = 7;
  labels.at(8, 4, 4) = 9;
  const LabelMap grown = grow_skin(labels, 2);  // three voxels along i and j, one along k
  EXPECT_EQ(grown.at(4, 4, 4), 7);
  EXPECT_EQ(grown.at(5, 4, 4), 7);
  EXPECT_EQ(grown.at(7, 4, 4), 9);
  EXPECT_EQ(grown.at(4, 1, 4), 7);
  EXPECT_EQ(grown.at(4, 0, 4), 0);
  EXPECT_EQ(grown.at(4, 4, 5), 7);
  EXPECT_EQ(grown.at(4, 4, 6), 0);
  EXPECT_EQ(grown.at(8, 7, 3), 9);
  EXPECT_EQ(grown.at(0, 4, 4), 0);
}

TEST(Skin, MixedVoxelsDistinguishAveragesFromPoints) {
  const auto weights = density_weights(Quantity::hu, *density_curve(default_density_curve));
  const Scan points = scan_of(draw_hand(2, false), 60), averages = scan_of(draw_hand(2, true), 60);
  const auto of_points = mixed_share(points.labels, points.grey, *weights);
  const auto of_averages = mixed_share(averages.labels, averages.grey, *weights);
  ASSERT_TRUE(of_points && of_averages);
  EXPECT_LT(*of_points, 0.01);
  EXPECT_GT(*of_averages, 0.2);
  EXPECT_EQ(sampling_by(*of_points), Sampling::points);
  EXPECT_EQ(sampling_by(*of_averages), Sampling::averages);
}

}  // namespace
}  // namespace borelli::skin_test
