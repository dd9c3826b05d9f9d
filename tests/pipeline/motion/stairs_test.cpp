// A walk down a stair: flexion against the capture system's (stairs_case.hpp), and the phantom's feet on the
// steps.
#include <filesystem>

#include "pipeline/motion/captured_motion.hpp"
#include "pipeline/motion/walk_markers.hpp"
#include "tests/paths.hpp"
#include "tests/pipeline/motion/stairs_case.hpp"

namespace borelli::test::stairs_test {
namespace {

class Stairs : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(folder_ + "Movement_trial.c3d")) GTEST_SKIP() << "no " << folder_;
  }
  const std::string folder_ = shared_folder() + "/motion/";
};

// 0.8 to 1.9 degrees RMS (tests/bench/stairs); the project asks for 2. With markers placed by the standing
// trial alone, 19 mm off, it is 1.5 to 3.8.
TEST_F(Stairs, HipAndKneeFlexionMatchesTheCaptureSystem) {
  const StairsCase stairs(folder_, true);
  EXPECT_LT(stairs.marker_error, 0.004);
  for (const StairsCurve& curve : stairs.flexions()) {
    EXPECT_LT(curve.rms(), 2) << curve.name;
    // the angles that we read from the bones are those in the file; it keeps floats of up to 400 mm
    const auto stored = stairs.stored_angle(curve.name);
    for (std::size_t i = 0; i < stored.size(); ++i)
      EXPECT_NEAR(curve.theirs[i], stored[i], 0.01) << curve.name;
  }
}

// The plates stand on steps of 195, 193 and 195 mm (FORCE_PLATFORM:CORNERS). The feet's floors come from the
// markers alone: a point of a sole stands within 15 mm of its level (planted_feet.cpp), twice in a
// difference.
TEST_F(Stairs, PhantomsFeetStandOnStepsOfItsOwnSize) {
  const Phantom phantom = build_phantom({}).value();
  const Scene body = still_body(exact_parts(phantom), phantom.landmarks);
  CapturedRecording recording;
  const C3dFile file = read_c3d(folder_ + "Movement_trial.c3d").value();
  recording.motion = file.markers;
  recording.forces = file.forces;
  recording.trial = read_c3d(folder_ + "Static_trial.c3d").value().markers;
  const BodyMarkers markers =
      body_markers(recording.motion.names, phantom.landmarks, segments_of(body), PointKind::markers);
  const auto motion = captured_motion({body, standing_soles(phantom.landmarks)}, markers, recording,
                                      {.other_person = true, .calibrate = true, .recorded_mass = 85});
  ASSERT_TRUE(motion) << motion.error().message();
  EXPECT_EQ(motion->loads.size(), 4U);
  std::map<char, double> height;  // per plate: the middle height of the ground's force
  for (const ExternalLoad& load : motion->loads) {
    std::vector<double> heights;
    for (Eigen::Index i = 0; i < load.measured.force.cols(); ++i)
      if (load.measured.force.col(i).norm() > 0 && load.measured.point.col(i).allFinite())
        heights.push_back(load.measured.point(2, i));
    std::ranges::nth_element(heights, heights.begin() + std::ssize(heights) / 2);
    height[load.measured.name.back()] = heights[heights.size() / 2];
  }
  const double ratio = motion->length_ratio;
  EXPECT_NEAR(height['2'] - height['1'], ratio * 0.195, 0.03);
  EXPECT_NEAR(height['3'] - height['2'], ratio * 0.193, 0.03);
  EXPECT_NEAR(height['4'] - height['3'], ratio * 0.195, 0.03);
}

TEST(BodyMarkers, IgnoresBonesOfPlugInGait) {
  const Phantom phantom = build_phantom({}).value();
  const Scene body = still_body(exact_parts(phantom), phantom.landmarks);
  // LFEL alone would be the lateral epicondyle of the left femur
  const auto places = body_markers({"LFEO", "LFEA", "LFEL", "LFEP", "LKNE"}, phantom.landmarks,
                                   segments_of(body), PointKind::markers);
  ASSERT_EQ(places.markers.size(), 1U);
  EXPECT_EQ(places.markers[0].name, "LKNE");
  EXPECT_TRUE(places.unknown.empty());
  EXPECT_EQ(body_markers({"LFEL"}, phantom.landmarks, segments_of(body), PointKind::markers).markers.size(),
            1U);
}

}  // namespace
}  // namespace borelli::test::stairs_test
