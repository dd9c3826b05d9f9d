// Scene files: reading is correct, and thousands of damaged samples do not crash the reader.
#include "dynamics/formats/scene_file.hpp"
#include "tests/paths.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <numbers>
#include <random>

#include "dynamics/system/system.hpp"
#include "sample_scenes.hpp"

namespace borelli::test::scene_file_test {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

std::string text_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

Scene parsed(const std::string& text) {
  auto scene = parse_scene(text, "scene.toml");
  EXPECT_TRUE(scene) << scene.error().message() << "\n" << text;
  return scene.value_or(Scene{});
}

TEST(SceneFile, ReadsHandwrittenScenes) {
  const Scene scene = parsed(R"(
gravity = [0, 0, -1.62]
[[solid]]
name = "door"
joint = [{fixed = [1, 2, 3], axis = "z", angle_deg = 90},
         {rotation = "-y", name = "hinge", value_deg = 30, velocity_deg = 180, range_deg = [-10, 45]}]
mass = 2
tensor = [1, 2, 2.5, 0.1, 0.2, 0.3]
[[effort]]
name = "closer"
kind = "coordinate_spring"
on = "hinge"
stiffness = 3
rest_deg = -90
[[constraint]]
name = "floor"
kind = "point_on_plane"
point = "door"
plane = {point = [0, 0, 1]}
normal = "z"
)");
  const double pi = std::numbers::pi;
  EXPECT_EQ(scene.gravity, Vector3d(0, 0, -1.62));
  ASSERT_EQ(scene.solids.size(), 1u);
  const Solid& door = scene.solids[0];
  EXPECT_EQ(door.parent, "world");
  const Pose& fixed = std::get<Fixed>(door.switches[0].kind).X_AB;
  EXPECT_EQ(fixed.p, Vector3d(1, 2, 3));
  EXPECT_LT((fixed.R * Vector3d::UnitX() - Vector3d::UnitY()).norm(), 1e-15);  // a rounding of pi / 2
  const Switch& hinge = door.switches[1];
  EXPECT_EQ(std::get<Rotation>(hinge.kind).axis, Vector3d(0, -1, 0));
  EXPECT_DOUBLE_EQ(hinge.q[0], pi / 6);
  EXPECT_DOUBLE_EQ(hinge.v[0], pi);
  EXPECT_DOUBLE_EQ(hinge.ranges.at(0).lower, -pi / 18);
  EXPECT_DOUBLE_EQ(hinge.ranges.at(0).upper, pi / 4);
  EXPECT_EQ(door.inertials[0].tensor(1, 2), 0.3);
  EXPECT_EQ(door.inertials[0].tensor(2, 0), 0.2);
  const auto& spring = std::get<CoordinateSpring>(scene.efforts[0].kind);
  EXPECT_EQ(spring.on.coordinate, "hinge");
  EXPECT_DOUBLE_EQ(spring.rest, -pi / 2);
  const auto& floor = std::get<PointOnPlane>(scene.constraints[0].kind);
  EXPECT_EQ(floor.point.solid, "door");
  EXPECT_EQ(floor.plane.on.solid, "world");
  EXPECT_EQ(floor.plane.on.point, Vector3d(0, 0, 1));
}

TEST(SceneFile, BallHasThreeRanges) {
  const Scene scene = parsed(R"(
[[solid]]
name = "arm"
joint = {ball = true, value = [0.8, 0.6, 0, 0], range_deg = [[0, 90], [-10, 0], [-180, 180]]}
)");
  const std::vector<Range>& ranges = scene.solids.at(0).switches.at(0).ranges;
  ASSERT_EQ(ranges.size(), 3u);
  const double pi = std::numbers::pi;
  EXPECT_DOUBLE_EQ(ranges[0].upper, pi / 2);
  EXPECT_DOUBLE_EQ(ranges[1].lower, -pi / 18);
  EXPECT_DOUBLE_EQ(ranges[2].upper, pi);
}

TEST(SceneFile, CompileNamesTheLineOfWhatItRefuses) {
  const Scene massless =
      parsed("[[solid]]\nname='a'\nmass=1\ntensor=[1,1,1]\n\n[[solid]]\nname='b'\njoint={rotation='x'}\n");
  EXPECT_EQ(
      compile(massless).error().message().find("scene.toml:6: solid 'b', coordinate 'b': moves no mass"), 0u)
      << compile(massless).error().message();
  const Scene spring = parsed(
      "[[solid]]\nname='a'\njoint={ball=true}\nmass=1\ntensor=[1,1,1]\n[[effort]]\nname='s'\n"
      "kind='coordinate_spring'\non='a'\n");
  EXPECT_EQ(compile(spring).error().message().find("scene.toml:6: effort 's': "), 0u)
      << compile(spring).error().message();
}

TEST(SceneFile, RefusesMissingAndOtherFiles) {
  EXPECT_EQ(read_scene("/no/such/scene.toml").error().message(), "/no/such/scene.toml: no such file");
  EXPECT_NE(read_scene(test::source_folder()).error().message().find("is a folder"), std::string::npos);
}

TEST(SceneFile, FunctionConstraintsAreNotWritten) {
  Scene scene;
  scene.constraints = {{"mine", FunctionConstraint{}}};
  const auto answer = write_scene(scene);
  ASSERT_FALSE(answer);
  EXPECT_NE(answer.error().message().find("'mine'"), std::string::npos);
}

// ---- damage ----

void expect_sane(const std::string& text) {
  const auto answer = parse_scene(text, "scene.toml");
  if (answer) return;
  EXPECT_TRUE(answer.error().where.starts_with("scene.toml")) << answer.error().message();
  EXPECT_FALSE(answer.error().what.empty());
}

TEST(SceneFile, TruncationsNeverCrash) {
  for (const fs::path& path : samples()) {
    const std::string text = text_of(path);
    for (std::size_t length = 0; length<text.size(); length += text.size()> 4000 ? 7 : 1)
      expect_sane(text.substr(0, length));
  }
}

TEST(SceneFile, RandomDamageNeverCrashes) {
  std::mt19937 random(7);
  for (const fs::path& path : samples()) {
    const std::string text = text_of(path);
    std::uniform_int_distribution<std::size_t> where(0, text.size() - 1);
    for (int i = 0; i < 1000; ++i) {
      std::string bad = text;
      const int count = 1 + i % 4;
      for (int k = 0; k < count; ++k) {
        switch (random() % 3) {
          case 0:
            bad[where(random) % bad.size()] = static_cast<char>(random());
            break;
          case 1:
            bad.erase(where(random) % bad.size(), 1 + random() % 9);
            break;
          default:  // repeats a piece of the file elsewhere: duplicate names, nested tables
            bad.insert(where(random) % bad.size(), text.substr(where(random), random() % 60));
        }
        if (bad.empty()) bad = "x";
      }
      expect_sane(bad);
    }
  }
}

TEST(SceneFile, DeepNestingIsRefused) {
  expect_sane("a = " + std::string(100000, '['));
  expect_sane("gravity = " + std::string(200, '[') + std::string(200, ']'));
  std::string dotted = "a";
  for (int i = 0; i < 20000; ++i) dotted += ".a";
  expect_sane(dotted + " = 1\n");
}

}  // namespace
}  // namespace borelli::test::scene_file_test
