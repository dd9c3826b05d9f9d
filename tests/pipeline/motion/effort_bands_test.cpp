// Bands against the truth: bodies are measured with errors of the stated deviations, and their moments must
// lie within two deviations of the true ones in about 95 % of cases.
#include "pipeline/motion/effort_bands.hpp"

#include <gtest/gtest.h>

#include <random>

#include "tests/pipeline/motion/phantom_recording.hpp"

namespace borelli::test::effort_bands_test {
namespace {

using Eigen::Vector3d;

constexpr double landmark_deviation = 6;    // mm
constexpr double mass_deviation = 0.03;     // of the mass
constexpr double centre_deviation = 0.004;  // m

template <class T>
T need(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message());
  return std::move(*result);
}

/// A table with stated deviations, half of the mass's variance by the density curve.
InertiaTable table_of(const PartInertials& parts) {
  InertiaTable table;
  table.causes = {"density_curve", "noise"};
  for (const auto& [part, inertial] : parts) {
    InertiaRow row;
    row.part = part;
    row.inertial = inertial;
    const double mass = mass_deviation * inertial.mass, half = mass / std::sqrt(2.0);
    row.deviations.push_back({"mass_kg", mass, {half, half}});
    for (const char* axis : {"x", "y", "z"})
      row.deviations.push_back(
          {std::string("centre_") + axis + "_m", centre_deviation, {0, centre_deviation}});
    table.rows.push_back(row);
  }
  return table;
}

struct Measured {
  PartInertials parts;
  Landmarks landmarks;
};

/// A body as measured with random errors of these deviations.
Measured measured(const Phantom& phantom, std::mt19937& random) {
  std::normal_distribution<double> normal;
  const auto vector = [&] {
    const double x = normal(random), y = normal(random);
    return Vector3d(x, y, normal(random));
  };
  Measured out{exact_parts(phantom), phantom.landmarks};
  const double shared = normal(random);
  for (auto& [name, inertial] : out.parts) {
    const double own = normal(random);
    inertial.mass *= 1 + mass_deviation * (shared + own) / std::sqrt(2.0);
    inertial.centre += centre_deviation * vector();
  }
  for (auto& [name, mark] : out.landmarks) {
    mark.deviation = landmark_deviation;
    mark.point += landmark_deviation * vector();
  }
  return out;
}

TEST(EffortBands, HoldTheTrueMomentsInNinetyFivePercent) {
  const Phantom phantom = build_phantom({}).value();
  const Scene scene = still_body(exact_parts(phantom), phantom.landmarks);
  const auto segments = segments_of(scene);
  const BodyMarkers exact = body_markers(marker_names(), phantom.landmarks, segments, PointKind::markers);
  const Scene marked = with_known_markers(scene, exact);
  const System system = need(compile(marked));
  RecordedPositions truth =
      bending(system, {{"hip_left", 50}, {"knee_left", 60}, {"shoulder_right", 60}, {"elbow_right", 50}});
  // every tenth frame is enough
  RecordedPositions fewer{{}, Rows(7, truth.q.cols())};
  for (int i = 0; i < 7; ++i)
    fewer.times.push_back(truth.times[std::size_t(10 * i)]), fewer.q.row(i) = truth.q.row(10 * i);
  CapturedRecording recording;
  recording.motion = recording_of(marked, fewer);
  const RecordedEfforts right = need(efforts_of(system, fewer, {}, {}));

  std::mt19937 random(7);
  long within = 0, all = 0;
  for (int body = 0; body < 8; ++body) {
    const Measured made = measured(phantom, random);
    const Scene its_scene = still_body(made.parts, made.landmarks);
    const BodyMarkers markers = body_markers(marker_names(), made.landmarks, segments, PointKind::markers);
    const auto motion = need(captured_motion({its_scene, {}}, markers, recording, {.cutoff = 0}));
    const InertiaTable table = table_of(made.parts);
    const JointMapping none;
    EffortBandRequest request;
    request.samples = 10;
    request.cutoff = 0;
    const auto bands = need(effort_bands(motion, {table, made.landmarks, PointKind::markers, none}, request));
    EXPECT_EQ(bands.failed, 0);
    for (const CoordinateInfo& c : system.coordinates) {
      // joints whose moments depend on the masses that they carry; the root's residuals are no joint's
      if (c.name != "hip_left" && c.name != "knee_left" && c.name != "shoulder_right" &&
          c.name != "elbow_right")
        continue;
      for (int u = c.v_index; u < c.v_index + c.v_size; ++u)
        for (Eigen::Index i = 0; i < right.efforts.rows(); ++i) {
          ++all;
          within += std::abs(motion.efforts.efforts(i, u) - right.efforts(i, u)) <= 2 * bands.deviation(i, u);
        }
    }
  }
  const double share = double(within) / double(all);
  RecordProperty("share_within_two_deviations", std::to_string(share));
  std::cout << "within two deviations: " << share << " of " << all << " moments\n";
  // errors of one body's moments are correlated: over 8 bodies the share has a deviation of sqrt(0.95 0.05 /
  // 8) = 0.08
  EXPECT_GT(share, 0.85);
  EXPECT_LT(share, 0.999);
}

TEST(EffortBands, AreTheSameOnAnyNumberOfThreads) {
  const Phantom phantom = build_phantom({}).value();
  const Scene scene = still_body(exact_parts(phantom), phantom.landmarks);
  const BodyMarkers markers =
      body_markers(marker_names(), phantom.landmarks, segments_of(scene), PointKind::markers);
  const Scene marked = with_known_markers(scene, markers);
  const System system = need(compile(marked));
  CapturedRecording recording;
  recording.motion = recording_of(marked, bending(system, {{"knee_left", 60}}));
  for (auto* list : {&recording.motion.frames}) list->resize(8);
  recording.motion.times.resize(8);
  const auto motion = need(captured_motion({scene, {}}, markers, recording, {.cutoff = 0}));
  const InertiaTable table = table_of(exact_parts(phantom));
  Landmarks landmarks = phantom.landmarks;
  for (auto& [name, mark] : landmarks) mark.deviation = landmark_deviation;
  const JointMapping none;
  Rows deviations[2];
  for (int threads : {1, 2}) {
    EffortBandRequest request;
    request.samples = 4;
    request.cutoff = 0;
    request.threads = threads;
    deviations[threads - 1] =
        need(effort_bands(motion, {table, landmarks, PointKind::markers, none}, request)).deviation;
  }
  EXPECT_EQ(deviations[0], deviations[1]);
  EXPECT_GT(deviations[0].maxCoeff(), 0);
}

}  // namespace
}  // namespace borelli::test::effort_bands_test
