// Labels, findings and landmarks of another body, or moved ones, are recognised as not belonging to the scan.
#include "pipeline/body/belonging.hpp"

#include <gtest/gtest.h>

#include "pipeline/body/given_labels.hpp"
#include "pipeline/body/measure.hpp"
#include "samples/phantom_voxels.hpp"

namespace borelli {
namespace {

const Phantom& standing() {
  static const Phantom phantom = build_phantom({}).value();
  return phantom;
}

Scan scan_of(double h) {
  GridOptions grid;
  grid.spacing.setConstant(h);
  Scan scan = voxelise(standing(), phantom_grid(standing(), grid),
                       {.partial_volume = true, .blur_mm = 0.7, .noise_hu = 20, .seed = 3});
  return scan;
}

LabelMap moved(const LabelMap& labels, std::int64_t by_x, std::int64_t by_z) {
  LabelMap to = labels;
  const Grid& g = labels.grid;
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i)
        to.at(i, j, k) = g.holds(i - by_x, j, k - by_z) ? labels.at(i - by_x, j, k - by_z) : std::uint8_t{0};
  return to;
}

TEST(Belonging, DisplacedLabelsAreDoubtedByTheAirTheyHold) {
  const Scan scan = scan_of(4);
  const LabelsInAir sound = labels_in_air(scan.grey, scan.labels);
  EXPECT_TRUE(sound.doubtful.empty());  // lungs and gut count as body
  EXPECT_EQ(in_words(sound, scan.labels), "");
  EXPECT_LT(sound.bare, 0.01);
  for (const auto& [x, z] : {std::pair{3, 0}, {15, 15}}) {
    const LabelMap off = moved(scan.labels, x, z);
    const LabelsInAir air = labels_in_air(scan.grey, off);
    // air by the drawn body's own labels
    std::array<double, 256> held{}, outside{};
    double all = 0, out = 0;
    for (std::size_t o = 0; o < off.voxels.size(); ++o)
      if (const auto label = off.voxels[o]) {
        const bool in_air = scan.labels.voxels[o] == 0;
        ++all, out += in_air, ++held[label], outside[label] += in_air;
      }
    // skin voxels between a fifth and half body count there and not here: a quarter of a voxel of 4 mm around
    // limbs of 80 to 100 mm
    EXPECT_NEAR(air.all, out / all, 0.02) << x;
    for (std::size_t n = 1; n < parts.size(); ++n)
      EXPECT_NEAR(air.share[n], outside[n] / held[n], 0.08) << x << ' ' << parts[n].name;
    EXPECT_NE(in_words(air, off).find("do not fit the scan"), std::string::npos);

    Segmentation given = segmentation_of(off, {}, scan.grey, 0);
    doubt_what_is_air(air, given);
    const auto hand = static_cast<std::size_t>(part_label("hand_left"));
    EXPECT_EQ(given.part[hand].coverage, Coverage::cut);
    EXPECT_NE(given.part[hand].note.find("air outside the body"), std::string::npos) << given.part[hand].note;
  }
}

TEST(Belonging, RefusesFindingsOfAnotherLabelMap) {
  const Scan scan = scan_of(6);
  const Segmentation own = segmentation_of(scan.labels, {}, scan.grey, 0);
  const auto same = compare_volumes(own.part, scan.labels);
  ASSERT_TRUE(same);
  EXPECT_EQ(*same, "");
  // one border moved by hand: reported, but accepted
  LabelMap mended = scan.labels;
  std::size_t left = 2000;
  const auto shank = part_label("shank_left"), thigh = part_label("thigh_left");
  for (auto& label : mended.voxels)
    if (label == shank && left > 0) label = static_cast<std::uint8_t>(thigh), --left;
  const auto told = compare_volumes(own.part, mended);
  ASSERT_TRUE(told) << told.error().message();
  EXPECT_NE(told->find("shank_left"), std::string::npos) << *told;
  EXPECT_EQ(told->find("hand_left"), std::string::npos) << *told;
  // a body of another size
  auto other = own.part;
  for (auto& part : other) part.volume *= 1.1;
  const auto refused = compare_volumes(other, scan.labels);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message().find("16 of 16 parts"), std::string::npos) << refused.error().message();
  // a map of some parts is judged by those alone
  LabelMap some = scan.labels;
  for (auto& label : some.voxels)
    if (label != thigh) label = 0;
  for (std::size_t n = 1; n < some.names.size(); ++n)
    if (n != static_cast<std::size_t>(thigh)) some.names[n] = "";
  EXPECT_EQ(compare_volumes(own.part, some).value(), "");
}

TEST(Belonging, RefusesJointCentresOfAnotherPose) {
  const Scan scan = scan_of(6);
  EXPECT_EQ(compare_joints(standing().landmarks, scan.labels).value(), "");
  Landmarks one = standing().landmarks;
  one["knee_left"].point[2] += 150;
  const auto told = compare_joints(one, scan.labels);
  ASSERT_TRUE(told);
  EXPECT_NE(told->find("1 of 15 joint centres"), std::string::npos) << *told;
  EXPECT_NE(told->find("knee_left"), std::string::npos) << *told;
  Landmarks mirrored = standing().landmarks;  // RAS taken for LPS
  for (auto& [name, landmark] : mirrored) landmark.point[0] *= -1, landmark.point[1] *= -1;
  const auto refused = compare_joints(mirrored, scan.labels);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message().find("another body"), std::string::npos);
}

TEST(Belonging, ReportsSwappedSides) {
  LabelMap labels = scan_of(8).labels;
  EXPECT_EQ(compare_sides(labels), "");
  const auto exchange = [&](const std::string& stem) {
    std::swap(labels.names[static_cast<std::size_t>(part_label(stem + "_left"))],
              labels.names[static_cast<std::size_t>(part_label(stem + "_right"))]);
  };
  for (const char* stem : {"hand", "forearm", "foot", "shank"}) exchange(stem);
  EXPECT_EQ(compare_sides(labels), "");  // as with crossed arms and legs
  exchange("thigh");
  EXPECT_EQ(compare_sides(labels), "");  // thighs alone are not reported
  exchange("upper_arm");
  EXPECT_NE(compare_sides(labels).find("thigh_left lies to the right of thigh_right, upper_arm_left"),
            std::string::npos)
      << compare_sides(labels);
  for (std::string& name : labels.names)
    if (name.starts_with("upper_arm") || name.starts_with("forearm") || name.starts_with("hand")) name = "";
  EXPECT_NE(compare_sides(labels).find("left and right are swapped, or the header is mirrored"),
            std::string::npos);
}

TEST(Belonging, RefusesLandmarksOfAnotherBody) {
  const Scan scan = scan_of(6);
  const auto table = measure(scan.grey, scan.labels, standing().landmarks);
  ASSERT_TRUE(table) << table.error().message();
  EXPECT_EQ(compare_centres(*table, standing().landmarks).value(), "");
  Landmarks one = standing().landmarks;
  one["knee_left"].point[2] += 400;
  const auto told = compare_centres(*table, one);
  ASSERT_TRUE(told) << told.error().message();
  EXPECT_NE(told->find("1 of 15 parts"), std::string::npos) << *told;
  EXPECT_NE(told->find("m from knee_left to the centre of shank_left"), std::string::npos) << *told;
  // another origin, a mirrored axis, metres
  const auto others = [&](auto&& change) {
    Landmarks all = standing().landmarks;
    for (auto& [name, landmark] : all) change(landmark.point);
    return compare_centres(*table, all);
  };
  for (const auto& refused :
       {others([](Eigen::Vector3d& p) { p[2] += 400; }), others([](Eigen::Vector3d& p) { p[0] *= -1; }),
        others([](Eigen::Vector3d& p) { p *= 1e-3; })}) {
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message().find("another body or pose than the table"), std::string::npos);
  }
}

}  // namespace
}  // namespace borelli
