// Skeletons against their phantom, whose inertia and joint centres are exact.
#include "pipeline/body/skeleton.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>

#include "dynamics/formats/scene_file.hpp"
#include "dynamics/numbers/rotation_vector.hpp"
#include "dynamics/run/simulate.hpp"
#include "pipeline/body/joint_axes.hpp"
#include "pipeline/body/joint_ranges.hpp"
#include "samples/phantom.hpp"

namespace borelli::skeleton_test {
namespace {

using Eigen::Vector3d;
constexpr double degree = std::numbers::pi / 180;

struct Body {
  Phantom phantom;
  PartInertials parts;
};

Body body(const std::map<std::string, double>& pose = {}) {
  PhantomOptions options;
  options.pose_deg = pose;
  Body made{build_phantom(options).value(), {}};
  for (std::size_t label = 1; label < parts.size(); ++label)
    made.parts[std::string(parts[label].name)] = made.phantom.exact[label];
  return made;
}

const Solid& solid(const Scene& scene, const std::string& name) {
  for (const Solid& s : scene.solids)
    if (s.name == name) return s;
  throw std::runtime_error("no solid " + name);
}

// X_WS at the scene's start as the product of its switches, independent of the engine
Pose pose(const Scene& scene, const std::string& name) {
  const Solid& s = solid(scene, name);
  Pose X = s.parent == world_name ? Pose{} : pose(scene, s.parent);
  for (const Switch& step : s.switches) {
    if (const auto* fixed = std::get_if<Fixed>(&step.kind)) X = X * fixed->X_AB;
    if (const auto* slide = std::get_if<Translation>(&step.kind))
      X.p += X.R * slide->axis * (step.q.empty() ? 0 : step.q[0]);
    if (const auto* hinge = std::get_if<Rotation>(&step.kind))
      X.R = X.R * rotation_about(hinge->axis, step.q.empty() ? 0 : step.q[0]);
    if (std::holds_alternative<Ball>(step.kind) && !step.q.empty())
      X.R = X.R * Eigen::Quaterniond(step.q[0], step.q[1], step.q[2], step.q[3]).toRotationMatrix();
  }
  return X;
}

TEST(Skeleton, StartsInTheScansPoseWithTheScansInertia) {
  const Body made = body({{"knee_left_flexion", 30}, {"elbow_right_flexion", 40}});
  const auto skeleton = build_skeleton(made.parts, made.phantom.landmarks);
  ASSERT_TRUE(skeleton) << skeleton.error().message();
  ASSERT_EQ(skeleton->scene.solids.size(), 16u);
  EXPECT_TRUE(skeleton->warnings.empty()) << skeleton->warnings.front().text;
  for (const Solid& s : skeleton->scene.solids) {
    const Pose X = pose(skeleton->scene, s.name);
    // frames are along the patient's axes; products of up to six rotations round to a few 1e-16
    EXPECT_LT((X.R - Eigen::Matrix3d::Identity()).norm(), 1e-13) << s.name;
    const Inertial& exact = made.parts.at(s.name);
    EXPECT_LT((X * s.inertials.at(0).centre - exact.centre).norm(), 1e-12) << s.name;
    EXPECT_EQ(s.inertials.at(0).mass, exact.mass);
  }
}

TEST(Skeleton, JointsLieAtTheirCentresAndHingesMeasureFlexion) {
  const Body made = body({{"knee_left_flexion", 30}, {"elbow_right_flexion", 40}});
  const auto skeleton = build_skeleton(made.parts, made.phantom.landmarks);
  ASSERT_TRUE(skeleton);
  for (const Part& part : parts)
    if (!part.joint.empty()) {
      const Pose X = pose(skeleton->scene, std::string(part.name));
      EXPECT_LT((X.p - 1e-3 * made.phantom.landmarks.find(part.joint)->second.point).norm(), 1e-12)
          << part.name;
    }
  const auto flexion = [&](const std::string& part) {
    return solid(skeleton->scene, part).switches.back().q.at(0) / degree;
  };
  // the phantom's angles count from its standing pose, whose ankle and wrist are slightly off the straight
  // line
  EXPECT_NEAR(flexion("shank_left") - flexion("shank_right"), 30, 1e-6);
  EXPECT_NEAR(flexion("forearm_right") - flexion("forearm_left"), 40, 1e-6);
  EXPECT_NEAR(flexion("shank_right"), 0, 2);
  EXPECT_NEAR(flexion("forearm_left"), 0, 2);
}

// The elbow's axis moves with the arm, so a raised arm also bends forwards. This holds with interchanged
// epicondyles too, since no elbow bends backwards so far.
TEST(Skeleton, ElbowsOfRaisedArmsBendForwards) {
  for (const double abduction : {80.0, 100.0, 150.0}) {
    Body made = body({{"shoulder_left_abduction", abduction},
                      {"shoulder_right_abduction", abduction},
                      {"elbow_left_flexion", 60},
                      {"elbow_right_flexion", 60}});
    for (const bool interchanged : {false, true}) {
      if (interchanged)
        std::swap(made.phantom.landmarks.at("elbow_medial_left"),
                  made.phantom.landmarks.at("elbow_lateral_left"));
      const auto skeleton = build_skeleton(made.parts, made.phantom.landmarks);
      ASSERT_TRUE(skeleton) << skeleton.error().message();
      for (const char* part : {"forearm_left", "forearm_right"})
        EXPECT_NEAR(solid(skeleton->scene, part).switches.back().q.at(0) / degree, 60, 3)
            << part << ' ' << abduction << interchanged;
    }
  }
}

const Switch& ball(const Scene& scene, const std::string& part) {
  for (const Switch& one : solid(scene, part).switches)
    if (std::holds_alternative<Ball>(one.kind)) return one;
  throw std::runtime_error("no ball at " + part);
}

// a ball's start as a rotation vector about its axes, degrees
Vector3d start(const Scene& scene, const std::string& part) {
  const Switch& one = ball(scene, part);
  return logarithm(Quaternion(one.q.at(0), one.q.at(1), one.q.at(2), one.q.at(3))) / degree;
}

TEST(Skeleton, BallsMeasureAnatomicalAngles) {
  const Body still = body(),
             bent = body({{"hip_left_flexion", 30},
                          {"hip_right_flexion", 15},
                          {"ankle_left_dorsiflexion", -15},
                          {"shoulder_right_flexion", 50}}),
             spread = body({{"hip_left_abduction", 15},
                            {"shoulder_left_abduction", 40},
                            {"shoulder_right_abduction", 30}});
  const auto scene = [](const Body& made) {
    return build_skeleton(made.parts, made.phantom.landmarks)->scene;
  };
  const Scene rest = scene(still), flexed = scene(bent), abducted = scene(spread);
  // (its arms stand at 12 degrees of abduction)
  // The phantom turns its parts by its own angles, from a stance that is itself some degrees from the
  // anatomical position; components of rotation vectors add up only as far as turns commute: 5 % of the angle
  // and of that stance's about 5 degrees
  const auto change = [&](const Scene& posed, const char* part) {
    return Vector3d(start(posed, part) - start(rest, part));
  };
  EXPECT_NEAR(change(flexed, "thigh_left").x(), 30, 1.5);
  EXPECT_NEAR(change(flexed, "thigh_right").x(), 15, 0.75);
  EXPECT_NEAR(change(flexed, "foot_left").x(), -15, 0.75);
  EXPECT_NEAR(change(flexed, "upper_arm_right").x(), 50, 2.5);
  EXPECT_NEAR(change(abducted, "thigh_left").y(), -15, 0.75);
  EXPECT_NEAR(change(abducted, "upper_arm_left").y(), -28, 1.4);
  EXPECT_NEAR(change(abducted, "upper_arm_right").y(), -18, 0.9);
  EXPECT_LT(change(flexed, "foot_right").norm(), 1e-6);
  EXPECT_LT(change(abducted, "thigh_right").norm(), 1e-6);
  // the phantom's sides mirror each other, and so do coordinates and ranges
  for (const char* part : {"thigh", "foot", "upper_arm", "hand"}) {
    const std::string left = std::string(part) + "_left", right = std::string(part) + "_right";
    EXPECT_LT((start(rest, left) - start(rest, right)).norm(), 1e-6) << part;
    const auto &a = ball(rest, left).ranges, &b = ball(rest, right).ranges;
    ASSERT_EQ(a.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(a[i].lower, b[i].lower, 1e-8) << part;
      EXPECT_NEAR(a[i].upper, b[i].upper, 1e-8) << part;
    }
  }
  const std::vector<Range>& hip = ball(rest, "thigh_left").ranges;
  EXPECT_DOUBLE_EQ(hip[0].upper, 120 * degree);
  EXPECT_DOUBLE_EQ(hip[1].lower, -50 * degree);
  EXPECT_DOUBLE_EQ(hip[2].upper, 40 * degree);
}

TEST(Skeleton, StartOutsideARangeWidensIt) {
  // the left leg's points turned forwards about the hip, farther than the phantom itself can
  Body made = body();
  const Vector3d hip_centre = made.phantom.landmarks.find("hip_left")->second.point;
  for (auto& [name, landmark] : made.phantom.landmarks)
    if (name.ends_with("_left"))
      for (const char* of_leg : {"knee", "ankle", "medial_malleolus", "lateral_malleolus", "heel", "toe_tip"})
        if (name.starts_with(of_leg))
          landmark.point =
              hip_centre + rotation_about(Vector3d::UnitX(), -130 * degree) * (landmark.point - hip_centre);
  const auto skeleton = build_skeleton(made.parts, made.phantom.landmarks);
  ASSERT_TRUE(skeleton);
  const double flexion = start(skeleton->scene, "thigh_left").x();
  EXPECT_NEAR(flexion, 130, 5);  // the standing pose is some degrees off straight
  const std::vector<Range>& hip = ball(skeleton->scene, "thigh_left").ranges;
  EXPECT_NEAR(hip[0].upper, flexion * degree, 1e-12);
  EXPECT_DOUBLE_EQ(hip[0].lower, -30 * degree);
  ASSERT_EQ(skeleton->warnings.size(), 1u) << skeleton->warnings.back().text;
  EXPECT_EQ(skeleton->warnings[0].kind, WarningKind::range);
  const std::string& said = skeleton->warnings[0].text;
  EXPECT_NE(said.find("left hip flexion 1"), std::string::npos) << said;
  EXPECT_NE(said.find("degrees (-30 to 120)"), std::string::npos) << said;
  // it compiles, also after writing and reading its file
  ASSERT_TRUE(compile(skeleton->scene)) << compile(skeleton->scene).error().message();
  const auto back = parse_scene(write_scene(skeleton->scene).value(), "scene.toml");
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_TRUE(compile(*back)) << compile(*back).error().message();
}

// In a coarse scan, landmark errors bend a straight elbow slightly backwards. 2 mm at the wrist (0.5 degrees)
// matter if landmarks are exact, but not if the wrist has its usual deviation of 5 mm.
TEST(Skeleton, IgnoresAnglesOutsideByLessThanTheirDeviation) {
  for (const double deviation : {0.01, 5.0}) {
    Body made = body();
    Landmark& wrist = made.phantom.landmarks.find("wrist_left")->second;
    const Vector3d elbow = made.phantom.landmarks.find("elbow_left")->second.point;
    wrist.deviation = deviation;
    // backwards, perpendicular to the forearm
    EXPECT_TRUE(build_skeleton(made.parts, made.phantom.landmarks)->warnings.empty());
    wrist.point = elbow + rotation_about(Vector3d::UnitX(), 0.5 * degree) * (wrist.point - elbow);
    const auto skeleton = build_skeleton(made.parts, made.phantom.landmarks);
    ASSERT_TRUE(skeleton);
    EXPECT_EQ(skeleton->warnings.size(), deviation < 1 ? 1U : 0U) << deviation;
    // the start lies within the range in both cases
    const Solid* forearm = nullptr;
    for (const Solid& solid : skeleton->scene.solids)
      if (solid.name == "forearm_left") forearm = &solid;
    ASSERT_NE(forearm, nullptr);
    const Switch& hinge = forearm->switches.back();
    EXPECT_LT(hinge.q[0], 0);
    EXPECT_LE(hinge.ranges[0].lower, hinge.q[0]);
  }
}

TEST(Skeleton, TrunkWithoutANeckHasNoNeckRanges) {
  Body made = body();
  made.phantom.landmarks.erase("neck");
  const auto skeleton = build_skeleton(made.parts, made.phantom.landmarks);
  ASSERT_TRUE(skeleton);
  EXPECT_TRUE(ball(skeleton->scene, "middle_trunk").ranges.empty());
}

TEST(JointAxes, IgnoresStartsOutsideByRounding) {
  const JointAxes hip = joint_axes("hip_left");  // flexion -30 to 120 degrees
  std::vector<Warning> warnings;
  auto ranges = ranges_with_start(hip, Vector3d(120.04, 0, 0) * degree, "hip_left", warnings);
  EXPECT_TRUE(warnings.empty());
  EXPECT_DOUBLE_EQ(ranges[0].upper, 120.04 * degree);  // the range includes the start
  ranges = ranges_with_start(hip, Vector3d(-30.06, 0, 0) * degree, "hip_left", warnings);
  EXPECT_EQ(warnings.size(), 1u);
  // nor an excess within its own deviation
  warnings.clear();
  ranges_with_start(hip, Vector3d(122, 0, 0) * degree, "hip_left", warnings, Vector3d(3, 0, 0) * degree);
  EXPECT_TRUE(warnings.empty());
  ranges_with_start(hip, Vector3d(124, 0, 0) * degree, "hip_left", warnings, Vector3d(3, 9, 9) * degree);
  EXPECT_EQ(warnings.size(), 1u);
}

TEST(JointAxes, RotateInTheNamedDirection) {
  // in anatomical axes: X forwards, Y up, Z to the right
  const Vector3d front = Vector3d::UnitX(), up = Vector3d::UnitY(), right = Vector3d::UnitZ();
  for (const char* side : {"_left", "_right"}) {
    const Vector3d medial = side == std::string("_left") ? right : Vector3d(-right);
    for (const char* kind : {"hip", "shoulder", "wrist", "ankle"}) {
      const Eigen::Matrix3d A = joint_axes(std::string(kind) + side).R_FA;
      EXPECT_NEAR(A.determinant(), 1, 1e-15);
      // velocity of a point of the part under rotation about the axis
      EXPECT_EQ(A.col(0).cross(-up), front) << "flexion: the lower end goes forwards";
      EXPECT_EQ(A.col(1).cross(-up), medial) << "adduction: the lower end goes to the midline";
      EXPECT_EQ(A.col(2).cross(front), medial) << "internal rotation: the front goes to the midline";
    }
  }
  for (const char* joint : {"neck", "spine_upper", "spine_lower"}) {
    const Eigen::Matrix3d A = joint_axes(joint).R_FA;
    EXPECT_NEAR(A.determinant(), 1, 1e-15);
    EXPECT_EQ(A.col(0).cross(up), front) << "flexion: the upper end goes forwards";
    EXPECT_EQ(A.col(1).cross(up), -right) << "bending: the upper end goes left";
    EXPECT_EQ(A.col(2).cross(front), -right) << "rotation: the front goes left";
  }
  EXPECT_EQ(joint_axes("ankle_left").axes[1].motion, "inversion");
  EXPECT_EQ(joint_axes("wrist_right").axes[2].motion, "pronation");
  EXPECT_DOUBLE_EQ(joint_axes("shoulder_left").axes[1].range.lower, -120 * degree);
  EXPECT_DOUBLE_EQ(joint_axes("ankle_left").axes[2].range.upper, 180 * degree);  // no published range
}

TEST(Skeleton, LeapStartsAsOneRigidBody) {
  const Body made = body();
  SkeletonOptions options;
  options.leap->flight_time = 0.8;
  options.leap->somersault_rate_deg = -100;
  const auto skeleton = build_skeleton(made.parts, made.phantom.landmarks, options);
  ASSERT_TRUE(skeleton);
  const Solid& root = solid(skeleton->scene, "lower_trunk");
  Vector3d velocity, position;
  for (int i = 0; i < 3; ++i)
    velocity[i] = root.switches.at(i).v.at(0), position[i] = root.switches.at(i).q.at(0);
  const Vector3d omega = Eigen::Map<const Vector3d>(root.switches.at(3).v.data());
  // the gravity centre's velocity is vertical, g t / 2, so it is back after t
  const Vector3d centre = velocity + omega.cross(made.phantom.whole.centre - position);
  EXPECT_LT((centre - Vector3d(0, 0, 9.81 * 0.4)).norm(), 1e-9);
  EXPECT_NEAR(omega.norm(), 100 * degree, 1e-12);
  EXPECT_NEAR(omega.x(), -100 * degree,
              1e-3);  // the phantom stands upright, so its left is x to rounding
}

TEST(Skeleton, InventsNoMissingParts) {
  Body made = body();
  for (const char* gone : {"head", "thigh_left", "upper_arm_right"}) made.parts.erase(gone);
  made.phantom.landmarks.erase("ankle_right");
  const auto skeleton = build_skeleton(made.parts, made.phantom.landmarks);
  ASSERT_TRUE(skeleton);
  EXPECT_EQ(skeleton->scene.solids.size(), 13u);
  EXPECT_EQ(solid(skeleton->scene, "shank_left").parent, world_name);  // free, because its thigh is missing
  EXPECT_EQ(solid(skeleton->scene, "forearm_right").parent, world_name);
  EXPECT_EQ(solid(skeleton->scene, "foot_right").switches.size(), 1u);  // welded: its joint is unknown
  EXPECT_EQ(skeleton->warnings.size(), 3u);
  EXPECT_FALSE(build_skeleton({}, made.phantom.landmarks));
}

// A trunk as one solid: its parts' children attach to it at the same joints, and the whole body is unchanged.
TEST(Skeleton, GroupsOfPartsBecomeOneSolidEach) {
  const Body made = body();
  PartInertials some;
  for (const auto& [name, inertial] : made.parts) {
    const bool trunk = name.ends_with("trunk"),
               leg = name == "thigh_left" || name == "shank_left" || name == "foot_left";
    Inertial& solid = some[trunk ? "trunk" : leg ? "leg_left" : name];
    solid += inertial;
  }
  const auto skeleton = build_skeleton(some, made.phantom.landmarks);
  ASSERT_TRUE(skeleton) << skeleton.error().message();
  EXPECT_TRUE(skeleton->warnings.empty()) << skeleton->warnings.front().text;
  ASSERT_EQ(skeleton->scene.solids.size(), 12u);
  for (const auto& [name, parent, joint] : {std::array{"trunk", "world", "mid_hip"},
                                            {"head", "trunk", "neck"},
                                            {"upper_arm_left", "trunk", "shoulder_left"},
                                            {"leg_left", "trunk", "hip_left"},
                                            {"thigh_right", "trunk", "hip_right"},
                                            {"shank_right", "thigh_right", "knee_right"}}) {
    EXPECT_EQ(solid(skeleton->scene, name).parent, parent) << name;
    const Pose X = pose(skeleton->scene, name);
    EXPECT_LT((X.p - 1e-3 * made.phantom.landmarks.at(joint).point).norm(), 1e-12) << name;
    EXPECT_LT((X.R - Eigen::Matrix3d::Identity()).norm(), 1e-13) << name;
    EXPECT_LT((X * solid(skeleton->scene, name).inertials.at(0).centre - some.at(name).centre).norm(), 1e-12)
        << name;
  }
}

TEST(Skeleton, AllNamesAreKnownBeforeBuilding) {
  const Body made = body();
  std::vector<std::string> all;
  for (const auto& [name, inertial] : made.parts) all.push_back(name);
  const SkeletonNames names = skeleton_names(all);
  EXPECT_EQ(names.solids.size(), 16u);
  const auto known = [](const std::vector<std::string>& list, const std::string& name) {
    return std::ranges::find(list, name) != list.end();
  };
  for (const std::string& missing : all) {
    PartInertials present = made.parts;
    present.erase(missing);
    const auto skeleton = build_skeleton(present, made.phantom.landmarks);
    ASSERT_TRUE(skeleton) << skeleton.error().message();
    for (const Solid& s : skeleton->scene.solids) {
      EXPECT_TRUE(known(names.solids, s.name)) << s.name;
      for (const Switch& step : s.switches)
        EXPECT_TRUE(step.coordinate.empty() || known(names.coordinates, step.coordinate)) << step.coordinate;
    }
  }
  const SkeletonNames groups = skeleton_names({"trunk", "leg_left"});
  EXPECT_TRUE(known(groups.coordinates, "trunk_turn"));
  EXPECT_TRUE(known(groups.coordinates, "hip_left"));
  EXPECT_FALSE(known(groups.coordinates, "knee_left"));
}

TEST(Skeleton, CutPartsCarryTheReasonOfTheirRow) {
  InertiaTable table;
  InertiaRow row;
  row.part = "forearm_left";
  row.completeness = Completeness::cut;
  row.notes = {"no wrist was found: this part includes the hand"};
  row.inertial.mass = 1;
  table.rows.push_back(row);
  std::vector<Warning> warnings;
  EXPECT_TRUE(movable_parts(table, warnings).contains("forearm_left"));
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].text.find("no wrist was found"), std::string::npos) << warnings[0].text;
  EXPECT_EQ(warnings[0].text.find("edge"), std::string::npos) << warnings[0].text;
  // a stump counts as the whole part
  table.rows[0].notes = {"stump: hand is stated as absent"};
  warnings.clear();
  EXPECT_TRUE(movable_parts(table, warnings).contains("forearm_left"));
  EXPECT_TRUE(warnings.empty());
}

TEST(Skeleton, JointInertiaEqualsTwoBodiesOnAHinge) {
  // two uniform bars of 1 m hinged at their ends: each has m l^2 / 3 about the hinge
  const Inertial bar{3, {0, 0, -0.5}, Vector3d(0.25, 0.25, 0).asDiagonal()};
  const Inertial other{6, {0, 0, 0.5}, Vector3d(0.5, 0.5, 0).asDiagonal()};
  EXPECT_NEAR(joint_inertia(bar, other, Vector3d::Zero(), Vector3d::UnitX()), 1.0 * 2.0 / 3.0, 1e-15);
}

TEST(Skeleton, FliesOnAParabolaAndKeepsItsSpin) {
  const Body made = body();
  const auto skeleton = build_skeleton(made.parts, made.phantom.landmarks);
  ASSERT_TRUE(skeleton);
  const auto system = compile(skeleton->scene);
  ASSERT_TRUE(system) << system.error().message();
  EXPECT_EQ(system->nv, 6 + 11 * 3 + 4);
  const auto trajectory = simulate(*system);
  ASSERT_TRUE(trajectory) << trajectory.error().message();
  EXPECT_TRUE(trajectory->certificate.trusted) << trajectory->certificate.reason;
  // the gravity centre in flight follows a parabola. The tolerance is 1e-6 per step and coordinate; errors of
  // rates add up over about a hundred steps
  for (std::size_t row = 0; row < trajectory->times.size(); ++row) {
    const double t = trajectory->times[row];
    const Vector3d exact = made.phantom.whole.centre + Vector3d(0, 0, 9.81 * 0.5 * t - 9.81 * t * t / 2);
    EXPECT_LT((trajectory->gravity_centre.row(static_cast<Eigen::Index>(row)).transpose() - exact).norm(),
              1e-5)
        << t;
  }
  // its stops keep it within its ranges
  for (const LoggedEvent& event : trajectory->certificate.events)
    if (!event.kind.starts_with("stop_"))
      ADD_FAILURE() << event.kind << ", " << event.name << " at " << event.time << " s";
  // it tucks: the knees bend by more than 60 degrees and stay within their range
  double most = 0, least = 0;
  for (const CoordinateInfo& c : trajectory->coordinates)
    if (c.name.starts_with("knee")) {
      most = std::max(most, trajectory->q.col(c.q_index).maxCoeff());
      least = std::min(least, trajectory->q.col(c.q_index).minCoeff());
    }
  EXPECT_GT(most, 60 * degree);
  EXPECT_LT(most, 120 * degree);
  EXPECT_GT(least, -5 * degree);
}

TEST(JointRanges, ReadsTheTable) {
  EXPECT_EQ(joint_ranges().size(), 22u);
  EXPECT_DOUBLE_EQ(joint_ranges().at("knee flexion").upper, 120 * degree);
  for (const auto& [name, range] : joint_ranges()) EXPECT_LT(range.lower, range.upper) << name;
}

}  // namespace
}  // namespace borelli::skeleton_test
