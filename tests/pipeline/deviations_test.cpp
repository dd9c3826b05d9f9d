#include "pipeline/deviations.hpp"

#include <gtest/gtest.h>

#include <cstdio>

#include "pipeline/recut.hpp"
#include "tests/pipeline/deviation_trials.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

const Phantom& standing() {
  static const Phantom phantom = build_phantom({}).value();
  return phantom;
}

TEST(Deviations, NoiseIsFoundInTheScan) {
  GridOptions coarse;
  coarse.spacing = Vector3d::Constant(6);
  const Grid grid = phantom_grid(standing(), coarse);
  for (const double noise : {0.0, 10.0, 30.0}) {
    const Scan scan = voxelise(standing(), grid, {.noise_hu = noise, .seed = 5});
    // fat beside muscle differs by less than three deviations of the larger noise, and stays in
    EXPECT_NEAR(estimate_noise(scan.grey, scan.labels), noise, 0.2 * noise) << noise;
  }
}

// A plane that moves by d through a limb of section A takes A d from one part and gives it to the other.
TEST(Deviations, RecutMovesWhatLiesBetweenThePlanes) {
  GridOptions coarse;
  coarse.spacing = Vector3d::Constant(4);
  const Scan scan = voxelise(standing(), phantom_grid(standing(), coarse));
  const auto weights = density_weights(Quantity::hu, *density_curve(default_density_curve));
  const Landmarks& exact = standing().landmarks;
  const Recut recut(scan.labels, scan.grey, *weights, PartPlanes(exact), 5);
  for (const PartGain& gain : recut.gains(PartPlanes(exact))) EXPECT_EQ(gain.mass, 0);
  Landmarks moved = exact;
  const Vector3d down(0, 0, -10);
  moved["xiphion"].point += down;
  const auto gains = recut.gains(PartPlanes(moved));
  double section = 0;  // mm^2, of the trunk from 10 mm below the xiphion to it
  const double z = exact.at("xiphion").point[2];
  double volume = 0;
  const Grid& g = scan.labels.grid;
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i)
        if (scan.labels.at(i, j, k) == part_label("middle_trunk") &&
            std::abs(g.point(Vector3d(double(i), double(j), double(k)))[2] - (z - 10)) < 10)
          volume += g.voxel_volume();
  section = volume / 20;
  // the sample's voxels between the planes, some 400 of 6000: 5 %
  EXPECT_NEAR(gains[static_cast<std::size_t>(part_label("upper_trunk"))].volume, section * 10 * 1e-9,
              0.07 * section * 10 * 1e-9);
  EXPECT_NEAR(gains[static_cast<std::size_t>(part_label("upper_trunk"))].mass +
                  gains[static_cast<std::size_t>(part_label("middle_trunk"))].mass,
              0, 1e-12);
}

// The exact value lies within two deviations in about 95 of 100 cases. All entries of 16 parts in a trial
// share its curve and landmarks; taken as no more than 16 independent cases a trial, n = 16 x 12 = 192 gives
// 0.95 a standard deviation of 0.016: from 0.90 to 0.998 are three of them. A longer run: deviations_bench.
TEST(Deviations, HoldTheExactValueInNineteenOfTwentyCases) {
  std::map<std::string, test::TrialCount> counts;
  for (std::uint32_t trial = 0; trial < 12; ++trial)
    test::try_deviations(standing(), 100 + trial, 5, 8, counts);
  test::TrialCount all;
  for (const auto& [entry, count] : counts) {
    all.cases += count.cases, all.within += count.within;
    std::printf("%-24s %5.1f %% within two, errors of %.2f deviations rms\n", entry.c_str(),
                100 * count.share(), std::sqrt(count.squares / count.cases));
    EXPECT_GE(count.share(), 0.85) << entry;
  }
  std::printf("all %.1f %%\n", 100 * all.share());
  EXPECT_GE(all.share(), 0.90);
  EXPECT_LE(all.share(), 0.998);
}

}  // namespace
}  // namespace borelli
