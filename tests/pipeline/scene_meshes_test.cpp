// Meshes of scenes: each form encloses its volume at its place; stand-in boxes have the inertia of their
// solids.
#include "pipeline/report/scene_meshes.hpp"
#include "process/input_file.hpp"
#include "tests/paths.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "dynamics/formats/scene_file.hpp"
#include "dynamics/run/simulate.hpp"
#include "tests/pipeline/program_run.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;

Solid shaped(const std::string& name, const Form& form) {
  Solid solid;
  solid.name = name;
  Shape shape{form, {1, 2, 3}, Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized()))};
  solid.shapes = {{shape, {}, 2.}};
  return solid;
}

Vector3d centre_of(const Mesh& mesh) {
  Vector3d least = Vector3d::Constant(1e9), most = -least;
  for (const auto& p : mesh.points) {
    least = least.cwiseMin(p.cast<double>());
    most = most.cwiseMax(p.cast<double>());
  }
  return (least + most) / 2;
}

TEST(SceneMeshes, ShapesEncloseTheirVolumeAtTheirPlace) {
  // a polygon of 32 sides has sin(2 pi / 32) / (2 pi / 32) = .9936 of the circle's area; a ball of 16 such
  // rings has less volume
  const std::tuple<const char*, Form, double, double> forms[] = {
      {"box", Box{{1, 2, 3}}, 6, 1e-6},
      {"sphere", Sphere{0.5}, 4. / 3 * pi * 0.125, 0.03},
      {"ellipsoid", Ellipsoid{{0.5, 1, 2}}, 4. / 3 * pi, 0.03},
      {"cylinder", Cylinder{0.5, 2}, pi * 0.5, 0.007},
      {"capsule", Capsule{0.5, 2}, pi * 0.5 + 4. / 3 * pi * 0.125, 0.03},
      {"cone", Cone{0.5, 2}, pi / 6, 0.007},
      {"mesh",
       ClosedMesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}},
       1. / 6, 1e-6}};
  for (const auto& [name, form, volume, lost] : forms) {
    SCOPED_TRACE(name);
    Scene scene;
    scene.solids = {shaped(name, form)};
    const auto meshes = scene_meshes(scene);
    ASSERT_TRUE(meshes) << meshes.error().message();
    ASSERT_EQ(meshes->size(), 1u);
    EXPECT_EQ(meshes->front().name, name);
    const double found = enclosed_volume(meshes->front());
    EXPECT_LT(found, volume * (1 + 1e-5));
    EXPECT_GT(found, volume * (1 - lost));
    if (std::string(name) == "cone" || std::string(name) == "mesh") continue;  // not centred at the origin
    EXPECT_LT((centre_of(meshes->front()) - Vector3d(1, 2, 3)).norm(), 1e-5);
  }
}

TEST(SceneMeshes, ConeStandsOnItsBase) {
  Scene scene;
  scene.solids = {shaped("cone", Cone{0.5, 2})};
  scene.solids[0].shapes[0].shape.orientation.setIdentity();
  const auto meshes = scene_meshes(scene);
  float least = 1e9f, most = -1e9f;
  for (const auto& p : meshes.value().at(0).points)
    least = std::min(least, p.z()), most = std::max(most, p.z());
  EXPECT_NEAR(least, 3, 1e-5);
  EXPECT_NEAR(most, 5, 1e-5);
}

TEST(SceneMeshes, SolidWithoutShapeIsDrawnByItsInertia) {
  // a box of 12 kg, 1 x 2 x 3 m: moments m / 12 (b^2 + c^2)
  Solid solid;
  solid.name = "block";
  Inertial inertial;
  inertial.mass = 12;
  inertial.tensor = Vector3d(13, 10, 5).asDiagonal();
  solid.inertials = {inertial};
  Scene scene;
  scene.solids = {solid};
  const auto block = scene_meshes(scene);
  ASSERT_TRUE(block);
  EXPECT_NEAR(enclosed_volume(block->at(0)), 6, 1e-5);

  const auto linkage = read_scene(test::source_folder() + "/samples/andrews.toml");
  ASSERT_TRUE(linkage) << linkage.error().message();
  const auto meshes = scene_meshes(*linkage);
  ASSERT_TRUE(meshes);
  EXPECT_EQ(meshes->size(), 7u);
  for (const Mesh& mesh : *meshes) EXPECT_FALSE(mesh.triangles.empty()) << mesh.name;
}

TEST(SceneMeshes, GroundOfAContactIsDrawn) {
  const auto scene = read_scene(test::source_folder() + "/samples/bouncing_ball.toml");
  const auto meshes = scene_meshes(scene.value());
  ASSERT_EQ(meshes.value().size(), 2u);
  EXPECT_EQ(meshes->at(1).name, "world: ground");
  float top = -1e9f;
  for (const auto& p : meshes->at(1).points) top = std::max(top, p.z());
  EXPECT_NEAR(top, 0, 1e-6);
}

TEST(SceneMeshes, SimulateWritesMovingMeshes) {
  const TestFolder folder;
  const std::string scene = test::source_folder() + "/samples/bouncing_ball.toml";
  const std::string body = (folder / "ball.glb").string(), page = (folder / "ball.html").string();
  EXPECT_EQ(run_program("simulate " + scene + " -o " + body).code, 0);
  EXPECT_EQ(run_program("simulate " + scene + " -o " + page).code, 0);
  const std::string bytes = read_input_file(body).value(), html = read_input_file(page).value();
  EXPECT_EQ(bytes.substr(0, 4), "glTF");
  std::uint32_t size = 0;
  std::memcpy(&size, bytes.data() + 12, 4);
  const auto document = nlohmann::json::parse(bytes.substr(20, size));
  EXPECT_EQ(document["nodes"].size(), 3u);  // the world's, ball, ground
  // 5 s at 60 rows a second, because steps alone are too far apart for an animation
  const auto& times =
      document["accessors"][document["animations"][0]["samplers"][0]["input"].get<std::size_t>()];
  EXPECT_NEAR(times["count"].get<double>(), 301, 1);
  EXPECT_NE(html.find("<title>bouncing ball"), std::string::npos);
  EXPECT_NE(html.find("block-body"), std::string::npos);
}

}  // namespace
}  // namespace borelli
