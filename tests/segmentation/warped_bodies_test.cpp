// Warped bodies against their sources: masses of ICRP 110, rigid bones, requested lengths, mirrored bodies.
#include "tests/suite/warped_bodies.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "segmentation/files/read.hpp"
#include "segmentation/labelling/segment.hpp"
#include "tests/paths.hpp"

namespace borelli::suite {
namespace {

using Eigen::Vector3d;

// Read once for all tests; null if the data are missing.
const LabelledBody* labelled(const std::string& name) {
  static std::map<std::string, std::optional<LabelledBody>> bodies;
  auto& body = bodies[name];
  if (!body)
    if (auto read = read_labelled_body(name, test::shared_folder())) body = std::move(*read);
  return body ? &*body : nullptr;
}

#define NEED_BODY(body, name)                \
  const LabelledBody* body = labelled(name); \
  if (!body) GTEST_SKIP() << "no volumes/icrp_" << name << " beside the checkout"

std::size_t part_at(std::string_view name) { return static_cast<std::size_t>(part_label(name)); }

double distance(const Landmarks& landmarks, const std::string& a, const std::string& b) {
  return (landmarks.at(a).point - landmarks.at(b).point).norm();
}

// kg of the organs 1 to 140, from an adult's files
double mass_in_files(const std::string& name, const std::string& capital) {
  const std::string stem = test::shared_folder() + "/volumes/icrp_" + name + "/" + capital;
  const auto organs =
      read_volume(stem + "_labels.nii.gz", {.quantity = FileQuantity::labels, .progress = {}});
  const auto density =
      read_volume(stem + "_density_kgm3.nii.gz", {.quantity = FileQuantity::density_kgm3, .progress = {}});
  if (!organs || !density) return 0;
  double sum = 0;
  for (std::size_t o = 0; o < organs->volume.voxels.size(); ++o)
    if (organs->volume.voxels[o] >= 1 && organs->volume.voxels[o] <= 140) sum += density->volume.voxels[o];
  return sum * organs->volume.grid.voxel_volume() * 1e-9;
}

void expect_rest_mass(const LabelledBody& body, double mass) {
  EXPECT_NEAR(mass_in_files(body.name, body.name == "am" ? "AM" : "AF"), mass,
              0.0005);                         // the list's last digit
  EXPECT_NEAR(body.mass, mass, 0.005 * mass);  // between slices, shapes that end are interpolated
  const WarpedBody rest = warped_body(body, rest_warp());
  double sum = 0;
  for (std::size_t n = 1; n < parts.size(); ++n) {
    sum += rest.part[n].whole.mass;
    EXPECT_EQ(rest.part[n].coverage, Coverage::whole) << parts[n].name;
  }
  EXPECT_NEAR(sum, body.mass, 0.001 * body.mass);  // points 1.5 mm apart sample the body's voxels
  EXPECT_EQ(rest.overlap, 0);
  for (const auto& [name, landmark] : body.landmarks)
    EXPECT_LT((rest.landmarks.at(name).point - landmark.point).norm(), 1e-6) << name;
}

TEST(WarpedBodies, FemaleAtRestKeepsMassAndLandmarks) {
  NEED_BODY(body, "af");
  expect_rest_mass(*body, 60.000);
}

TEST(WarpedBodies, MaleAtRestKeepsMassAndLandmarks) {
  NEED_BODY(body, "am");
  expect_rest_mass(*body, 72.991);
}

// Segments an adult's own volume and compares the joints with those of the labels. Its slices are thick, and its
// knees show no gap. `hips`, `knees`: largest distances, mm.
void expect_joints(const LabelledBody& body, const std::string& file, double hips, double knees) {
  const auto scan = read_volume(test::shared_folder() + "/volumes/" + file);
  ASSERT_TRUE(scan) << scan.error().message();
  const auto found = segment(scan->volume);
  ASSERT_TRUE(found) << found.error().message();
  for (std::size_t n = 1; n < parts.size(); ++n) {
    EXPECT_GT(found->part[n].volume, 0) << parts[n].name;
    if (parts[n].joint.empty()) continue;
    const std::string joint(parts[n].joint);
    ASSERT_TRUE(found->landmarks.contains(joint)) << joint;
    const Landmark &mark = found->landmarks.at(joint), &exact = body.landmarks.at(joint);
    const Vector3d off = mark.point - exact.point;
    EXPECT_LT(off.cwiseAbs().maxCoeff(), 2.5 * std::hypot(mark.deviation, exact.deviation)) << joint;
    if (joint.starts_with("hip")) {
      EXPECT_LT(off.norm(), hips) << joint;
    }
    if (joint.starts_with("knee")) {
      EXPECT_LT(off.norm(), knees) << joint;
    }
  }
}

// Her sacrum is no denser than flesh; her left hip was once 22 mm off at a stated 2.5.
TEST(WarpedBodies, JointsOfTheFemaleMatchHerLabels) {
  NEED_BODY(body, "af");
  expect_joints(*body, "icrp_af/AF_hu.nii.gz", 3, 8);
}

TEST(WarpedBodies, JointsOfTheMaleMatchHisLabels) {
  NEED_BODY(body, "am");
  expect_joints(*body, "icrp_am/AM_hu.nii.gz", 5, 8);
}

TEST(WarpedBodies, KneeRotatesShankBonesRigidly) {
  NEED_BODY(body, "af");
  Motion motion;
  motion.turn[joint_index("knee_left")] = {1.0, 0.1, 0};
  const BodyMap map(body->landmarks, motion);
  const Eigen::AngleAxisd turn(motion.turn[joint_index("knee_left")].norm(),
                               motion.turn[joint_index("knee_left")].normalized());
  const Vector3d knee = body->landmarks.at("knee_left").point;
  const auto bones = bone_parts(*body);
  int turned = 0, still = 0;
  for (std::size_t n = 0; n < bones.size(); ++n) {
    const Vector3d x = body->centre(n);
    const Vector3d moved = map(x, body->lattice.voxel_share[n], body->lattice.voxel_lift[n]);
    if (bones[n] == part_at("shank_left")) {
      ++turned;
      EXPECT_LT((moved - knee - turn * (x - knee)).norm(), 1e-6);
    } else if (bones[n] && bones[n] != part_at("foot_left")) {
      ++still;
      EXPECT_LT((moved - x).norm(), 1e-6);
    }
  }
  EXPECT_GT(turned, 10000);
  EXPECT_GT(still, 100000);
}

TEST(WarpedBodies, SegmentsGetTheRequestedLengths) {
  NEED_BODY(body, "af");
  Motion motion;
  motion.length[part_at("thigh_left")] = 1.1, motion.length[part_at("forearm_right")] = 0.9;
  motion.turn[joint_index("hip_left")] = {-0.4, 0.2, 0};
  const Landmarks moved = moved_landmarks(*body, BodyMap(body->landmarks, motion));
  EXPECT_NEAR(distance(moved, "hip_left", "knee_left"),
              1.1 * distance(body->landmarks, "hip_left", "knee_left"), 1e-6);
  EXPECT_NEAR(distance(moved, "elbow_right", "wrist_right"),
              0.9 * distance(body->landmarks, "elbow_right", "wrist_right"), 1e-6);
  EXPECT_NEAR(distance(moved, "knee_left", "ankle_left"),
              distance(body->landmarks, "knee_left", "ankle_left"), 1e-6);
}

TEST(WarpedBodies, MirroredBodyHasMirroredParts) {
  NEED_BODY(body, "am");
  const Grid& g = body->grid;
  Volume<std::int16_t> organs{g, std::vector<std::int16_t>(g.count())}, hu = organs, density = organs;
  for (std::size_t n = 0; n < body->voxel.size(); ++n) {
    const std::int64_t o = body->voxel[n], i = o % g.size[0];
    const auto to = static_cast<std::size_t>(o - i + g.size[0] - 1 - i);
    organs.voxels[to] = body->organ[n], hu.voxels[to] = body->hu[n], density.voxels[to] = body->density[n];
  }
  const LabelledBody mirror = labelled_body("mirror", organs, hu, density);
  std::array<double, parts.size()> here{}, there{};
  for (const std::uint8_t owner : body->owner) ++here[owner];
  for (const std::uint8_t owner : mirror.owner) ++there[owner];
  const double across = 2 * g.origin.x() + double(g.size[0] - 1) * g.axes(0, 0);
  for (std::size_t n = 1; n < parts.size(); ++n) {
    const auto swap = [](std::string name) {
      const auto left = name.find("_left"), right = name.find("_right");
      if (left != std::string::npos) name.replace(left, 5, "_right");
      if (right != std::string::npos) name.replace(right, 6, "_left");
      return name;
    };
    // ties of equally long paths may break differently
    EXPECT_NEAR(there[part_at(swap(std::string(parts[n].name)))], here[n], 0.01 * here[n]) << parts[n].name;
    if (parts[n].joint.empty()) continue;
    Vector3d p = body->landmarks.find(parts[n].joint)->second.point;
    p.x() = across - p.x();
    // one voxel in the plane
    EXPECT_LT((mirror.landmarks.at(swap(std::string(parts[n].joint))).point - p).norm(), 2.2)
        << parts[n].joint;
  }
}

}  // namespace
}  // namespace borelli::suite
