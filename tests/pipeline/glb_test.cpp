// body.glb read back byte by byte, not by the library that wrote it, and by Khronos' validator.
#include "pipeline/export/glb.hpp"
#include "tests/paths.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>

#include "pipeline/files/palette.hpp"
#include "pipeline/files/whole_file.hpp"
#include "tests/pipeline/capsule_body.hpp"

namespace borelli {
namespace {

using nlohmann::json;

// The two chunks of a GLB, after the standard's section 4.4 (glTF 2.0, binary layout).
struct Parsed {
  json document;
  std::string binary;

  template <class Number>
  std::vector<Number> numbers(std::size_t accessor) const {
    const json& a = document["accessors"][accessor];
    const json& view = document["bufferViews"][a["bufferView"].get<std::size_t>()];
    const std::map<std::string, std::size_t> components{{"SCALAR", 1}, {"VEC3", 3}, {"VEC4", 4}};
    std::vector<Number> out(a["count"].get<std::size_t>() * components.at(a["type"]));
    const std::size_t from = view.value("byteOffset", std::size_t{0}) + a.value("byteOffset", std::size_t{0});
    EXPECT_LE(from + out.size() * sizeof(Number), binary.size());
    std::memcpy(out.data(), binary.data() + from, out.size() * sizeof(Number));
    return out;
  }
  std::size_t node(const std::string& name) const {
    for (std::size_t i = 0; i < document["nodes"].size(); ++i)
      if (document["nodes"][i].value("name", "") == name) return i;
    ADD_FAILURE() << "no node " << name;
    return 0;
  }
};

std::uint32_t word(const std::string& bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, 4);
  return value;
}

Parsed parse(const std::string& bytes) {
  Parsed parsed;
  EXPECT_EQ(bytes.substr(0, 4), "glTF");
  EXPECT_EQ(word(bytes, 4), 2u);
  EXPECT_EQ(word(bytes, 8), bytes.size());
  const std::size_t document_size = word(bytes, 12);
  EXPECT_EQ(bytes.substr(16, 4), "JSON");
  parsed.document = json::parse(bytes.substr(20, document_size));
  const std::size_t binary = 20 + document_size;
  EXPECT_EQ(word(bytes, binary + 4), 0x004E4942u);
  parsed.binary = bytes.substr(binary + 8, word(bytes, binary));
  return parsed;
}

std::string capsule_glb(double samples_per_second = 60) {
  const auto bytes = glb(capsule_meshes(), capsule_scan_poses(), capsule_motion(),
                         {.title = "capsules", .samples_per_second = samples_per_second});
  EXPECT_TRUE(bytes) << bytes.error().message();
  return *bytes;
}

// glTF -> our world: the world node's quarter turn, as the standard defines a node's rotation.
Eigen::Vector3d apply(const json& node, const Eigen::Vector3d& point) {
  const auto r = node["rotation"];
  const Eigen::Quaterniond turn(r[3].get<double>(), r[0].get<double>(), r[1].get<double>(),
                                r[2].get<double>());
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();
  if (node.contains("translation"))
    for (int c = 0; c < 3; ++c) shift[c] = node["translation"][static_cast<std::size_t>(c)];
  return turn * point + shift;
}

TEST(Glb, HasOneNodePerPartUnderAnUprightWorld) {
  const Parsed file = parse(capsule_glb());
  const json& nodes = file.document["nodes"];
  ASSERT_EQ(nodes.size(), 17u);
  ASSERT_EQ(file.document["scenes"][0]["nodes"], json::array({0}));
  EXPECT_EQ(nodes[0]["children"].size(), 16u);
  // our up (z) is glTF's up (y), the patient's front (-y in LPS) is glTF's front (+z)
  EXPECT_LT((apply(nodes[0], {0, 0, 1}) - Eigen::Vector3d(0, 1, 0)).norm(), 1e-15);
  EXPECT_LT((apply(nodes[0], {0, -1, 0}) - Eigen::Vector3d(0, 0, 1)).norm(), 1e-15);
  for (std::size_t label = 1; label < parts.size(); ++label) {
    const json& node = nodes[file.node(std::string(parts[label].name))];
    const json& mesh = file.document["meshes"][node["mesh"].get<std::size_t>()];
    EXPECT_EQ(mesh["name"], parts[label].name);
  }
}

TEST(Glb, NodesPlacePointsWhereTheyWereScanned) {
  Trajectory none;
  const auto bytes = glb(capsule_meshes(), capsule_scan_poses(), none);
  ASSERT_TRUE(bytes);
  const Parsed file = parse(*bytes);
  EXPECT_FALSE(file.document.contains("animations"));
  for (const Mesh& mesh : capsule_meshes()) {
    const json& node = file.document["nodes"][file.node(mesh.name)];
    const json& primitive = file.document["meshes"][node["mesh"].get<std::size_t>()]["primitives"][0];
    const auto points = file.numbers<float>(primitive["attributes"]["POSITION"].get<std::size_t>());
    ASSERT_EQ(points.size(), 3 * mesh.points.size());
    double worst = 0;
    for (std::size_t i = 0; i < mesh.points.size(); ++i) {
      const Eigen::Vector3d p_W = apply(node, {points[3 * i], points[3 * i + 1], points[3 * i + 2]});
      for (int c = 0; c < 3; ++c)
        worst = std::max(worst, std::abs(p_W[c] - mesh.points[i][static_cast<std::size_t>(c)]));
    }
    EXPECT_LT(worst, 4e-7) << mesh.name;  // three roundings to float at up to 2 m: 1.2e-7 each
    EXPECT_EQ(file.document["accessors"][primitive["indices"].get<std::size_t>()]["count"],
              3 * mesh.triangles.size());
  }
}

// A capsule's true normal points away from its axis. The facets' mean normal differs by at most half a
// facet's angle, 7.5 degrees around (24 points) and 7.5 along the cap (6 rings).
TEST(Glb, NormalsPointOutwards) {
  const Parsed file = parse(capsule_glb());
  const auto body = capsule_body();
  for (const auto& [name, capsule] : body) {
    const json& node = file.document["nodes"][file.node(name)];
    const json& attributes =
        file.document["meshes"][node["mesh"].get<std::size_t>()]["primitives"][0]["attributes"];
    const auto points = file.numbers<float>(attributes["POSITION"].get<std::size_t>());
    const auto normals = file.numbers<float>(attributes["NORMAL"].get<std::size_t>());
    const Eigen::Vector3d end = (capsule.bottom - capsule.top) * 1e-3;  // the solid's origin is its top
    double worst = 1;
    for (std::size_t i = 0; i + 2 < points.size(); i += 3) {
      const Eigen::Vector3d p(points[i], points[i + 1], points[i + 2]);
      const Eigen::Vector3d n(normals[i], normals[i + 1], normals[i + 2]);
      EXPECT_NEAR(n.norm(), 1, 1e-6);
      const Eigen::Vector3d out = p - std::clamp(p.dot(end) / end.squaredNorm(), 0.0, 1.0) * end;
      worst = std::min(worst, n.dot(out.normalized()));
    }
    EXPECT_GT(worst, std::cos(7.5 * std::numbers::pi / 180)) << name;
  }
}

TEST(Glb, AnimationEqualsTheTrajectory) {
  const Trajectory motion = capsule_motion();
  const Parsed file = parse(capsule_glb(1000));  // denser than the trajectory: nothing is left out
  const json& animation = file.document["animations"][0];
  ASSERT_EQ(animation["channels"].size(), 32u);
  for (const json& channel : animation["channels"]) {
    const json& sampler = animation["samplers"][channel["sampler"].get<std::size_t>()];
    EXPECT_EQ(sampler["interpolation"], "LINEAR");
    const auto times = file.numbers<float>(sampler["input"].get<std::size_t>());
    const auto values = file.numbers<float>(sampler["output"].get<std::size_t>());
    ASSERT_EQ(times.size(), motion.times.size());
    const std::string name = file.document["nodes"][channel["target"]["node"].get<std::size_t>()]["name"];
    const auto solid =
        static_cast<std::size_t>(std::ranges::find(motion.solids, name) - motion.solids.begin());
    const bool turns = channel["target"]["path"] == "rotation";
    double worst = 0, least_dot = 1;
    for (std::size_t i = 0; i < times.size(); ++i) {
      EXPECT_EQ(times[i], static_cast<float>(motion.times[i]));
      const Pose& X_WS = motion.pose(i, solid);
      if (turns) {
        const float* q = &values[4 * i];
        const Eigen::Matrix3d R = Eigen::Quaterniond(q[3], q[0], q[1], q[2]).toRotationMatrix();
        worst = std::max(worst, (R - X_WS.R).cwiseAbs().maxCoeff());
        if (i > 0) {
          const float* p = &values[4 * i - 4];
          least_dot = std::min<double>(least_dot, p[0] * q[0] + p[1] * q[1] + p[2] * q[2] + p[3] * q[3]);
        }
      } else {
        for (int c = 0; c < 3; ++c)
          worst = std::max(worst, std::abs(X_WS.p[c] - values[3 * i + static_cast<std::size_t>(c)]));
      }
    }
    EXPECT_LT(worst, 4e-7) << name;      // float: 6e-8 relative, four products in an entry of R
    EXPECT_GT(least_dot, 0.99) << name;  // 0.01 s at under 6 rad/s: always the short way round
  }
}

TEST(Glb, ThinningKeepsEndsAndOrder) {
  std::vector<double> times;
  for (int i = 0; i <= 1000; ++i) times.push_back(i * 1e-3);
  const auto kept = kept_samples(times, 60);
  EXPECT_EQ(kept.front(), 0u);
  EXPECT_EQ(kept.back(), 1000u);
  for (std::size_t i = 1; i + 1 < kept.size(); ++i)
    EXPECT_GE(times[kept[i]] - times[kept[i - 1]], 1.0 / 60 - 1e-9);
  EXPECT_GE(kept.size(), 55u);
  EXPECT_LE(kept.size(), 61u);
  EXPECT_EQ(kept_samples({0, 0.5, 0.5, 1}, 60),
            (std::vector<std::size_t>{0, 1, 3}));  // an event repeats one time
  EXPECT_EQ(kept_samples({0.25}, 60), (std::vector<std::size_t>{0}));
  EXPECT_TRUE(kept_samples({}, 60).empty());
}

TEST(Glb, RefusesInvalidMeshes) {
  const auto said = [](std::vector<Mesh> meshes) {
    const auto answer = glb(meshes, {}, {});
    return answer ? std::string("accepted") : answer.error().message();
  };
  EXPECT_NE(said({}).find("nothing to draw"), std::string::npos);
  EXPECT_NE(said({Mesh{"head", {{0, 0, 0}}, {}}}).find("head: its mesh has no triangles"), std::string::npos);
  EXPECT_NE(said({Mesh{"head", {{0, 0, 0}}, {{0, 0, 3}}}}).find("refers to point 3 of a mesh with 1"),
            std::string::npos);
  EXPECT_NE(said({Mesh{"head", {{0, 0, std::nanf("")}}, {{0, 0, 0}}}}).find("not finite"), std::string::npos);
  EXPECT_NE(said({capsule_meshes()[0], capsule_meshes()[0]}).find("two meshes"), std::string::npos);
}

// Khronos' validator (npm, a development dependency of pipeline/report): no error, no warning, no hint.
TEST(Glb, PassesTheValidator) {
  const std::string modules = test::source_folder() + "/pipeline/report/node_modules/gltf-validator";
  if (!std::filesystem::exists(modules) || std::system("node --version > /dev/null 2>&1") != 0)
    GTEST_SKIP() << "needs node and gltf-validator: npm ci --prefix pipeline/report";
  const auto folder = std::filesystem::path(testing::TempDir()) / ("glb_test_" + std::to_string(::getpid()));
  const auto still = glb(capsule_meshes(), capsule_scan_poses(), {});
  ASSERT_TRUE(still);
  const auto without_solids = glb(capsule_meshes(), {}, capsule_motion());
  ASSERT_TRUE(without_solids);
  for (const auto& [name, bytes] : std::map<std::string, std::string>{
           {"moving", capsule_glb()}, {"still", *still}, {"without_solids", *without_solids}}) {
    const auto path = folder / (name + ".glb");
    ASSERT_TRUE(write_whole(path, bytes));
    EXPECT_EQ(
        std::system(
            ("node " + test::source_folder() + "/pipeline/report/validate_glb.mjs " + path.string()).c_str()),
        0)
        << name;
  }
  std::string broken = capsule_glb();
  broken.replace(broken.find("\"LINEAR\""), 8, "\"LINEAL\"");
  ASSERT_TRUE(write_whole(folder / "broken.glb", broken));
  EXPECT_NE(std::system(("node " + test::source_folder() + "/pipeline/report/validate_glb.mjs " +
                         (folder / "broken.glb").string() + " > /dev/null 2>&1")
                            .c_str()),
            0);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace borelli
