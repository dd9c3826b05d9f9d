// A synthetic walk of the phantom: ground forces balance it, its feet stand still, and it resembles published
// gait.
#include "pipeline/motion/sample_walk.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "pipeline/files/whole_file.hpp"
#include "pipeline/motion/gait_angles.hpp"
#include "pipeline/motion/walk_markers.hpp"
#include "pipeline/recordings/motion_table_file.hpp"
#include "pipeline/recordings/recording.hpp"
#include "pipeline/recordings/trc_file.hpp"
#include "samples/phantom.hpp"
#include "tests/pipeline/motion/phantom_recording.hpp"

namespace borelli::test::sample_walk_test {
namespace {

using Eigen::Vector3d;
namespace fs = std::filesystem;

template <class T>
T need(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message());
  return std::move(*result);
}

struct Sample {
  Phantom phantom = need(build_phantom({}));
  Scene scene;
  System system;
  FootSoles soles = standing_soles(phantom.landmarks);
  SampleWalk walk;

  Sample() {
    scene = still_body(exact_parts(phantom), phantom.landmarks);
    system = need(compile(scene));
    walk = need(sample_walk(scene, need(walk_markers(scene, phantom.landmarks)), soles));
  }
  double mass() const { return phantom.whole.mass; }
  Eigen::VectorXd vertical() const {
    return (walk.loads[0].measured.force.row(2) + walk.loads[1].measured.force.row(2)).transpose();
  }
};

const Sample& sample() {
  static const Sample made;
  return made;
}

// Within 1e-9 of the weight and of its moment about the farthest point of the path: rounding over 3 m.
TEST(SampleWalk, GroundForcesLeaveNothingAtTheRoot) {
  ASSERT_EQ(sample().walk.efforts.residuals.size(), 6u);
  for (const RootResidual& residual : sample().walk.efforts.residuals)
    EXPECT_LT(residual.peak, 1e-9 * sample().mass() * 9.81 * (residual.angle ? 3 : 1)) << residual.coordinate;
}

// The mean force of a periodic motion is the weight, because its momentum returns. The trapezoidal sum over a
// stretch of whole frames differs from a cycle (1.0909 s) by interpolation at one end, of order 1e-4.
TEST(SampleWalk, VerticalForceIsPositiveAndItsMeanIsTheWeight) {
  const Eigen::VectorXd force = sample().vertical();
  EXPECT_GT(force.minCoeff(), 0);
  const double weight = sample().mass() * 9.81, step = 0.01, cycle = sample().walk.timing.cycle;
  const int first = 60, whole = int(cycle / step);
  const double rest = cycle / step - whole;
  double sum = 0;
  for (int i = first; i < first + whole; ++i) sum += (force[i] + force[i + 1]) / 2;
  const double a = force[first + whole], b = force[first + whole + 1];
  sum += rest * (a + (a + rest * (b - a))) / 2;
  EXPECT_NEAR(sum * step / cycle / weight, 1, 1e-3);
}

// Heel: until 33 % of the cycle; metatarsal head I: from 12 % to toe-off.
TEST(SampleWalk, StandingFeetNeitherSlideNorSink) {
  expect_feet_stand(sample().system, sample().walk.positions, sample().walk.timing, sample().soles,
                    {{0, 0, 0.33}, {1, 0.12, stance_share}});
}

// Perry and Burnfield (2010): 62 % stance, 80 m/min (1.33 m/s), 113 steps/min. Winter (2009, chapter 5): peak
// plantarflexion moment 1.2 to 1.8 N m/kg late in stance. One walk of one body: within a quarter of these.
TEST(SampleWalk, ResemblesPublishedGait) {
  const SampleWalk& walk = sample().walk;
  const auto count = walk.positions.q.rows();
  const double distance = walk.positions.q(0, 1) - walk.positions.q(count - 1, 1);
  EXPECT_NEAR(distance / walk.positions.times.back(), 1.2, 0.05);
  const Eigen::MatrixXd& force = walk.loads[0].measured.force;
  int standing = 0;
  const int frames = int(std::lround(walk.timing.cycle * 100));
  for (int i = 0; i < frames; ++i) standing += force(2, i) > 0;
  EXPECT_NEAR(standing / double(frames), 0.62, 0.03);
  const auto names = sample().system.velocity_names();
  const auto ankle = std::ranges::find(names, "ankle_right.x") - names.begin();
  ASSERT_LT(ankle, std::ssize(names));
  Eigen::Index when = 0;
  const double peak = -walk.efforts.efforts.col(ankle).head(frames).minCoeff(&when) / sample().mass();
  RecordProperty("peak_ankle_moment_Nm_per_kg", std::to_string(peak));
  EXPECT_GT(peak, 1.2 * 0.75);
  EXPECT_LT(peak, 1.8 * 1.25);
  EXPECT_GT(double(when) / frames, 0.25);
  EXPECT_LT(double(when) / frames, stance_share);
  EXPECT_LT(sample().vertical().maxCoeff(), 1.5 * sample().mass() * 9.81);
}

TEST(SampleWalk, CentreOfPressureStaysInTheSole) { EXPECT_TRUE(sample().walk.warnings.empty()); }

// Written with 15 digits (markers, mm) and exactly (forces).
TEST(SampleWalk, FilesReadBack) {
  const fs::path folder = fs::temp_directory_path() / "borelli_sample_walk_test";
  fs::create_directories(folder);
  const SampleWalk& walk = sample().walk;
  ASSERT_GE(walk.markers.names.size(), 38u);
  TrcFile trc;
  trc.motion = in_opensim_axes(walk.markers);
  ASSERT_TRUE(write_whole(folder / "walk.trc", trc_text(trc, "walk.trc").value()));
  ASSERT_TRUE(write_motion_table(force_table_of(walk.loads), folder / "walk_grf.mot"));
  const Recording markers = need(read_recording(folder / "walk.trc"));
  ASSERT_EQ(markers.markers.names, walk.markers.names);
  for (std::size_t i = 0; i < walk.markers.frames.size(); ++i)
    for (Eigen::Index m = 0; m < walk.markers.frames[i].cols(); ++m) {
      const Vector3d p = markers.markers.frames[i].col(m);  // x forwards, y up, z to the right
      EXPECT_NEAR((Vector3d(-p.z(), -p.x(), p.y()) - walk.markers.frames[i].col(m)).norm(), 0, 1e-13);
    }
  const RecordedForces forces = need(read_forces(folder / "walk_grf.mot"));
  ASSERT_EQ(forces.forces.size(), 2u);
  for (std::size_t f = 0; f < 2; ++f)
    for (Eigen::Index i = 0; i < forces.forces[f].force.cols(); ++i) {
      const MeasuredForce& made = walk.loads[f].measured;
      EXPECT_EQ(forces.forces[f].force(1, i), made.force(2, i));
      EXPECT_EQ(forces.forces[f].force(0, i), -made.force(1, i));
      EXPECT_EQ(forces.forces[f].moment(1, i), made.moment(2, i));
      EXPECT_EQ(std::isnan(forces.forces[f].point(0, i)), std::isnan(made.point(1, i)));
      if (std::isnan(made.point(0, i))) continue;
      EXPECT_EQ(forces.forces[f].point(2, i), -made.point(0, i));
    }
  fs::remove_all(folder);
}

}  // namespace
}  // namespace borelli::test::sample_walk_test
