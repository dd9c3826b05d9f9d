// Tables of selected segments: a part has the same numbers as in the whole table; a group has those of its
// parts' labels merged into one.
#include "pipeline/body/segment_rows.hpp"

#include <gtest/gtest.h>

#include "inertia/table_file.hpp"
#include "samples/phantom.hpp"
#include "samples/phantom_voxels.hpp"

namespace borelli::segment_rows_test {
namespace {

const Phantom& standing() {
  static const Phantom phantom = build_phantom({}).value();
  return phantom;
}

// a scan with partial voxels at the skin, where a part's numbers depend on its neighbours
const Scan& blurred() {
  static const Scan scan = [] {
    GridOptions grid;
    grid.spacing.setConstant(5);
    grid.rotation_deg << 7, -4, 11;
    ScanOptions options;
    options.partial_volume = true;
    options.blur_mm = 1, options.noise_hu = 10;
    return voxelise(standing(), phantom_grid(standing(), grid), options);
  }();
  return scan;
}

InertiaTable table_of(const LabelMap& labels, const std::string& segments) {
  MeasureOptions options;
  options.sex = "male";
  options.segments = choose_segments(segments, labels.names).value();
  return measure(blurred().grey, labels, standing().landmarks, options).value();
}

const InertiaTable& whole_table() {
  static const InertiaTable table = table_of(blurred().labels, "");
  return table;
}

const InertiaRow& row(const InertiaTable& table, const std::string& part) {
  return *std::ranges::find(table.rows, part, &InertiaRow::part);
}

void expect_same_deviations(const InertiaRow& a, const InertiaRow& b) {
  ASSERT_EQ(a.deviations.size(), b.deviations.size()) << a.part;
  for (std::size_t n = 0; n < a.deviations.size(); ++n) {
    EXPECT_EQ(a.deviations[n].entry, b.deviations[n].entry);
    EXPECT_EQ(a.deviations[n].by_cause, b.deviations[n].by_cause) << a.part << " " << a.deviations[n].entry;
  }
}

TEST(SegmentRows, SinglePartEqualsTheWholeTablesBitForBit) {
  const InertiaTable some = table_of(blurred().labels, "thigh_left,head");
  ASSERT_EQ(some.rows.size(), 2u);
  EXPECT_EQ(some.source.segments, "thigh_left,head");
  for (const InertiaRow& asked : some.rows) {
    const InertiaRow& known = row(whole_table(), asked.part);
    EXPECT_EQ(asked.inertial.mass, known.inertial.mass);
    EXPECT_EQ(asked.inertial.centre, known.inertial.centre);
    EXPECT_EQ(asked.inertial.tensor, known.inertial.tensor);
    EXPECT_EQ(asked.volume, known.volume);
    EXPECT_EQ(asked.notes, known.notes);
    EXPECT_EQ(some.share(asked), whole_table().share(known));
    expect_same_deviations(asked, known);
  }
  // shares are relative to the whole body, which the file keeps
  EXPECT_EQ(some.whole.inertial.mass, whole_table().whole.inertial.mass);
  EXPECT_EQ(some.whole.completeness, Completeness::whole);
  const auto read = table_from_json(to_json(some), "table.json");
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->rows.size(), 2u);
  EXPECT_EQ(read->source.segments, "thigh_left,head");
  EXPECT_DOUBLE_EQ(read->share(read->rows[0]), some.share(some.rows[0]));
}

// A group sums over its parts' labels. A single label for all of them, which is summed, grown and corrected
// at once, must give the same.
TEST(SegmentRows, GroupEqualsOneLabelForItsParts) {
  const InertiaTable groups = table_of(blurred().labels, "trunk,arm_right,leg_left");
  const std::string rest = "head,arm_left,leg_right";
  const InertiaTable as_one = table_of(
      labels_of_segments(blurred().labels, choose_segments("trunk,arm_right,leg_left," + rest).value()), "");
  ASSERT_EQ(groups.rows.size(), 3u);
  for (const InertiaRow& group : groups.rows) {
    const InertiaRow& one = row(as_one, group.part);
    // rounding of sums of about 1e5 voxels in another order
    EXPECT_NEAR(group.inertial.mass, one.inertial.mass, 1e-11 * one.inertial.mass) << group.part;
    // volumes of skin voxels depend on the tissue below, one mean per label
    EXPECT_NEAR(group.volume, one.volume, 2e-3 * one.volume);
    EXPECT_LT((group.inertial.centre - one.inertial.centre).norm(), 1e-11) << group.part;
    EXPECT_LT((group.inertial.tensor - one.inertial.tensor).cwiseAbs().maxCoeff(),
              1e-10 * one.inertial.tensor.maxCoeff())
        << group.part;
    EXPECT_EQ(group.completeness, Completeness::whole);
    EXPECT_FALSE(group.deviations.empty());
  }
}

// three stacked slabs of unit voxels are one box: n voxels along an axis have the variance (n^2 - 1) / 12
TEST(SegmentRows, SlabsOfATrunkAddUpToABox) {
  GreyVolume grey;
  grey.grid.size = {12, 8, 20};
  grey.grid.axes *= 10;
  grey.quantity = Quantity::density_kgm3;
  LabelMap labels;
  labels.grid = grey.grid;
  for (const Part& part : parts) labels.names.emplace_back(part.name);
  const std::array<std::uint8_t, 3> upwards{4, 3, 2};
  for (std::int64_t k = 0; k < 20; ++k)
    for (std::int64_t j = 0; j < 8; ++j)
      for (std::int64_t i = 0; i < 12; ++i) {
        const bool in = i >= 1 && i < 11 && j >= 1 && j < 7 && k >= 1 && k < 19;
        grey.voxels.push_back(in ? 1000 : 0);
        labels.voxels.push_back(in ? upwards[static_cast<std::size_t>(k < 6 ? 0 : k < 13 ? 1 : 2)] : 0);
      }
  MeasureOptions options;
  options.sampling = Sampling::points;
  options.segments = choose_segments("trunk").value();
  const InertiaTable table = measure(grey, labels, {}, options).value();
  ASSERT_EQ(table.rows.size(), 1u);
  const Inertial& box = table.rows[0].inertial;
  const double mass = 10 * 6 * 18 * 1e-3;
  const Eigen::Vector3d variance = Eigen::Vector3d(99, 35, 323) / 12 * 1e-4;
  EXPECT_NEAR(box.mass, mass, 1e-12);
  EXPECT_LT((box.centre - Eigen::Vector3d(55, 35, 95) * 1e-3).norm(), 1e-12);
  EXPECT_NEAR(box.tensor(0, 0), mass * (variance[1] + variance[2]), 1e-12);
  EXPECT_NEAR(box.tensor(1, 1), mass * (variance[0] + variance[2]), 1e-12);
  EXPECT_NEAR(box.tensor(2, 2), mass * (variance[0] + variance[1]), 1e-12);
}

TEST(SegmentRows, TrunkIsComparedWithDeLevas) {
  const InertiaTable table = table_of(blurred().labels, "trunk,arm_left");
  const Comparison beside = compare(table, table.rows[0], "deleva1996");
  ASSERT_TRUE(beside.published) << beside.why_not;
  EXPECT_TRUE(beside.mass && beside.shape);
  EXPECT_DOUBLE_EQ(beside.published->mass_share, 0.4346);  // male, SUPR-MIDH
  EXPECT_EQ(table.rows[0].frame->from, "SUPR");
  EXPECT_TRUE(table.rows[1].frame);
  EXPECT_FALSE(compare(table, table.rows[1], "deleva1996").published);  // a bent arm has no length
}

TEST(SegmentRows, MissingPartsAreReported) {
  LabelMap labels = blurred().labels;
  const auto drop = [&](const char* name) {
    for (auto& label : labels.voxels)
      if (label == part_label(name)) label = 0;
  };
  drop("hand_left"), drop("head");
  const InertiaTable table = table_of(labels, "arm_left,head,trunk");
  EXPECT_EQ(table.rows[0].completeness, Completeness::cut);
  EXPECT_EQ(table.rows[0].notes.back(), "hand_left: absent");
  EXPECT_EQ(table.rows[1].completeness, Completeness::absent);
  EXPECT_EQ(table.rows[2].completeness, Completeness::whole);
  MeasureOptions options;
  options.segments = choose_segments("head").value();
  const auto none = measure(blurred().grey, labels, {}, options);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().message(), "--segments head: none of these segments is in the scan");
}

}  // namespace
}  // namespace borelli::segment_rows_test
