// Markers at wrong positions are corrected by a known motion of the phantom.
#include "pipeline/motion/marker_calibration.hpp"

#include <gtest/gtest.h>

#include "pipeline/motion/marker_placement.hpp"
#include "tests/pipeline/motion/phantom_recording.hpp"

namespace borelli::test::marker_calibration_test {
namespace {

using Eigen::Vector3d;

const std::map<std::string, double> squat{{"hip_left", 60},   {"hip_right", 60},  {"knee_left", 80},
                                          {"knee_right", 80}, {"ankle_left", 15}, {"ankle_right", 15}};

template <class T>
T need(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message());
  return std::move(*result);
}

/// Range of a hinge's motion, deg.
double span_of(const System& system, const Rows& q, const std::string& hinge) {
  for (const CoordinateInfo& c : system.coordinates)
    if (c.name == hinge)
      return (q.col(c.q_index).maxCoeff() - q.col(c.q_index).minCoeff()) * 180 / std::numbers::pi;
  return 0;
}

TEST(MarkerCalibration, MotionCorrectsMisplacedMarkers) {
  const Phantom phantom = build_phantom({}).value();
  const Scene body = still_body(exact_parts(phantom), phantom.landmarks);
  const Scene marked = with_known_markers(
      body, body_markers(marker_names(), phantom.landmarks, segments_of(body), PointKind::markers));
  const System system = need(compile(marked));
  const MarkerMotion motion = recording_of(marked, bending(system, squat));
  Scene wrong = marked;
  for (Marker& marker : wrong.markers) {
    if (marker.at.solid == "lower_trunk") marker.at.point += Vector3d(0, 0.06, -0.05);
    if (marker.at.solid == "shank_left") marker.at.point += Vector3d(0, -0.05, 0);
  }
  const double before = span_of(system, need(fit_placed(wrong, motion)).q, "knee_left");
  const CalibratedMarkers found = need(calibrated_markers(wrong, motion));
  const double after = span_of(system, need(fit_placed(found.scene, motion)).q, "knee_left");
  EXPECT_GT(found.rms_before, 0.005);
  EXPECT_LT(found.rms_after, 5e-4);
  // 80 degrees: the rest weights pull by 0.2 degrees, the misplaced markers by more
  EXPECT_GT(std::abs(before - 80), 1);
  EXPECT_NEAR(after, 80, 0.3);
}

// Correct markers stay: only the pull of the rest weights (1e-3 rad on segments of 0.4 m) moves them.
TEST(MarkerCalibration, PlacedMarkersStay) {
  const Phantom phantom = build_phantom({}).value();
  const Scene body = still_body(exact_parts(phantom), phantom.landmarks);
  const Scene marked = with_known_markers(
      body, body_markers(marker_names(), phantom.landmarks, segments_of(body), PointKind::markers));
  const System system = need(compile(marked));
  const CalibratedMarkers found =
      need(calibrated_markers(marked, recording_of(marked, bending(system, squat))));
  EXPECT_LE(found.rms_after, found.rms_before);
  for (std::size_t m = 0; m < marked.markers.size(); ++m)
    EXPECT_LT((found.scene.markers[m].at.point - marked.markers[m].at.point).norm(), 0.005)
        << marked.markers[m].name;
}

}  // namespace
}  // namespace borelli::test::marker_calibration_test
