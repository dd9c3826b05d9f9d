// Errors of tables by coarser voxels, coarser grids and other density curves: against tables made here and
// properties of means.
#include "pipeline/charts/volume_economy.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "samples/phantom.hpp"
#include "samples/phantom_voxels.hpp"

namespace borelli {
namespace {

TEST(VolumeEconomy, CoarserVoxelsKeepSumAndPosition) {
  GreyVolume fine;
  fine.grid.size = {8, 6, 5};
  fine.grid.axes << 1, 0.1, 0, 0, 2, 0.2, 0.1, 0, 3;  // sheared
  fine.grid.origin << 10, -20, 30;
  fine.voxels.assign(fine.grid.count(), 0);
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double sum = 0;
  for (std::int64_t k = 0; k < 4; ++k)  // the fifth layer is dropped
    for (std::int64_t j = 0; j < 6; ++j)
      for (std::int64_t i = 0; i < 8; ++i) {
        // multiples of the block's number of voxels, so that means are exact
        const int value = int(12 * ((i / 2 + 3 * (j / 3) + 5 * (k / 2)) % 7));
        fine.at(i, j, k) = std::int16_t(value);
        sum += value;
        centre += value * fine.grid.point(Eigen::Vector3d(double(i), double(j), double(k)));
      }
  const GreyVolume coarse = coarsened(fine, {2, 3, 2});
  EXPECT_EQ(coarse.grid.size, (std::array<std::int64_t, 3>{4, 2, 2}));
  Eigen::Vector3d coarse_centre = Eigen::Vector3d::Zero();
  double coarse_sum = 0;
  for (std::int64_t k = 0; k < 2; ++k)
    for (std::int64_t j = 0; j < 2; ++j)
      for (std::int64_t i = 0; i < 4; ++i) {
        const double value = coarse.at(i, j, k);
        coarse_sum += value;
        coarse_centre += value * coarse.grid.point(Eigen::Vector3d(double(i), double(j), double(k)));
      }
  EXPECT_EQ(12 * coarse_sum, sum);
  EXPECT_NEAR((coarse_centre / coarse_sum - centre / sum).norm(), 0, 1e-12);
  EXPECT_NEAR(coarse.grid.voxel_volume(), 12 * fine.grid.voxel_volume(), 1e-9);
}

TEST(VolumeEconomy, TriesDifferentCoarserVoxels) {
  Grid grid;
  grid.size = {300, 300, 100};
  grid.axes.diagonal() << 1.5, 1.5, 5;
  const auto tried = coarser_voxels(grid);
  ASSERT_FALSE(tried.empty());
  EXPECT_EQ(tried.front(), (std::array<std::int64_t, 3>{2, 2, 1}));  // 3 x 3 x 5 mm
  EXPECT_EQ(tried.back(), (std::array<std::int64_t, 3>{5, 5, 2}));   // 7.5 x 7.5 x 10 mm
  for (std::size_t i = 1; i < tried.size(); ++i) EXPECT_NE(tried[i], tried[i - 1]);
}

TEST(VolumeEconomy, ErrorsEqualThoseOfSeparateTables) {
  GridOptions grid;
  grid.spacing.setConstant(4);
  PhantomOptions body;  // small, to save time
  body.child = true;
  const Phantom phantom = build_phantom(body).value();
  const GreyVolume scan = voxelise(phantom, phantom_grid(phantom, grid), {}).grey;
  const VolumeEconomy e = volume_economy(scan, 0.05).value();
  const auto table = [](const GreyVolume& volume, double step) {
    SegmentOptions options;
    options.step = step;
    const auto found = segment(volume, options).value();
    MeasureOptions how;
    how.deviations = false;
    return std::pair(measure(volume, found.labels, found.landmarks, how, completeness_of(found.part)), found);
  };
  const double finest = grids_to_try(scan).back();
  const auto [measured, parts_found] = table(scan, finest);
  const InertiaTable& whole = measured.value();
  const auto worst = [&](const InertiaTable& other) {
    double most = 0;
    for (const EntryErrors& error : entry_errors(other, whole)) most = std::max(most, error.largest());
    return most;
  };
  int grids = 0, voxels = 0, curves = 0;
  for (const VolumeTrial& trial : e.trials) {
    ASSERT_TRUE(trial.reason.empty()) << trial.name << ": " << trial.reason;
    for (std::size_t c = 0; c < std::size(parts_choices); ++c)
      EXPECT_EQ(int(trial.errors[c].size()), parts_choices[c].count);
    if (trial.of == VolumeTrial::Of::work_grid) {
      ++grids;
      if (trial.size == 6) {
        EXPECT_EQ(trial.worst(0), worst(table(scan, 6).first.value()));
      }
    } else if (trial.of == VolumeTrial::Of::voxels) {
      ++voxels;
    } else {
      ++curves;
      EXPECT_EQ(trial.worst(0) == 0, trial.name == e.curve) << trial.name;
      if (trial.name == "geant4") {
        MeasureOptions how;
        how.deviations = false;
        how.density_curve = trial.name;
        EXPECT_EQ(trial.worst(0), worst(measure(scan, parts_found.labels, parts_found.landmarks, how,
                                                completeness_of(parts_found.part))
                                            .value()));
      }
    }
  }
  EXPECT_EQ(grids, int(grids_to_try(scan).size()));
  EXPECT_EQ(voxels, int(coarser_voxels(scan.grid).size()) + 1);
  EXPECT_GT(curves, 2);
  EXPECT_EQ(e.trials.front().worst(0), 0);
  // a pick meets the request
  const VolumeTrial* pick = e.pick(VolumeTrial::Of::work_grid, 2);
  ASSERT_NE(pick, nullptr);
  EXPECT_LE(pick->worst(2), 0.05);
  for (const auto& [name, plot] : volume_economy_plots(e))
    EXPECT_NE(svg(plot).find("</svg>"), std::string::npos);
}

TEST(VolumeEconomy, PicksNothingCoarserThanAFailedTrial) {
  const auto trial = [](double size, double error) {
    return VolumeTrial{
        .of = VolumeTrial::Of::work_grid, .size = size, .errors = {{{.part = "head", .mass = error}}}};
  };
  VolumeEconomy e{.tolerance = 0.05,
                  .trials = {trial(2, 0), trial(4.5, 0.003), trial(3.5, 0.07), trial(3, 0.02)}};
  ASSERT_NE(e.pick(VolumeTrial::Of::work_grid, 0), nullptr);
  EXPECT_EQ(e.pick(VolumeTrial::Of::work_grid, 0)->size, 3);
}

TEST(VolumeEconomy, PicksNothingBelowTheReferencesOwnError) {
  const auto trial = [](VolumeTrial::Of of, double size, double error) {
    VolumeTrial made{.of = of, .size = size, .name = fmt::format("{:g} mm", size)};
    made.errors.assign(std::size(parts_choices), {{.part = "head", .mass = error}});
    return made;
  };
  using Of = VolumeTrial::Of;
  VolumeEconomy e{
      .tolerance = 0.01,
      .trials = {trial(Of::work_grid, 3, 0), trial(Of::voxels, 4, 0), trial(Of::work_grid, 4.5, 0.001),
                 trial(Of::work_grid, 3.5, 0.02), trial(Of::voxels, 8, 0.002)}};
  EXPECT_EQ(e.doubt(0), 0.02);  // from 3 and 3.5 mm, not from 4.5 mm, which is accidentally smaller
  for (const auto& [of, finest] : {std::pair(Of::voxels, 4.), std::pair(Of::work_grid, 3.)}) {
    ASSERT_NE(e.pick(of, 0), nullptr);
    EXPECT_EQ(e.pick(of, 0)->size, finest);
  }
  const auto words = in_words(e);
  EXPECT_NE(words[0].find("a grid of 3 mm, the finest that was tried"), std::string::npos) << words[0];
  EXPECT_NE(words[0].find("the grid of 3.5 mm differ by 2 % (16 parts)"), std::string::npos) << words[0];
  EXPECT_EQ(words[1],
            "16 parts within 1 %: nothing coarser than a work grid of 3 mm is chosen, and whether it "
            "suffices is unknown");
  e.tolerance = 0.03;
  ASSERT_NE(e.pick(Of::voxels, 0), nullptr);
  EXPECT_EQ(e.pick(Of::voxels, 0)->size, 8);
  for (const auto& [name, plot] : volume_economy_plots(e))
    if (name.ends_with("error")) {
      EXPECT_NE(plot.notes.at(0).find("grid of 3 mm"), std::string::npos);
    }
}

TEST(VolumeEconomy, PicksNoTrialWithoutATable) {
  VolumeEconomy e{.tolerance = 0.1,
                  .trials = {{.of = VolumeTrial::Of::voxels, .size = 8, .reason = "no body"}}};
  EXPECT_EQ(e.pick(VolumeTrial::Of::voxels, 0), nullptr);
  EXPECT_TRUE(std::isinf(e.trials[0].worst(1)));
}

}  // namespace
}  // namespace borelli
