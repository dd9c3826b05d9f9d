// Joint angles from tables on the phantom: its own angles are recovered; OpenSim's agree with the bodies of
// an OpenSim model and with explicit rotations.
#include "pipeline/motion/angle_motion.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "dynamics/formats/model_file.hpp"
#include "pipeline/body/segment_frames.hpp"
#include "pipeline/motion/captured_motion.hpp"
#include "pipeline/motion/gait_angles.hpp"
#include "pipeline/motion/motion_efforts_table.hpp"
#include "pipeline/motion/sample_walk.hpp"
#include "pipeline/motion/walk_markers.hpp"
#include "pipeline/recordings/motion_table_file.hpp"
#include "tests/paths.hpp"
#include "tests/pipeline/motion/phantom_recording.hpp"

namespace borelli::test::angle_motion_test {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double degree = std::numbers::pi / 180;
constexpr double rounding = 1e-12;

template <class T>
T need(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message());
  return std::move(*result);
}

struct Body {
  Phantom phantom = build_phantom({}).value();
  Scene scene = still_body(exact_parts(phantom), phantom.landmarks);
  System system = need(compile(scene));

  /// World axes of a segment's anatomical frame (X forwards, Y up, Z to the right).
  Matrix3d axes(SolidPoses& poses, const std::string& segment) const {
    const SegmentFrame frame = segment_frame(segment, phantom.landmarks, {}).value();
    return poses.of(solid_index(system, segment)).R * frame.R_WA;
  }
  Vector3d middle_of_asis() const {
    return 1e-3 * (phantom.landmarks.at("asis_left").point + phantom.landmarks.at("asis_right").point) / 2;
  }
};

const Body& body() {
  static const Body made;
  return made;
}

MotionTable table_of_row(const std::vector<std::pair<std::string, double>>& values) {
  MotionTable out{"", {}, {0}, Eigen::MatrixXd(1, std::ssize(values)), true};
  for (const auto& [name, value] : values) {
    out.values(0, std::ssize(out.columns)) = value;
    out.columns.push_back(name);
  }
  return out;
}

/// OpenSim's ground, whose y is up, in the world.
Matrix3d upright() { return AngleAxisd(90 * degree, Vector3d::UnitX()).toRotationMatrix(); }

// The walk that OpenSim itself computed, on OpenSim's own model (tested against OpenSim by gait10dof_test)
// and on the phantom: pelvis and thighs have the same axes. Knees are hinges about other axes but bend by the
// same angle.
TEST(AngleMotion, PelvisAndThighsTurnAsThoseOfOpenSimsModel) {
  const std::string folder = shared_folder() + "/motion/gait10dof/";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no " << folder;
  const MotionTable walk = need(read_motion_table(folder + "subject01_walk_IK.mot")).table;
  const Scene model = need(read_model(folder + "subject01.osim")).scene;
  const System model_system = need(compile(model));
  const auto theirs = need(positions_in(model_system, walk)).positions;
  const AngleMotion ours = need(angle_motion(body().system, body().phantom.landmarks, walk));
  ASSERT_EQ(ours.positions.q.rows(), theirs.q.rows());
  SolidPoses poses(body().system), model_poses(model_system);
  for (const Eigen::Index i : {0, 40, 90, 150}) {
    poses.update(0, ours.positions.q.row(i).transpose());
    model_poses.update(0, theirs.q.row(i).transpose());
    for (const auto& [mine, other] :
         {std::pair{"lower_trunk", "pelvis"}, {"thigh_left", "femur_l"}, {"thigh_right", "femur_r"}}) {
      const Matrix3d expected = upright() * model_poses.of(solid_index(model_system, other)).R;
      EXPECT_LT((body().axes(poses, mine) - expected).norm(), rounding) << mine << " in row " << i;
    }
    const auto pelvis = solid_index(model_system, "pelvis");
    SolidPoses start(body().system);
    start.update(0, body().system.initial.q);
    const int trunk = solid_index(body().system, "lower_trunk");
    const Vector3d asis = poses.of(trunk) * Vector3d(start.of(trunk).inverse() * body().middle_of_asis());
    // the model's joint holds the pelvis 2 cm beside the plane of motion, and the table has no pelvis_tz
    const Vector3d expected = upright() * model_poses.of(pelvis).p;
    EXPECT_NEAR(asis.x(), expected.x(), rounding);
    EXPECT_NEAR(asis.z(), expected.z(), rounding);
    const double knee =
        walk.values(i, std::ranges::find(walk.columns, "knee_angle_r") - walk.columns.begin());
    for (const CoordinateInfo& c : body().system.coordinates) {
      if (c.name != "knee_right") continue;
      EXPECT_NEAR(ours.positions.q(i, c.q_index), -knee * degree, rounding);
    }
  }
}

// OpenSim's joints turn about z, x, y in this order; on the left, x and y are reversed (see the table's
// source).
TEST(AngleMotion, JointsTurnInOpenSimsOrderAndSigns) {
  const auto about = [](double deg, const Vector3d& axis) -> Matrix3d {
    return AngleAxisd(deg * degree, axis).toRotationMatrix();
  };
  const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY(), z = Vector3d::UnitZ();
  const AngleMotion motion = need(angle_motion(body().system, body().phantom.landmarks,
                                               table_of_row({{"pelvis_tilt", 5},
                                                             {"pelvis_list", -12},
                                                             {"pelvis_rotation", 25},
                                                             {"pelvis_ty", 0.9},
                                                             {"hip_flexion_r", 40},
                                                             {"hip_adduction_r", -15},
                                                             {"hip_rotation_r", 20},
                                                             {"hip_flexion_l", 10},
                                                             {"hip_adduction_l", 8},
                                                             {"hip_rotation_l", -30},
                                                             {"lumbar_extension", -20},
                                                             {"lumbar_bending", 10},
                                                             {"lumbar_rotation", 5},
                                                             {"arm_flex_l", 30},
                                                             {"arm_add_l", -60},
                                                             {"arm_rot_l", 15},
                                                             {"ankle_angle_r", 12}})));
  SolidPoses poses(body().system);
  poses.update(0, motion.positions.q.row(0).transpose());
  const auto axes = [&](const char* segment) { return body().axes(poses, segment); };
  const Matrix3d pelvis = upright() * about(5, z) * about(-12, x) * about(25, y);
  EXPECT_LT((axes("lower_trunk") - pelvis).norm(), rounding);
  EXPECT_LT((axes("thigh_right") - pelvis * about(40, z) * about(-15, x) * about(20, y)).norm(), rounding);
  EXPECT_LT((axes("thigh_left") - pelvis * about(10, z) * about(8, -x) * about(-30, -y)).norm(), rounding);
  const Matrix3d trunk = pelvis * about(-20, z) * about(10, x) * about(5, y);
  EXPECT_LT((axes("middle_trunk") - trunk).norm(), rounding);
  EXPECT_LT((axes("upper_trunk") - trunk).norm(), rounding);  // the upper spine stays straight
  EXPECT_LT((axes("upper_arm_left") - trunk * about(30, z) * about(-60, -x) * about(15, -y)).norm(),
            rounding);
  EXPECT_LT((axes("foot_right") - axes("shank_right") * about(12, z)).norm(), rounding);
}

// Rajagopal's knees bend to positive angles, those of gait2392 to negative ones.
TEST(AngleMotion, KneesBendWhicheverSignTheModelHas) {
  for (const double sign : {1.0, -1.0}) {
    MotionTable table{"", {"knee_angle_l"}, {0, 1}, Eigen::MatrixXd(2, 1), true};
    table.values << -5 * sign, 60 * sign;
    const AngleMotion motion = need(angle_motion(body().system, body().phantom.landmarks, table));
    for (const CoordinateInfo& c : body().system.coordinates)
      if (c.name == "knee_left") {
        EXPECT_NEAR(motion.positions.q(0, c.q_index), -5 * degree, rounding);
        EXPECT_NEAR(motion.positions.q(1, c.q_index), 60 * degree, rounding);
      }
    EXPECT_EQ(motion.warnings.size(), 1U);  // the other joints have no column
  }
}

TEST(AngleMotion, RefusesTablesWithoutAnglesOrWithGaps) {
  const auto other = angle_motion(body().system, body().phantom.landmarks, table_of_row({{"force_vx", 1}}));
  ASSERT_FALSE(other);
  EXPECT_NE(other.error().message().find("expected its own coordinates or OpenSim's"), std::string::npos);
  const auto gap =
      angle_motion(body().system, body().phantom.landmarks, table_of_row({{"hip_flexion_r", std::nan("")}}));
  ASSERT_FALSE(gap);
  EXPECT_NE(gap.error().message().find("'hip_flexion_r'"), std::string::npos);
}

/// The largest difference of joint moments, except while a foot bears less than 25 N, because plates count
/// from 20 N.
double largest_difference(const CapturedMotion& motion, const SampleWalk& walk) {
  double largest = 0;
  for (Eigen::Index i = 0; i < motion.efforts.efforts.rows(); ++i) {
    const bool edge = std::ranges::any_of(walk.loads, [&](const ExternalLoad& load) {
      const double force = load.measured.force.col(i).norm();
      return force > 0 && force < 25;
    });
    if (edge) continue;
    largest = std::max(largest,
                       (motion.efforts.efforts.row(i) - walk.efforts.efforts.row(i)).cwiseAbs().maxCoeff());
  }
  return largest;
}

/// Angles as `run` writes them, through the text of the file.
MotionTable written(const System& system, const RecordedPositions& positions) {
  MotionFit fit;
  fit.times = positions.times;
  fit.q = positions.q;
  const std::string text = need(motion_table_text(table_of(system, fit), "angles.mot"));
  return need(parse_motion_table(text, "angles.mot")).table;
}

struct Walk {
  FootSoles soles = standing_soles(body().phantom.landmarks);
  SampleWalk walk =
      need(sample_walk(body().scene, need(walk_markers(body().scene, body().phantom.landmarks)), soles));
};
const Walk& sample() {
  static const Walk made;
  return made;
}

std::vector<MeasuredForce> forces_of(const SampleWalk& walk) {
  std::vector<MeasuredForce> out;
  for (const ExternalLoad& load : walk.loads) out.push_back(load.measured);
  return out;
}

// The file keeps all digits but converts hinge angles to degrees and back, one rounding each way.
TEST(CapturedAngles, RecoversItsOwnAnglesAndMoments) {
  const SampleWalk& walk = sample().walk;
  const CapturedMotion motion =
      need(captured_angles({body().scene, sample().soles}, body().phantom.landmarks,
                           {written(body().system, walk.positions), forces_of(walk), {}}, {.cutoff = 0}));
  EXPECT_LT((motion.positions.q - walk.positions.q).cwiseAbs().maxCoeff(), rounding);
  EXPECT_TRUE(motion.fit.markers.empty());
  // equal positions and forces up to rounding, which 100 Hz squared amplifies
  EXPECT_LT(largest_difference(motion, walk), 1e-5);
}

// Plates measure in OpenSim's axes, y up; the mean force shows which way is up.
TEST(CapturedAngles, FindsUpFromTheForces) {
  const SampleWalk& walk = sample().walk;
  std::vector<MeasuredForce> forces = forces_of(walk);
  for (MeasuredForce& force : forces)
    for (Eigen::Matrix3Xd* values : {&force.force, &force.point, &force.moment})
      *values = upright().transpose() * *values;
  const CapturedMotion motion =
      need(captured_angles({body().scene, sample().soles}, body().phantom.landmarks,
                           {written(body().system, walk.positions), forces, {}}, {.cutoff = 0}));
  EXPECT_LT(largest_difference(motion, walk), 1e-5);
}

// A person 1.08 times as large with the same angles: only the root's path, 1.08 times as long, shows the
// size.
TEST(CapturedAngles, AnotherPersonsSizeIsFoundAndItsFeetStand) {
  constexpr double size = 1.08;
  RecordedPositions larger = sample().walk.positions;
  for (const CoordinateInfo& c : body().system.coordinates)
    if (c.kind == "translation") larger.q.col(c.q_index) *= size;
  std::vector<MeasuredForce> forces = forces_of(sample().walk);
  for (MeasuredForce& force : forces) force.force *= size * size * size, force.point *= size;
  const CapturedMotion motion =
      need(captured_angles({body().scene, sample().soles}, body().phantom.landmarks,
                           {written(body().system, larger), forces, {}}, {.other_person = true}));
  EXPECT_NEAR(motion.length_ratio, 1 / size, 0.005);  // the soles sink by millimetres at heel strike
  EXPECT_NEAR(motion.mass_ratio, 1 / (size * size * size), 0.04);  // as in CapturedMotion's test
  expect_feet_stand(body().system, motion.positions, sample().walk.timing, sample().soles,
                    {{0, 0.05, 0.3}, {1, 0.15, stance_share - 0.05}});
}

}  // namespace
}  // namespace borelli::test::angle_motion_test
