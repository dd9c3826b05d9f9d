// Paths of a scene's markers against a pendulum's closed form.
#include "pipeline/motion/marker_paths.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "pipeline/motion/motion_text.hpp"
#include "pipeline/motion/recorded_trajectory.hpp"
#include "pipeline/recordings/trc_file.hpp"

namespace borelli::test::marker_paths_test {
namespace {

using Eigen::Vector3d;

Scene pendulum() {
  Scene scene;
  Solid rod;
  rod.name = "rod";
  rod.switches = {{.kind = Rotation{Vector3d::UnitY()}, .coordinate = "swing", .q = {0}}};
  rod.inertials = {{1, {0, 0, -0.5}, Eigen::Matrix3d::Identity() * 0.01}};
  scene.solids = {rod};
  scene.markers = {{"tip", {"rod", {0, 0.2, -1}}}};
  return scene;
}

Trajectory swinging(const Scene& scene) {
  RecordedPositions positions;
  positions.times = {0.5, 0.6, 0.7};
  positions.q.resize(3, 1);
  positions.q << 0, 0.4, 0.9;
  return posed_trajectory(compile(scene).value(), positions);
}

// A turn by a about y takes (0, 0.2, -1) to (-sin a, 0.2, -cos a).
TEST(MarkerPaths, TipOfAPendulumRunsOnItsCircle) {
  const Scene scene = pendulum();
  const auto text = motion_text(scene, swinging(scene), "tip.TRC");
  ASSERT_TRUE(text) << text.error().message();
  const auto read = parse_trc(*text, "tip.trc");
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->motion.names, std::vector<std::string>{"tip"});
  EXPECT_EQ(read->motion.times, (std::vector<double>{0.5, 0.6, 0.7}));
  EXPECT_NEAR(read->data_rate, 10, 1e-9);
  const double angles[] = {0, 0.4, 0.9};
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_LT(
        (read->motion.frames[i].col(0) - Vector3d(-std::sin(angles[i]), 0.2, -std::cos(angles[i]))).norm(),
        1e-14);  // 15 digits
}

TEST(MarkerPaths, RefusesASceneWithoutMarkersAndAMarkerWithoutSolid) {
  Scene scene = pendulum();
  Trajectory motion = swinging(scene);
  motion.solids[0] = "other";
  EXPECT_FALSE(marker_paths(scene, motion));
  scene.markers.clear();
  const auto none = marker_paths(scene, motion);
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message().find("their paths cannot be written"), std::string::npos);
}

}  // namespace
}  // namespace borelli::test::marker_paths_test
