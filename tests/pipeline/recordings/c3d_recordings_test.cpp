// Two recordings of a stair with four plates (Vicon Nexus, Plug-in Gait; public sample data of pyCGM, files
// Static_trial.c3d and Movement_trial.c3d). Expected values: points, outputs and channels from an independent
// reader of 60 lines in NumPy, and forces from ezc3d's module ForcePlatforms.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "pipeline/recordings/c3d_file.hpp"
#include "tests/paths.hpp"
#include "tests/pipeline/recordings/c3d_trial.hpp"

namespace borelli::test::c3d_recordings_test {
namespace {

using Eigen::Vector3d;

constexpr double body_mass = 85;  // kg, PROCESSING:BODYMASS of both files

class C3dRecording : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(folder_)) GTEST_SKIP() << "no " << folder_;
  }
  C3dFile read(const std::string& name) const { return read_c3d(folder_ + name).value(); }

  static Vector3d marker(const C3dFile& file, const std::string& name, std::size_t frame) {
    const auto& names = file.markers.names;
    const auto at = std::find(names.begin(), names.end(), name);
    return file.markers.frames.at(frame).col(at - names.begin());
  }
  static const ModelOutput& output(const C3dFile& file, const std::string& name) {
    return *std::find_if(file.outputs.begin(), file.outputs.end(),
                         [&](const ModelOutput& o) { return o.name == name; });
  }
  static long gaps(const C3dFile& file) {
    long out = 0;
    for (const auto& frame : file.markers.frames) out += frame.row(0).array().isNaN().count();
    return out;
  }

  const std::string folder_ = test::shared_folder() + "/motion/";
};

TEST_F(C3dRecording, StandingTrialMatchesAnotherReader) {
  const C3dFile file = read("Static_trial.c3d");
  EXPECT_EQ(file.markers.frames.size(), 498);
  EXPECT_EQ(file.markers.names.size(), 153);
  EXPECT_EQ(file.outputs.size(), 26);
  EXPECT_EQ(file.analog.size(), 69);
  EXPECT_EQ(file.analog_times.size(), 4482);
  EXPECT_EQ(gaps(file), 493);
  EXPECT_EQ(file.subjects, std::vector<std::string>{"Test"});
  EXPECT_EQ(file.markers.up, Vector3d(0, 0, 1));
  EXPECT_EQ(file.markers.times.front(), 0);
  EXPECT_DOUBLE_EQ(file.markers.times.back(), 497 / 120.0);
  EXPECT_LT((marker(file, "LASI", 0) - Vector3d(-0.588351074219, 0.427001647949, 0.767183227539)).norm(),
            1e-12);
  EXPECT_LT((Vector3d(output(file, "LKneeAngles").values.col(100)) -
             Vector3d(-4.253281116, -5.084025383, -9.960755348))
                .norm(),
            1e-8);
  EXPECT_EQ(output(file, "LKneeAngles").unit, "deg");
  EXPECT_EQ(file.analog[0].name, "Force.Fx1");
  EXPECT_NEAR(file.analog.back().values.tail(1)[0], -0.005175106227397919, 1e-12);
  ASSERT_EQ(file.forces.size(), 4);
  for (const MeasuredForce& force : file.forces)  // unloaded plates: the subject stands beside the stair
    EXPECT_LT(std::abs(force.force.row(2).mean()), 5) << force.name;
  EXPECT_TRUE(test::has_warning(file.warnings, "ORIGIN of force plate 1 has the wrong sign"));
}

TEST_F(C3dRecording, WalkDownTheStairMatchesAnotherReader) {
  const C3dFile file = read("Movement_trial.c3d");
  EXPECT_EQ(file.markers.frames.size(), 323);
  EXPECT_EQ(file.markers.names.size(), 159);
  EXPECT_EQ(file.outputs.size(), 80);
  EXPECT_EQ(gaps(file), 1055);
  EXPECT_DOUBLE_EQ(file.markers.times.front(), (695 - 1) / 120.0);
  EXPECT_DOUBLE_EQ(file.analog_times[9], file.markers.times[1]);
  EXPECT_LT((marker(file, "LASI", 0) - Vector3d(1.03680847168, 0.056717292786, 1.696679199219)).norm(),
            1e-12);
  EXPECT_LT((marker(file, "RTOE", 100) - Vector3d(0.667621276855, 0.315498962402, 0.621889709473)).norm(),
            1e-12);
  EXPECT_LT((Vector3d(output(file, "RHipMoment").values.col(80)) -
             Vector3d(513.246704102, 684.494750977, -98.39503479))
                .norm(),
            1e-6);
  EXPECT_EQ(output(file, "RHipMoment").kind, "MOMENT");
  EXPECT_EQ(output(file, "RHipMoment").unit, "Nmm");
  EXPECT_NEAR(output(file, "LKneePower").values(2, 250), -0.625809073, 1e-8);
  EXPECT_NEAR(file.analog[7].values[1000], -7.937909603, 1e-8);
}

TEST_F(C3dRecording, ForcesPointsAndFreeMomentsAreThoseOfEzc3d) {
  struct Sample {
    std::size_t plate;
    long sample;
    Vector3d force, point_mm;
    double moment_nmm;
  };
  const Sample samples[] = {
      {0, 2360, {13.140429161, 28.664290863, 879.568237305}, {52.816756111, 175.581921916, 0}, -5855.455503},
      {1,
       1900,
       {7.315286428, -40.313980588, 576.438537598},
       {284.010187253, 328.46746794, 195.496994019},
       4328.570454},
      {1,
       2160,
       {-113.631313521, -50.579719885, 512.441772461},
       {256.416919366, 361.358808513, 195.496994019},
       658.861285055},
      {2,
       1300,
       {9.820444228, 33.079370552, 505.030273438},
       {503.136235901, 158.451728975, 388.920013428},
       -390.738973112},
      {3,
       640,
       {7.973825733, -54.972450099, 818.368041992},
       {808.196193807, 324.04235289, 583.812011719},
       4023.556318324}};
  const C3dFile file = read("Movement_trial.c3d");
  ASSERT_EQ(file.forces.size(), 4);
  for (const Sample& s : samples) {
    const MeasuredForce& plate = file.forces[s.plate];
    EXPECT_LT((Vector3d(plate.force.col(s.sample)) - s.force).norm(), 1e-5);
    EXPECT_LT((1000 * Vector3d(plate.point.col(s.sample)) - s.point_mm).norm(), 1e-3);
    EXPECT_NEAR(1000 * plate.moment(2, s.sample), s.moment_nmm, 0.05);
  }
}

// Plug-in Gait stores the ground reaction of each foot in N per kg of body mass. The right foot stands alone
// on the highest plate in frames 62 to 109, the left one on the lowest in 262 to 299. Vicon filters: 10 N.
TEST_F(C3dRecording, PlatesMatchTheGroundReactionOfViconsModel) {
  const C3dFile file = read("Movement_trial.c3d");
  const auto deviation = [&](const std::string& name, std::size_t plate, long from, long to) {
    double sum = 0;
    for (long frame = from; frame < to; ++frame)
      sum +=
          (body_mass * output(file, name).values.col(frame) - file.forces[plate].force.col(9 * frame)).norm();
    return sum / static_cast<double>(to - from);
  };
  EXPECT_LT(deviation("RGroundReactionForce", 3, 62, 110), 10);
  EXPECT_LT(deviation("LGroundReactionForce", 0, 262, 300), 10);
}

// Newton: mean vertical force = m (g + change of the mass centre's velocity / time). The noise of four
// plates, 5 to 10 N each, and the typed-in mass allow for 8 %.
TEST_F(C3dRecording, PlatesCarryTheBodyOnTheStair) {
  const C3dFile file = read("Movement_trial.c3d");
  const auto velocity = [&](std::size_t frame) {
    return (marker(file, "CentreOfMass", frame + 3).z() - marker(file, "CentreOfMass", frame - 3).z()) /
           (6 / 120.0);
  };
  const long first = 70, last = 270;
  double mean = 0;
  for (const MeasuredForce& force : file.forces)
    mean += force.force.row(2).segment(9 * first, 9 * (last - first)).mean();
  const double seconds = static_cast<double>(last - first) / 120;
  const double expected =
      body_mass *
      (9.81 +
       (velocity(static_cast<std::size_t>(last)) - velocity(static_cast<std::size_t>(first))) / seconds);
  EXPECT_NEAR(mean, expected, 0.08 * expected);
}

}  // namespace
}  // namespace borelli::test::c3d_recordings_test
