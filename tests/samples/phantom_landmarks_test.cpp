// Landmarks of the phantom, the planes that cut its parts, and its poses.
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "phantom_bodies.hpp"
#include "samples/phantom_voxels.hpp"

namespace borelli::phantom_test {
namespace {

using Eigen::Matrix3d, Eigen::Vector3d;

const EllipticStack& shape_of(const Phantom& phantom, const std::string& name) {
  for (const PhantomSolid& solid : phantom.solids)
    if (solid.name == name) return solid.shape;
  ADD_FAILURE() << "no solid " << name;
  return phantom.solids.front().shape;
}

TEST(Phantom, JointCentresMatchTheBones) {
  for (const Phantom& phantom : bodies()) {
    const auto at = [&](const std::string& name) { return phantom.landmarks.at(name); };
    for (const std::string side : {"left", "right"}) {
      for (const auto& [bone, joint] : {std::pair{"femoral head ", "hip_"}, {"humeral head ", "shoulder_"}}) {
        const EllipticStack& head = shape_of(phantom, bone + side);
        const Landmark centre = at(joint + side);
        EXPECT_LT((head.frame().origin - centre.point).norm(), 1e-9);
        EXPECT_NEAR(head.section(0).a, centre.radius, 1e-9);
        EXPECT_NEAR(head.section(0).b, centre.radius, 1e-9);
      }
      // hinge axes: those of the condyles' cylinders, through the epicondyles
      for (const auto& [bone, joint] : {std::pair{"medial condyle ", "knee_"},
                                        {"lateral condyle ", "knee_"},
                                        {"humeral condyles ", "elbow_"}}) {
        const std::string j = joint;
        const Vector3d medial = at(j + "medial_" + side).point, lateral = at(j + "lateral_" + side).point;
        const EllipticStack& condyle = shape_of(phantom, bone + side);
        const Vector3d axis = (lateral - medial).normalized();
        EXPECT_NEAR(std::abs(axis.dot(condyle.frame().axes.col(2))), 1, 1e-12);
        EXPECT_LT((condyle.frame().origin - medial).cross(axis).norm(), 1e-9);
        EXPECT_LT((at(j + side).point - medial).cross(axis).norm(), 1e-9);
        EXPECT_NEAR(condyle.section(condyle.low()).a, at(j + side).radius, 1e-9);
      }
    }
    EXPECT_LT((at("mid_hip").point - 0.5 * (at("hip_left").point + at("hip_right").point)).norm(), 1e-9);
  }
}

// The ASIS is the foremost point of the pelvis; the xiphion the lowest of the sternum; C7's process ends at
// the cervicale.
TEST(Phantom, BonyPointsLieOnTheirBones) {
  const Phantom& phantom = standing_male();
  const Vector3d asis = phantom.landmarks.at("asis_left").point,
                 xiphion = phantom.landmarks.at("xiphion").point;
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(0, 1);
  double front = 1e9, lowest = 1e9, tip = -1e9;
  for (const PhantomSolid& solid : phantom.solids) {
    const bool pelvis = solid.name == "asis left" || solid.name == "ilium left" ||
                        solid.name == "pubis left" || solid.name == "ischium left" ||
                        solid.name == "ramus left" || solid.name == "acetabulum left";
    if (!pelvis && solid.name != "sternum" && solid.name != "C7 spinous process") continue;
    const EllipticStack& shape = solid.shape;
    for (int n = 0; n < 100000; ++n) {
      const Vector3d u(uniform(random), uniform(random), uniform(random));
      const Vector3d p =
          shape.frame().point(shape.box_low() + u.cwiseProduct(shape.box_high() - shape.box_low()));
      if (!shape.holds(p)) continue;
      if (pelvis) front = std::min(front, p.y());
      if (solid.name == "sternum") lowest = std::min(lowest, p.z());
      if (solid.name == "C7 spinous process") tip = std::max(tip, p.y());
    }
  }
  // random points come within half a millimetre of a blunt end; the sternum's round tip is tilted, so its
  // lowest point is 0.3 mm below its end
  EXPECT_NEAR(front, asis.y(), 0.5);
  EXPECT_NEAR(lowest, xiphion.z(), 0.5);
  EXPECT_NEAR(tip, phantom.landmarks.at("cervicale").point.y(), 1.0);
}

// Parts meet only in the planes of cut_planes at the phantom's landmarks.
TEST(Phantom, PartsEndAtTheCutPlanes) {
  std::mt19937_64 random(13);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (const Phantom& phantom : bodies()) {
    const std::vector<Cut> cuts = cut_planes(phantom.landmarks);
    ASSERT_EQ(cuts.size(), 15u);
    std::vector<double> nearest_below(cuts.size(), 1e9), nearest_above(cuts.size(), 1e9);
    for (const PhantomSolid& solid : phantom.solids) {
      if (solid.parent >= 0) continue;
      for (int n = 0; n < 4000; ++n) {
        const Vector3d u(uniform(random), uniform(random), uniform(random));
        const Vector3d p = solid.shape.frame().point(
            solid.shape.box_low() + u.cwiseProduct(solid.shape.box_high() - solid.shape.box_low()));
        if (!solid.shape.holds(p)) continue;
        for (std::size_t c = 0; c < cuts.size(); ++c) {
          const double beyond = cuts[c].normal.dot(p - cuts[c].point);
          if (solid.part == cuts[c].proximal) {
            ASSERT_LT(beyond, 1e-9) << solid.name << " beyond the cut " << cuts[c].joint;
            nearest_below[c] = std::min(nearest_below[c], -beyond);
          }
          if (solid.part == cuts[c].distal) {
            ASSERT_GT(beyond, -1e-9) << solid.name << " short of the cut " << cuts[c].joint;
            nearest_above[c] = std::min(nearest_above[c], beyond);
          }
        }
      }
    }
    for (std::size_t c = 0; c < cuts.size(); ++c) {  // some of thousands of points come near each plane
      EXPECT_LT(nearest_below[c], 5) << cuts[c].joint;
      EXPECT_LT(nearest_above[c], 5) << cuts[c].joint;
    }
  }
}

Vector3d turned(const Vector3d& point, const Vector3d& centre, const Vector3d& axis, double deg) {
  return centre + Eigen::AngleAxisd(deg * std::numbers::pi / 180, axis.normalized()) * (point - centre);
}

// A bent hinge turns everything beyond it about the line through its epicondyles. Knee flexion moves the
// ankle back, elbow flexion moves the wrist forward.
TEST(Phantom, PoseRotatesThePartsBeyondTheJoint) {
  const Phantom& straight = standing_male();
  const Phantom bent = built({.pose_deg = {{"knee_left_flexion", 50}, {"elbow_right_flexion", 70}}});
  const auto from = [&](const std::string& name) { return straight.landmarks.at(name).point; };
  const auto to = [&](const std::string& name) { return bent.landmarks.at(name).point; };
  const double build = 1e-9;  // mm: rounding
  for (const char* name : {"ankle_left", "heel_left", "toe_tip_left", "medial_malleolus_left"}) {
    // a positive turn about the axis from right to left moves lower points backwards
    const Vector3d axis = from("knee_lateral_left") - from("knee_medial_left");
    EXPECT_LT((to(name) - turned(from(name), from("knee_left"), axis, 50)).norm(), build) << name;
  }
  EXPECT_GT(to("ankle_left").y(), from("ankle_left").y() + 200);
  for (const char* name : {"wrist_right", "metacarpale_3_right", "dactylion_3_right"}) {
    const Vector3d axis = from("elbow_medial_right") - from("elbow_lateral_right");
    EXPECT_LT((to(name) - turned(from(name), from("elbow_right"), axis, -70)).norm(), build) << name;
  }
  EXPECT_LT(to("wrist_right").y(), from("wrist_right").y() - 200);
  for (const char* name : {"knee_left", "hip_left", "ankle_right", "elbow_right", "wrist_left", "neck"})
    EXPECT_LT((to(name) - from(name)).norm(), build) << name;

  const Phantom open = built({.pose_deg = {{"shoulder_left_abduction", 30}, {"hip_right_abduction", 10}}});
  const Vector3d back = Vector3d::UnitY();
  EXPECT_LT((open.landmarks.at("wrist_left").point -
             turned(from("wrist_left"), from("shoulder_left"), back, -(30 - 12)))  // 12: standing
                .norm(),
            build);
  EXPECT_LT((open.landmarks.at("knee_right").point - turned(from("knee_right"), from("hip_right"), back, 10))
                .norm(),
            build);
}

}  // namespace
}  // namespace borelli::phantom_test
