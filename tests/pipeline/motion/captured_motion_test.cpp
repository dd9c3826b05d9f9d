// Captured motions on the phantom: its own motion is recovered, and motions of larger persons derived from it
// are fitted.
#include "pipeline/motion/captured_motion.hpp"

#include <gtest/gtest.h>

#include "dynamics/numbers/rotation_vector.hpp"
#include "pipeline/motion/gait_angles.hpp"
#include "pipeline/motion/recorded_trajectory.hpp"
#include "pipeline/motion/sample_walk.hpp"
#include "pipeline/motion/scaled_scene.hpp"
#include "pipeline/motion/walk_markers.hpp"
#include "tests/pipeline/motion/phantom_recording.hpp"

namespace borelli::test::captured_motion_test {
namespace {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;

const std::map<std::string, double> squat{{"hip_left", 60},   {"hip_right", 60},     {"knee_left", 80},
                                          {"knee_right", 80}, {"ankle_left", 15},    {"ankle_right", 15},
                                          {"elbow_left", 40}, {"shoulder_right", 30}};

struct Subject {
  Phantom phantom = build_phantom({}).value();
  PartInertials parts = exact_parts(phantom);
  Scene scene = still_body(parts, phantom.landmarks);
  BodyMarkers markers =
      body_markers(marker_names(), phantom.landmarks, segments_of(scene), PointKind::markers);
  Scene marked = with_known_markers(scene, markers);
};

const Subject& subject() {
  static const Subject made;
  return made;
}

template <class T>
T need(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message());
  return std::move(*result);
}

/// Largest difference of a joint's rotation between two rows of positions, rad.
double largest_turn(const System& system, const std::string& joint, const RecordedPositions& a,
                    const RecordedPositions& b) {
  double largest = 0;
  for (const CoordinateInfo& c : system.coordinates)
    for (Eigen::Index i = 0; c.name == joint && i < a.q.rows(); ++i) {
      if (c.q_size == 1) {
        largest = std::max(largest, std::abs(a.q(i, c.q_index) - b.q(i, c.q_index)));
        continue;
      }
      const Quaternion one = a.q.row(i).segment<4>(c.q_index).transpose(),
                       other = b.q.row(i).segment<4>(c.q_index).transpose();
      largest = std::max(largest, logarithm(product(conjugate(one), other)).norm());
    }
  return largest;
}

TEST(BodyMarkers, KnowsCommonMarkerNamesWithTheSideBeforeOrAfter) {
  const Subject& s = subject();
  const auto places =
      body_markers({"RASI", "L.ASIS", "subject1:LKNE", "right_heel", "MT5_L", "C7", "THI_R", "XYZ"},
                   s.phantom.landmarks, segments_of(s.scene), PointKind::markers);
  ASSERT_EQ(places.markers.size(), 7U);
  EXPECT_EQ(places.unknown, std::vector<std::string>{"XYZ"});
  const auto at = [&](std::size_t i) { return places.markers[i].point.value(); };
  const auto landmark = [&](const char* name) -> Vector3d {
    return 1e-3 * s.phantom.landmarks.find(name)->second.point;
  };
  EXPECT_EQ(at(0), landmark("asis_right"));
  EXPECT_EQ(at(1), landmark("asis_left"));
  EXPECT_EQ(at(2), landmark("knee_lateral_left"));
  EXPECT_EQ(places.markers[2].segment, "thigh_left");
  EXPECT_EQ(at(3), landmark("heel_right"));
  EXPECT_EQ(at(4), landmark("metatarsal_5_left"));
  EXPECT_EQ(at(5), landmark("cervicale"));
  EXPECT_FALSE(places.markers[6].point);  // a cluster's marker: its position on the thigh is unknown
  EXPECT_EQ(places.markers[6].segment, "thigh_right");
}

TEST(BodyMarkers, OwnNamesOverrideTheTable) {
  const Subject& s = subject();
  const auto own = need(parse_joint_mapping("m1 = hip_left\nC7 = shank_right\n", "map.txt", marker_places()));
  const auto places =
      body_markers({"m1", "C7"}, s.phantom.landmarks, segments_of(s.scene), PointKind::markers, own);
  ASSERT_EQ(places.markers.size(), 2U);
  EXPECT_EQ(places.markers[0].segment, "thigh_left");
  EXPECT_EQ(places.markers[1].segment, "shank_right");
  EXPECT_FALSE(places.markers[1].point);
}

// The rest weights pull each joint back by up to 1e-3 rad; markers are exact otherwise.
TEST(CapturedMotion, RecoversItsOwnMotionWithAnyAxisUp) {
  const Subject& s = subject();
  const System system = need(compile(s.marked));
  const RecordedPositions truth = bending(system, squat);
  for (const Vector3d& up : {Vector3d(0, 0, 1), Vector3d(0, 1, 0), Vector3d(-1, 0, 0)}) {
    CapturedRecording recording;
    recording.motion = recording_of(s.marked, truth, up);
    const auto motion = need(captured_motion({s.scene, {}}, s.markers, recording, {.cutoff = 0}));
    EXPECT_LT(motion.landmark_distance, 1e-3);
    for (const auto& [joint, angle] : squat)
      EXPECT_LT(largest_turn(system, joint, truth, motion.positions), 5e-3) << joint;
    EXPECT_LT(motion.fit.rms(), 1e-3);
  }
}

// A gap is not a zero: hidden markers do not change the fit of the others.
TEST(CapturedMotion, HiddenMarkersAreLeftOut) {
  const Subject& s = subject();
  const System system = need(compile(s.marked));
  const RecordedPositions truth = bending(system, squat);
  CapturedRecording recording;
  recording.motion = recording_of(s.marked, truth);
  const auto hidden = std::ranges::find(recording.motion.names, "R.Heel") - recording.motion.names.begin();
  for (std::size_t f = 10; f < 40; ++f)
    recording.motion.frames[f].col(hidden).setConstant(std::numeric_limits<double>::quiet_NaN());
  const auto motion = need(captured_motion({s.scene, {}}, s.markers, recording, {.cutoff = 0}));
  EXPECT_LT(largest_turn(system, "ankle_right", truth, motion.positions), 5e-3);
}

TEST(CapturedMotion, TrajectoryHasTheEnergiesOfTheMotion) {
  const Subject& s = subject();
  const System system = need(compile(s.marked));
  CapturedRecording recording;
  recording.motion = recording_of(s.marked, bending(system, squat));
  const auto motion = need(captured_motion({s.scene, {}}, s.markers, recording, {.cutoff = 0}));
  const Trajectory trajectory = need(recorded_trajectory(need(compile(motion.scene)), motion.efforts));
  // the powers of joints and root integrate to the change of energy; the trapezoidal rule over 1/30 s of a
  // motion at 0.5 Hz errs by (pi/30)^2 / 12 = 0.1 % of the turnover
  double work = 0, turnover = 0;
  for (Eigen::Index i = 1; i < motion.efforts.powers.rows(); ++i) {
    const double step = (motion.efforts.powers.row(i).sum() + motion.efforts.powers.row(i - 1).sum()) / 2 *
                        (motion.efforts.times[std::size_t(i)] - motion.efforts.times[std::size_t(i - 1)]);
    work += step;
    turnover += std::abs(step);
    EXPECT_NEAR(trajectory.work[std::size_t(i)], work, 0.01 * turnover + 1e-3) << i;
  }
}

TEST(CapturedMotion, OtherPersonsAnglesFitTheBodysSize) {
  const Subject& s = subject();
  std::vector<double> factors;
  for (const Solid& solid : s.marked.solids)
    factors.push_back(solid.name.starts_with("thigh") || solid.name.starts_with("shank") ? 1.08 : 1.04);
  const Scene person = scaled(s.marked, factors).scene;
  const System system = need(compile(person));
  const RecordedPositions truth = bending(system, squat);
  CapturedRecording recording;
  recording.motion = recording_of(person, truth);
  recording.trial = recording_of(person, {{0}, system.initial.q.transpose()});
  const auto motion =
      need(captured_motion({s.scene, {}}, s.markers, recording, {.other_person = true, .cutoff = 0}));
  EXPECT_NEAR(motion.length_ratio, 1 / 1.08, 0.01);
  // sizes are found within their 10 % prior: a joint centre that is 5 mm off turns a limb of 0.4 m by 0.7
  // degrees
  for (const auto& [joint, angle] : squat)
    EXPECT_LT(largest_turn(system, joint, truth, motion.positions), 0.07) << joint;
}

// A person 1.08 times as large as the phantom walks with marker paths scaled by 1.08. The smaller body's feet
// must stand when the person's do: the heel for a third of the cycle, then the ball of the foot until
// toe-off.
TEST(CapturedMotion, FeetOfAnotherPersonsWalkNeitherSlideNorSink) {
  const Subject& s = subject();
  constexpr double size = 1.08;
  const auto places = need(walk_markers(s.scene, s.phantom.landmarks));
  const FootSoles soles = standing_soles(s.phantom.landmarks);
  const SampleWalk walk = need(sample_walk(s.scene, places, soles));
  Scene placed = s.scene;
  for (const auto& [name, at] : places) placed.markers.push_back({name, at});
  const System system = need(compile(placed));
  CapturedRecording recording;
  recording.motion = walk.markers;
  recording.trial = recording_of(placed, {{0}, system.initial.q.transpose()});
  for (MarkerMotion* markers : {&recording.motion, &*recording.trial})
    for (Matrix3Xd& frame : markers->frames) frame *= size;
  for (const ExternalLoad& load : walk.loads) {
    recording.forces.push_back(load.measured);
    recording.forces.back().force *= size * size * size;
    recording.forces.back().point *= size;
    recording.forces.back().moment *= size * size * size * size;
  }
  const BodyMarkers markers =
      body_markers(recording.motion.names, s.phantom.landmarks, segments_of(s.scene), PointKind::markers);
  const auto motion = need(captured_motion({s.scene, soles}, markers, recording, {.other_person = true}));
  EXPECT_NEAR(motion.length_ratio, 1 / size, 0.01);
  // times are not scaled, so accelerations do not match a body of this size: its mass is found within 5 %
  EXPECT_NEAR(motion.mass_ratio, 1 / (size * size * size), 0.04);

  expect_feet_stand(system, motion.positions, walk.timing, soles,
                    {{0, 0.05, 0.3}, {1, 0.15, stance_share - 0.05}});
}

TEST(CapturedMotion, RefusesMarkersWithoutKnownPlaces) {
  const Subject& s = subject();
  const System system = need(compile(s.marked));
  CapturedRecording recording;
  recording.motion = recording_of(s.marked, bending(system, squat));
  for (std::size_t m = 0; m < recording.motion.names.size(); ++m)
    recording.motion.names[m] = "M" + std::to_string(m) + "x";
  const BodyMarkers none =
      body_markers(recording.motion.names, s.phantom.landmarks, segments_of(s.scene), PointKind::markers);
  const auto motion = captured_motion({s.scene, {}}, none, recording, {});
  ASSERT_FALSE(motion);
  EXPECT_NE(motion.error().message().find("which way is up"), std::string::npos) << motion.error().message();
}

}  // namespace
}  // namespace borelli::test::captured_motion_test
