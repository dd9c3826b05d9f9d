// The skin of figures made of capsules: its surface, and the parts that move each point.
#include "pipeline/export/skin.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "pipeline/export/skin_pose.hpp"
#include "segmentation/vocabulary/parts.hpp"
#include "tests/pipeline/export/capsule_labels.hpp"

namespace borelli::test::skin_test {
namespace {

using Eigen::Vector3d;

Skin figure_skin(double step = 3) {
  auto skin = skin_of(labels_of(figure(), step), figure_joints(), {}, {.tolerance = 0.001, .threads = 1});
  EXPECT_TRUE(skin) << skin.error().message();
  return *skin;
}

/// The shape with the nearest surface; "" if another one is less than 8 mm farther.
std::string shape_at(const std::vector<LabelCapsule>& shapes, const Eigen::Vector3f& p) {
  std::map<std::string, double> away;
  for (const LabelCapsule& c : shapes) {
    const double mm = std::abs(c.outside(1e3 * p.cast<double>()));
    const auto [at, is_new] = away.emplace(c.name, mm);
    if (!is_new) at->second = std::min(at->second, mm);
  }
  const auto by_distance = [](const auto& entry) { return entry.second; };
  const auto nearest = *std::ranges::min_element(away, {}, by_distance);
  away.erase(nearest.first);
  return std::ranges::min_element(away, {}, by_distance)->second > nearest.second + 8 ? nearest.first : "";
}

/// The parts that move a point; a helper bone stands for its part and that part's parent.
std::set<std::string> movers(const Skin& skin, std::size_t point) {
  std::set<std::string> names;
  for (std::size_t c = 0; c < 4; ++c) {
    if (skin.weights[point][c] == 0) continue;
    const std::size_t bone = skin.bones_of[point][c];
    const SkinPart& part = skin.parts[skin.bones[bone].part];
    names.insert(part.name);
    if (bone >= skin.parts.size()) names.insert(skin.parts[static_cast<std::size_t>(part.parent)].name);
  }
  return names;
}

std::ptrdiff_t euler_characteristic(const Mesh& mesh) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const auto& t : mesh.triangles)
    for (std::size_t e = 0; e < 3; ++e) edges.insert(std::minmax(t[e], t[(e + 1) % 3]));
  return std::ssize(mesh.points) - std::ssize(edges) + std::ssize(mesh.triangles);
}

// The right hand touches the trunk: as one mask the body would have a handle (Euler characteristic 0).
TEST(SkinSurface, IsOneClosedSphereWithTheVolumeOfTheVoxels) {
  for (const double step : {3.0, 4.0}) {
    const LabelMap labels = labels_of(figure(), step);
    const Skin skin = figure_skin(step);
    EXPECT_TRUE(is_closed(skin.mesh));
    EXPECT_EQ(euler_characteristic(skin.mesh), 2) << step;
    const auto one_mask = body_mesh(labels, 0.02, "mask", 0.001, 1);
    ASSERT_TRUE(one_mask);
    EXPECT_EQ(euler_characteristic(*one_mask), 0) << step;
    const auto outside = std::ranges::count(labels.voxels, std::uint8_t{0});
    const double voxels = double(std::ssize(labels.voxels) - outside);
    EXPECT_NEAR(enclosed_volume(skin.mesh) / (voxels * std::pow(1e-3 * step, 3)), 1, 0.005);
  }
}

// Edges are at most as long as the distance between two bones of a zone: 4 r / 5 for three helpers, with r of
// the thinnest joint.
TEST(SkinSurface, HasEdgesShortEnoughToBend) {
  const Skin skin = figure_skin();
  double thinnest = 1, longest = 0;
  for (const SkinPart& part : skin.parts)
    if (part.has_joint) thinnest = std::min(thinnest, part.half_thickness);
  for (const auto& t : skin.mesh.triangles)
    for (std::size_t e = 0; e < 3; ++e)
      longest = std::max<double>(longest, (skin.mesh.points[t[e]] - skin.mesh.points[t[(e + 1) % 3]]).norm());
  EXPECT_LT(longest,
            0.8 * thinnest + 0.003);  // restoring the volume moves points by at most half a voxel each
  EXPECT_LT(skin.mesh.triangles.size(), 20000u);  // 0.55 m^2 in steps of 3 mm would have 120000
}

TEST(SkinWeights, SumToOneOverAtMostFourBones) {
  const Skin skin = figure_skin();
  ASSERT_EQ(skin.weights.size(), skin.mesh.points.size());
  ASSERT_EQ(skin.bones_of.size(), skin.mesh.points.size());
  for (std::size_t n = 0; n < skin.weights.size(); ++n) {
    float sum = 0;
    for (std::size_t c = 0; c < 4; ++c) {
      sum += skin.weights[n][c];
      EXPECT_GE(skin.weights[n][c], 0);
      EXPECT_LT(skin.bones_of[n][c], skin.bones.size());
      if (skin.weights[n][c] == 0) {
        EXPECT_EQ(skin.bones_of[n][c], 0);
      }
      if (c > 0) {
        EXPECT_LE(skin.weights[n][c], skin.weights[n][c - 1] + 1e-6F);
      }
    }
    EXPECT_NEAR(sum, 1, 2e-7);
  }
}

TEST(SkinWeights, AHandAtTheHipIsMovedByItsArmAlone) {
  const auto shapes = figure();
  const Skin skin = figure_skin();
  int hands = 0, waist = 0, forearms = 0;
  for (std::size_t n = 0; n < skin.mesh.points.size(); ++n) {
    const std::string at = shape_at(shapes, skin.mesh.points[n]);
    const auto by = movers(skin, n);
    if (at.starts_with("hand") || at.starts_with("forearm")) {
      EXPECT_FALSE(by.contains("trunk")) << at;
      const std::string other = at.ends_with("left") ? "right" : "left";
      for (const std::string& name : by)
        EXPECT_EQ(name.find(other), std::string::npos) << at << " by " << name;
      ++(at.starts_with("hand") ? hands : forearms);
    } else if (at == "trunk" && skin.mesh.points[n].z() < 0.9F) {
      EXPECT_EQ(by, std::set<std::string>{"trunk"});
      ++waist;
    }
  }
  EXPECT_GT(hands, 100);
  EXPECT_GT(forearms, 100);
  EXPECT_GT(waist, 100);
}

// The effect on the skin: arms raised by 60 degrees leave the waist at rest and move the hands rigidly.
TEST(SkinWeights, RaisedArmsLeaveTheWaistAlone) {
  const auto shapes = figure();
  const Skin skin = figure_skin();
  const auto left = turn_deg(-60, {0, 1, 0}), right = turn_deg(60, {0, 1, 0});
  const auto points =
      deformed(skin, turned(figure_joints(), {}, {{"upper_arm_left", left}, {"upper_arm_right", right}}));
  double waist = 0, hands = 0;
  for (std::size_t n = 0; n < points.size(); ++n) {
    const Vector3d p = skin.mesh.points[n].cast<double>();
    const std::string at = shape_at(shapes, skin.mesh.points[n]);
    if (at == "trunk" && p.z() < 0.9) waist = std::max(waist, (points[n] - p).norm());
    if (!at.starts_with("hand")) continue;
    const bool is_left = at.ends_with("left");
    const Vector3d c(is_left ? 0.12 : -0.12, 0, 1.04);
    hands = std::max(hands, (points[n] - (c + (is_left ? left : right) * (p - c))).norm());
  }
  EXPECT_LT(waist, 1e-6);  // rounding of float weights, whose sum is 1 within 1e-7
  EXPECT_LT(hands, 1e-6);
}

TEST(SkinJoints, ComeParentsFirstWithHingesAtElbowsAndKnees) {
  LabelMap labels;
  for (std::size_t n = 0; n < parts.size(); ++n) {
    labels.names.emplace_back(parts[n].name);
    labels.voxels.push_back(static_cast<std::uint8_t>(n));
  }
  Landmarks landmarks;
  landmarks["knee_left"].point = {100, 20, 500};
  const auto joints = skin_joints(labels, landmarks);
  ASSERT_EQ(joints.size(), 16u);
  std::set<std::string> seen;
  for (const SkinJoint& joint : joints) {
    EXPECT_TRUE(joint.parent.empty() || seen.contains(joint.parent)) << joint.part;
    seen.insert(joint.part);
    EXPECT_EQ(joint.twists, !joint.part.starts_with("shank") && !joint.part.starts_with("forearm"))
        << joint.part;
    EXPECT_EQ(joint.centre.has_value(), joint.part == "shank_left") << joint.part;
    if (joint.centre) {
      EXPECT_EQ(*joint.centre, Vector3d(0.1, 0.02, 0.5));
    }
  }
}

TEST(SkinOf, NamesWhatIsMissing) {
  const LabelMap labels = labels_of(limb(), 6);
  const auto said = [&](const LabelMap& map, const std::vector<SkinJoint>& joints) {
    const auto skin = skin_of(map, joints, {});
    return skin ? std::string("accepted") : skin.error().message();
  };
  EXPECT_NE(said(labels, {{"upper", "", {}, true}}).find("'lower' has voxels but no joint"),
            std::string::npos);
  EXPECT_NE(said(labels, {{"middle", "upper", {}, true}, {"upper", "", {}, true}}).find("must come before"),
            std::string::npos);
  EXPECT_NE(said(labels, {{"upper", "", {}, true}, {"upper", "", {}, true}}).find("two joints"),
            std::string::npos);
  LabelMap empty = labels;
  std::ranges::fill(empty.voxels, std::uint8_t{0});
  EXPECT_NE(said(empty, limb_joints(true)).find("no voxel has a label"), std::string::npos);
}

}  // namespace
}  // namespace borelli::test::skin_test
