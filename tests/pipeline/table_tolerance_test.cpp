// The grid chosen for a tolerance: its table is compared with that of the finest grid, which the choice does
// not use.
#include "pipeline/body/table_tolerance.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "samples/phantom.hpp"
#include "samples/phantom_voxels.hpp"
#include "segmentation/files/read.hpp"
#include "tests/paths.hpp"

namespace borelli {
namespace {

InertiaTable table_by(const GreyVolume& volume, const Segmentation& found) {
  MeasureOptions options;
  options.deviations = false;
  return measure(volume, found.labels, found.landmarks, options, completeness_of(found.part)).value();
}

SegmentOptions by_step(double step) {
  SegmentOptions options;
  options.step = step;
  return options;
}

class TableToleranceOnBodies : public testing::TestWithParam<std::uint64_t> {};

TEST_P(TableToleranceOnBodies, EveryEntryStaysWithinItOfTheFinestGrid) {
  PhantomOptions body;
  body.variation = GetParam();
  body.sex = GetParam() % 2 ? Sex::female : Sex::male;
  GridOptions grid;
  grid.spacing.setConstant(3);
  ScanOptions scanner;
  scanner.noise_hu = 10;
  const Phantom phantom = build_phantom(body).value();
  const GreyVolume scan = voxelise(phantom, phantom_grid(phantom, grid), scanner).grey;
  std::vector<GridTable> tables;
  for (const double step : grids_to_try(scan))
    tables.push_back({step, table_by(scan, segment(scan, by_step(step)).value())});
  const InertiaTable& full = *tables.back().table;

  std::vector<double> picked;
  for (const double tolerance : {0.1, 0.05, 0.02, 0.01, 0.005}) {
    std::size_t n = 1;
    while (n + 1 < tables.size() && !judged(tables[n - 1], tables[n], tolerance, 3).met) ++n;
    double worst = 0;
    std::string where;
    for (const EntryErrors& e : entry_errors(*tables[n].table, full))
      if (e.largest() > worst) worst = e.largest(), where = e.part;
    EXPECT_LE(worst, tolerance) << where << ", grid of " << tables[n].step << " mm";
    picked.push_back(tables[n].step);
    RecordProperty(std::to_string(tolerance),
                   std::to_string(tables[n].step) + " mm, off by " + std::to_string(worst) + " in " + where);
  }
  EXPECT_TRUE(std::ranges::is_sorted(picked, std::greater()));  // a larger tolerance gives a coarser grid
  EXPECT_GT(picked.front(), picked.back());                     // coarser grids occur

  GridPick pick;
  const auto found = segment_within(scan, 0.05, {}, {}, pick);
  ASSERT_TRUE(found) << found.error().message();
  EXPECT_EQ(pick.step, picked[1]);
  EXPECT_EQ(found->labels.voxels, segment(scan, by_step(pick.step)).value().labels.voxels);
}

INSTANTIATE_TEST_SUITE_P(Drawn, TableToleranceOnBodies, testing::Values(0, 3));

TEST(TableTolerance, ReportsWhatTheIcrpMalesSlicesCannotGive) {
  const std::string file = test::shared_folder() + "/volumes/icrp_am/AM_hu.nii.gz";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "needs " << file;
  const auto scan = read_volume(file, {FileQuantity::hu, {}});
  ASSERT_TRUE(scan) << scan.error().message();
  GridPick pick;
  ASSERT_TRUE(segment_within(scan->volume, 0.01, {}, {}, pick));
  EXPECT_FALSE(pick.met);                                   // slices of 8 mm
  EXPECT_EQ(pick.against, 0);                               // no two grids to compare
  EXPECT_EQ(pick.step, grids_to_try(scan->volume).back());  // the finest grid
  EXPECT_NE(in_words(pick).find("does not reach 1 %"), std::string::npos) << in_words(pick);
}

TEST(TableTolerance, ErrorsAreRelativeToTheSegment) {
  InertiaRow row;
  row.part = "head";
  row.volume = 0.008;  // a cube of 0.2 m
  row.inertial = {8, {0, 0, 1}, Eigen::Vector3d(0.05, 0.06, 0.07).asDiagonal()};
  InertiaRow other = row;
  other.inertial = {8.08, {0.002, 0, 1}, Eigen::Vector3d(0.05, 0.06, 0.0665).asDiagonal()};
  const auto one = make_table({}, {row}), two = make_table({}, {other});
  const auto errors = entry_errors(two, one);
  ASSERT_EQ(errors.size(), 1u);
  EXPECT_NEAR(errors[0].mass, 0.01, 1e-12);
  EXPECT_NEAR(errors[0].centre, 0.01, 1e-12);
  EXPECT_NEAR(errors[0].moments, 0.05, 1e-12);
  other.completeness = Completeness::cut;  // no longer comparable
  EXPECT_EQ(entry_errors(make_table({}, {other}), one)[0].mass, 1);
}

TEST(TableTolerance, JudgesGridsByDifferencesAndLandmarkJumps) {
  InertiaRow row;
  row.part = "thigh_left";
  row.volume = 0.008;  // a cube of 0.2 m
  row.inertial = {8, {0, 0, 1}, Eigen::Vector3d(0.05, 0.06, 0.07).asDiagonal()};
  InertiaRow other = row;
  other.inertial.mass *= 1.02;
  const GridTable coarse{6, make_table({}, {other})}, fine{4.5, make_table({}, {row})};
  // limb joints move by a quarter of the coarsest edge, here 1 mm in 200; moments change by 2.5 times that
  // share
  const GridPick five = judged(coarse, fine, 0.05, 4);
  EXPECT_TRUE(five.met);
  EXPECT_EQ(five.step, 4.5);
  EXPECT_EQ(five.against, 6);
  EXPECT_NEAR(five.errors.at(0).mass, 0.04, 1e-12);  // twice the difference
  EXPECT_NEAR(five.errors.at(0).moments, 0.0125, 1e-12);
  EXPECT_FALSE(judged(coarse, fine, 0.03, 4).met);
  EXPECT_FALSE(judged(coarse, fine, 0.05, 20).met);  // slices of 20 mm
  const GridPick alone = judged({8, {}}, fine, 0.05, 4);
  EXPECT_FALSE(alone.met);
  EXPECT_NE(in_words(alone).find("no parts to compare with"), std::string::npos) << in_words(alone);
}

TEST(TableTolerance, ReportsVoxelsThatCannotReachIt) {
  InertiaRow row;
  row.part = "hand_left";
  row.volume = 4e-4;
  row.inertial = {0.4, {0, 0, 1}, 1e-4 * Eigen::Matrix3d::Identity()};
  // by cause: voxels 0.3 and 0.4 %, and planes 5 %, which do not depend on voxels
  row.deviations = {{"mass_kg", 0.02, {0.0012, 0.0016, 0.02}}};
  InertiaTable table = make_table({}, {row});
  table.rows[0].deviations = row.deviations;
  table.causes = {"noise", "voxel_size", "cut_planes"};
  EXPECT_EQ(beyond_the_voxels(table, 0.01), "");
  const std::string said = beyond_the_voxels(table, 0.0049);
  EXPECT_NE(said.find("0.49 % is below"), std::string::npos) << said;
  EXPECT_NE(said.find("0.5 % for hand_left mass_kg"), std::string::npos) << said;
}

TEST(TableTolerance, IsReadAsFractionOrPercent) {
  EXPECT_DOUBLE_EQ(parse_tolerance("1%").value(), 0.01);
  EXPECT_DOUBLE_EQ(parse_tolerance(" 0.5 %").value(), 0.005);
  EXPECT_DOUBLE_EQ(parse_tolerance("0.02").value(), 0.02);
  for (const char* wrong : {"", "%", "1 percent", "-1%", "0.01%", "60%", "1", "nan", "1%%"})
    EXPECT_FALSE(parse_tolerance(wrong)) << wrong;
}

}  // namespace
}  // namespace borelli
