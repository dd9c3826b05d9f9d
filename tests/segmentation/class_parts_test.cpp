// Parts from another program's classes: the phantom's renumbered solids, and the ICRP male's organs.
#include "segmentation/labelling/class_parts.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>

#include "samples/phantom_voxels.hpp"
#include "segmentation/labelling/segment.hpp"
#include "tests/paths.hpp"
#include "tests/segmentation/dice.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

struct Seen {
  Phantom body;
  Scan scan;
};

Seen seen(double spacing) {
  Seen out{*build_phantom({}), {}};
  GridOptions grid;
  grid.spacing.setConstant(spacing);
  out.scan = voxelise(out.body, phantom_grid(out.body, grid));
  return out;
}

ClassRule rule(std::initializer_list<std::string> names, ClassTissue tissue) {
  ClassRule out{0, tissue};
  for (const auto& name : names) out.parts |= part_bit(part_label(name));
  return out;
}

// Whole bones as a network might give them: one class per pair of limb bones, left and right together, one
// for skull and neck, one for the rest of the spine with ribs, girdles and pelvis.
const std::vector<std::pair<std::string, std::vector<std::string>>> limb_bones{
    {"upper_arm", {"humer"}},
    {"forearm", {"ulna", "radius"}},
    {"hand", {"carpal", "metacarpal", "phalanx"}},
    {"thigh", {"femoral", "femur", "medial condyle", "lateral condyle"}},
    {"shank", {"patella", "tibia", "fibula", "medial malleolus", "lateral malleolus"}},
    {"foot", {"tal", "calcaneus", "navicular", "cuboid", "cuneiform", "metatarsal", "toe"}}};

ClassLabels bones_of(const Seen& s) {
  ClassLabels map;
  map.labels.grid = s.scan.labels.grid;
  map.labels.voxels.assign(map.labels.grid.count(), 0);
  map.labels.names = {"outside", "skull and neck", "column"};
  map.rules = {ClassRule{}, rule({"head"}, ClassTissue::bone),
               rule({"upper_trunk", "middle_trunk", "lower_trunk"}, ClassTissue::bone)};
  for (const auto& [stem, names] : limb_bones) {
    map.labels.names.push_back(stem);
    map.rules.push_back(rule({stem + "_left", stem + "_right"}, ClassTissue::bone));
  }
  std::vector<std::uint8_t> class_of(s.body.solids.size(), 0);
  for (std::size_t n = 0; n < class_of.size(); ++n) {
    const PhantomSolid& solid = s.body.solids[n];
    if (solid.tissue.name != "cortex" && solid.tissue.name != "spongiosa") continue;
    class_of[n] = solid.part == part_label("head") ? 1 : 2;
    for (std::size_t limb = 0; limb < limb_bones.size(); ++limb)
      for (const auto& name : limb_bones[limb].second)
        if (solid.name.starts_with(name)) class_of[n] = static_cast<std::uint8_t>(3 + limb);
  }
  const auto& g = map.labels.grid;
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        if (!s.scan.labels.at(i, j, k)) continue;
        const int n = solid_at(s.body, g.point(i, j, k));
        if (n >= 0) map.labels.at(i, j, k) = class_of[static_cast<std::size_t>(n)];
      }
  return map;
}

TEST(ClassParts, FindsTheNearestPartInTheTree) {
  const PartSet legs = part_bit(part_label("thigh_left")) | part_bit(part_label("thigh_right"));
  EXPECT_EQ(nearest_part(legs, part_label("foot_left"), -50), part_label("thigh_left"));
  EXPECT_EQ(nearest_part(legs, part_label("lower_trunk"), -50), part_label("thigh_right"));
  EXPECT_EQ(nearest_part(legs, part_label("lower_trunk"), 50), part_label("thigh_left"));
  EXPECT_EQ(nearest_part(all_parts, part_label("hand_left"), -50), part_label("hand_left"));
}

// The phantom's exact labels under other numbers are kept. Only unlabelled voxels (air in the navel) may get
// labels from our method.
TEST(ClassParts, RenumberedExactLabelsGiveTheParts) {
  const Seen s = seen(4);
  ClassLabels map;
  map.labels = s.scan.labels;
  map.rules.resize(200);
  map.labels.names.resize(200);
  for (auto& label : map.labels.voxels)
    if (label) label = static_cast<std::uint8_t>(199 - label);
  for (int n = 1; n < 17; ++n)
    map.rules[static_cast<std::size_t>(199 - n)] = {part_bit(n), ClassTissue::soft};
  SegmentOptions options;
  options.step = 4, options.classes = &map;
  const auto found = segment(s.scan.grey, options);
  ASSERT_TRUE(found) << found.error().message();
  std::size_t lost = 0, more = 0;
  for (std::size_t o = 0; o < found->labels.voxels.size(); ++o) {
    lost += s.scan.labels.voxels[o] && found->labels.voxels[o] != s.scan.labels.voxels[o];
    more += !s.scan.labels.voxels[o] && found->labels.voxels[o];
  }
  EXPECT_EQ(lost, 0U);
  EXPECT_LT(more, 40U);  // the navel's 2 ml are 30 of these voxels
  for (std::size_t n = 1; n < parts.size(); ++n)
    EXPECT_EQ(found->part[n].coverage, Coverage::whole) << parts[n].name;
}

// No bone is visible in this scan (all tissue has one CT number, as in a poor MR). Bones come from the
// classes, without sides, and flesh follows them. Hips and shoulders are spheres through the labelled heads;
// the trunk's points, which bone classes do not give, are set by hand.
TEST(ClassParts, ClassesGiveBonesThatTheScanDoesNotShow) {
  Seen s = seen(3);
  const ClassLabels map = bones_of(s);
  for (std::size_t o = 0; o < s.scan.labels.voxels.size(); ++o)
    s.scan.grey.voxels[o] = s.scan.labels.voxels[o] ? 40 : -1000;
  SegmentOptions options;
  options.classes = &map;
  for (const char* name : {"xiphion", "omphalion", "asis_left", "asis_right"})
    options.given[name] = s.body.landmarks.at(name);
  const auto found = segment(s.scan.grey, options);
  ASSERT_TRUE(found) << found.error().message();
  for (const char* joint : {"hip_left", "hip_right", "shoulder_left", "shoulder_right"}) {
    ASSERT_TRUE(found->landmarks.contains(joint)) << joint;
    // half a voxel of the work grid over the visible part of a ball
    EXPECT_LT((found->landmarks.at(joint).point - s.body.landmarks.at(joint).point).norm(), 5)
        << joint << ": " << found->landmarks.at(joint).source;
  }
  for (const char* joint : {"knee_left", "knee_right", "ankle_left", "ankle_right", "elbow_left",
                            "elbow_right", "wrist_left", "wrist_right", "neck"}) {
    ASSERT_TRUE(found->landmarks.contains(joint)) << joint;
    const Landmark& mark = found->landmarks.at(joint);
    EXPECT_LT((mark.point - s.body.landmarks.at(joint).point).norm(), 3 * mark.deviation)
        << joint << ": " << mark.source;
  }
  const auto agreement = dice(found->labels, s.scan.labels);
  // a joint's plane 20 mm off costs a shank 5 % of its length, a hand or foot 10 %
  for (std::size_t n = 1; n < parts.size(); ++n) {
    const bool end = parts[n].name.starts_with("hand") || parts[n].name.starts_with("foot");
    EXPECT_GT(agreement[n], end ? 0.85 : 0.93) << parts[n].name;
  }
}

// If the scan shows bones, the classes must not make the result worse.
TEST(ClassParts, ClassesGiveBonesInCt) {
  const Seen s = seen(3);
  const ClassLabels map = bones_of(s);
  SegmentOptions options;
  options.classes = &map;
  const auto found = segment(s.scan.grey, options);
  ASSERT_TRUE(found) << found.error().message();
  const auto agreement = dice(found->labels, s.scan.labels);
  for (std::size_t n = 1; n < parts.size(); ++n) EXPECT_GT(agreement[n], 0.97) << parts[n].name;
  for (const auto& [name, mark] : s.body.landmarks)
    if (name.starts_with("hip") || name.starts_with("shoulder") || name.starts_with("knee")) {
      EXPECT_LT((found->landmarks.at(name).point - mark.point).norm(), 8) << name;
    }
}

// Whole parts without stated tissue contain bones, which guide the rest of the body. With head, trunk and one
// upper arm mapped, the other parts come out as without a map, and none is absent.
TEST(ClassParts, UnmappedPartsStayInView) {
  const Seen s = seen(4);
  ClassLabels map;
  map.labels = s.scan.labels;
  map.rules.resize(17);
  for (int n = 1; n <= 5; ++n) map.rules[static_cast<std::size_t>(n)].parts = part_bit(n);
  for (auto& label : map.labels.voxels)
    if (label > 5) label = 0;
  SegmentOptions options;
  options.step = 4, options.classes = &map;
  const auto found = segment(s.scan.grey, options);
  ASSERT_TRUE(found) << found.error().message();
  const auto agreement = dice(found->labels, s.scan.labels);
  for (std::size_t n = 1; n < parts.size(); ++n) {
    EXPECT_EQ(found->part[n].coverage, Coverage::whole) << parts[n].name << ": " << found->part[n].note;
    EXPECT_GT(agreement[n], n <= 5 ? 0.999 : 0.95) << parts[n].name;
  }
}

TEST(ClassParts, WarnsOfMirroredClasses) {
  const Seen s = seen(6);
  ClassLabels map;
  map.labels = s.scan.labels;
  map.rules.resize(17);
  for (int n = 1; n < 17; ++n) {
    const std::string_view name = parts[static_cast<std::size_t>(n)].name;
    const int other = n + (name.ends_with("_left") ? 1 : name.ends_with("_right") ? -1 : 0);
    map.rules[static_cast<std::size_t>(n)] = {part_bit(other), ClassTissue::soft};
  }
  SegmentOptions options;
  options.step = 6, options.classes = &map;
  const auto found = segment(s.scan.grey, options);
  ASSERT_TRUE(found) << found.error().message();
  EXPECT_TRUE(std::ranges::any_of(found->warnings, [](const Warning& warning) {
    return warning.severity != Severity::note &&
           warning.text.find("left classes lie on the patient's right") != std::string::npos;
  }));
}

// A map that is cropped or has other voxels is placed by its own grid.
TEST(ClassParts, AcceptsLabelsOnAnotherGrid) {
  LabelMap map;
  map.grid.size = {4, 3, 2};
  map.grid.axes = Eigen::Vector3d(2, 3, 4).asDiagonal();
  map.grid.origin = {10, 20, 30};
  map.voxels.resize(24);
  std::iota(map.voxels.begin(), map.voxels.end(), std::uint8_t{1});
  Grid wide;
  wide.size = {8, 6, 8};
  wide.axes = Eigen::Vector3d(-2, 3, 2).asDiagonal();  // mirrored along x, finer along z
  wide.origin = {18, 17, 26};
  const LabelMap on = labels_on(map, wide);
  for (std::int64_t k = 0; k < 8; ++k)
    for (std::int64_t j = 0; j < 6; ++j)
      for (std::int64_t i = 0; i < 8; ++i) {
        const std::int64_t a = 4 - i, b = j - 1;
        const double z = (26 + 2 * static_cast<double>(k) - 30) / 4;
        const std::int64_t c = std::lround(z);
        EXPECT_EQ(on.at(i, j, k), map.grid.holds(a, b, c) ? map.at(a, b, c) : 0) << i << j << k;
      }
}

// Issue 4: each part contains its own bones, and the whole has the organs' mass.
TEST(ClassParts, IcrpMalesOrgansGiveHisParts) {
  const std::string folder = test::shared_folder() + "/volumes/icrp_am/";
  if (!std::filesystem::exists(folder + "AM_labels.nii.gz"))
    GTEST_SKIP() << "the ICRP male is not beside the checkout";
  const auto scan = read_volume(folder + "AM_density_kgm3.nii.gz", {.quantity = FileQuantity::density_kgm3});
  ASSERT_TRUE(scan) << scan.error().message();
  const auto classes = read_classes(folder + "AM_labels.nii.gz", "", "icrp110");
  ASSERT_TRUE(classes) << classes.error().message();
  EXPECT_TRUE(classes->warnings.empty());
  SegmentOptions options;
  options.classes = &*classes;
  const auto found = segment(scan->volume, options);
  ASSERT_TRUE(found) << found.error().message();
  // his upper arms touch the trunk, and no label separates their flesh; a warning says that slices of 8 mm
  // are coarse and names the joints whose round ends they do not show
  const auto sentences = in_sentences(found->warnings);
  const auto count_of = [&](std::string_view what) {
    return std::count_if(sentences.begin(), sentences.end(),
                         [&](const std::string& w) { return w.find(what) != std::string::npos; });
  };
  ASSERT_EQ(sentences.size(), 3u) << sentences.front();
  EXPECT_EQ(
      count_of("left upper arm, right upper arm (nothing shows its boundary where it touches other parts)"),
      1);
  EXPECT_EQ(count_of("voxels of 8.0 mm are large"), 1);
  EXPECT_EQ(count_of("so the bones' outlines place them"), 1);

  struct Bones {
    const char* part;
    int first, last;
  };
  std::array<double, parts.size()> mass{};
  double whole = 0;
  const auto& g = found->labels.grid;
  for (std::size_t o = 0; o < g.count(); ++o) {
    const double m = scan->volume.voxels[o] * g.voxel_volume() * 1e-9;
    mass[found->labels.voxels[o]] += m;
    if (found->labels.voxels[o]) whole += m;
  }
  EXPECT_NEAR(whole, 72.99, 0.05);
  for (const Bones& bones :
       {Bones{"upper_arm", 13, 18}, Bones{"forearm", 19, 21}, Bones{"hand", 22, 23}, Bones{"thigh", 28, 33},
        Bones{"shank", 34, 36}, Bones{"foot", 37, 38}, Bones{"head", 26, 27}, Bones{"head", 47, 48},
        Bones{"lower_trunk", 41, 42}, Bones{"upper_trunk", 45, 46}}) {
    double own = 0, count = 0;
    for (std::size_t o = 0; o < g.count(); ++o) {
      const int organ = classes->labels.voxels[o];
      if (organ < bones.first || organ > bones.last) continue;
      // the grid's first axis runs to the left, and the body is centred on it; no limb bone crosses the
      // middle
      const char* side = static_cast<std::int64_t>(o) % g.size[0] >= g.size[0] / 2 ? "_left" : "_right";
      const int whole_part = part_label(bones.part);
      own +=
          found->labels.voxels[o] == (whole_part ? whole_part : part_label(bones.part + std::string(side)));
      ++count;
    }
    EXPECT_GT(count, 0);
    EXPECT_EQ(own, count) << bones.part;
  }
  for (std::size_t n = 1; n < parts.size(); ++n) {
    EXPECT_EQ(found->part[n].coverage, Coverage::whole) << parts[n].name;
    const std::string name(parts[n].name);
    if (!name.ends_with("_left")) continue;
    const bool end = name.starts_with("hand") || name.starts_with("foot");
    EXPECT_NEAR(mass[n] / mass[n + 1], 1, end ? 0.08 : 0.05) << name;
  }
}

// A map without bones does not determine joints; they stay where the scan shows them.
TEST(ClassParts, JointsComeFromTheScanWithoutLabelledBones) {
  const std::string folder = test::shared_folder() + "/volumes/icrp_am/";
  if (!std::filesystem::exists(folder + "AM_labels.nii.gz"))
    GTEST_SKIP() << "the ICRP male is not beside the checkout";
  const auto scan = read_volume(folder + "AM_hu.nii.gz", {});
  ASSERT_TRUE(scan) << scan.error().message();
  auto classes = read_classes(folder + "AM_labels.nii.gz", "", "icrp110");
  ASSERT_TRUE(classes) << classes.error().message();
  constexpr std::uint8_t liver = 95;  // ICRP 110, table A.1
  for (auto& voxel : classes->labels.voxels)
    if (voxel != liver) voxel = 0;
  SegmentOptions options;
  const auto alone = segment(scan->volume, options);
  options.classes = &*classes;
  const auto with_liver = segment(scan->volume, options);
  ASSERT_TRUE(alone && with_liver);
  for (const char* joint : {"hip_left", "hip_right", "shoulder_left", "shoulder_right", "neck"}) {
    EXPECT_LT((alone->landmarks.at(joint).point - with_liver->landmarks.at(joint).point).norm(), 1) << joint;
    EXPECT_EQ(alone->landmarks.at(joint).source, with_liver->landmarks.at(joint).source);
  }
}

}  // namespace
}  // namespace borelli
