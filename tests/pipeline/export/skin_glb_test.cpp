// body.glb with a skin, read back with tinygltf and posed by hand as the standard says (glTF 2.0, 3.7.3).
#include <gtest/gtest.h>
#include <tiny_gltf.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <numbers>

#include "pipeline/export/glb.hpp"
#include "pipeline/export/skin_pose.hpp"
#include "pipeline/files/whole_file.hpp"
#include "tests/paths.hpp"
#include "tests/pipeline/export/capsule_labels.hpp"

namespace borelli::test::skin_glb_test {
namespace {

using Eigen::Affine3d;
using Eigen::Vector3d;

/// Arms rise, twist and bend while the trunk floats and turns. Solids and parts have different orders.
struct Raise {
  std::vector<SkinJoint> joints = figure_joints();
  ScanPoses X_WS_scan{{"trunk", {turn_deg(25, {1, 1, 0}), {0.02, 0.03, 0.85}}},
                      {"forearm_left", {turn_deg(50, {0, 1, 2}), {0.15, 0, 0.83}}}};
  Skin skin;
  Trajectory motion;
  std::vector<ScanPoses> poses;  // at motion.times

  Raise() {
    auto made = skin_of(labels_of(figure(), 5), joints, X_WS_scan, {.tolerance = 0.002, .threads = 1});
    EXPECT_TRUE(made) << made.error().message();
    skin = *made;
    for (const SkinJoint& joint : joints) motion.solids.insert(motion.solids.begin(), joint.part);
    for (int n = 0; n <= 4; ++n) {
      const double a = 20.0 * n;
      motion.times.push_back(2 + 0.1 * n);
      const Eigen::Matrix3d shoulder = turn_deg(-a, {0, 1, 0.3}) * turn_deg(a, {0, 0, 1});
      poses.push_back(turned(joints, X_WS_scan,
                             {{"trunk", turn_deg(a / 2, {0, 0, 1})},
                              {"upper_arm_left", shoulder},
                              {"upper_arm_right", turn_deg(a, {0, 1, 0})},
                              {"forearm_right", turn_deg(-a, {1, 0, 0})},
                              {"hand_left", turn_deg(a, {0, 0, 1})}}));
      for (const std::string& solid : motion.solids) motion.poses.push_back(poses.back().at(solid));
    }
  }
};

const Raise& raise() {
  static const Raise made;
  return made;
}

tinygltf::Model parsed(const std::string& bytes) {
  tinygltf::Model model;
  tinygltf::TinyGLTF reader;
  std::string error, warning;
  EXPECT_TRUE(reader.LoadBinaryFromMemory(&model, &error, &warning,
                                          reinterpret_cast<const unsigned char*>(bytes.data()),
                                          static_cast<unsigned>(bytes.size())))
      << error;
  EXPECT_EQ(error + warning, "");
  return model;
}

template <class Number>
std::vector<Number> numbers(const tinygltf::Model& model, int accessor) {
  const auto& a = model.accessors[static_cast<std::size_t>(accessor)];
  const auto& view = model.bufferViews[static_cast<std::size_t>(a.bufferView)];
  EXPECT_EQ(tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(a.componentType)),
            int(sizeof(Number)));
  const auto components =
      static_cast<std::size_t>(tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(a.type)));
  std::vector<Number> out(a.count * components);
  const auto& bytes = model.buffers[static_cast<std::size_t>(view.buffer)].data;
  EXPECT_LE(view.byteOffset + a.byteOffset + out.size() * sizeof(Number), bytes.size());
  std::memcpy(out.data(), bytes.data() + view.byteOffset + a.byteOffset, out.size() * sizeof(Number));
  return out;
}

/// Each node's transform in the scene at the animation's sample n.
std::vector<Affine3d> global_transforms(const tinygltf::Model& model, std::size_t n) {
  std::vector<std::vector<double>> slides, turns;
  for (const auto& node : model.nodes) {
    slides.push_back(node.translation.empty() ? std::vector<double>{0, 0, 0} : node.translation);
    turns.push_back(node.rotation.empty() ? std::vector<double>{0, 0, 0, 1} : node.rotation);
  }
  for (const auto& animation : model.animations)
    for (const auto& channel : animation.channels) {
      const auto& sampler = animation.samplers[static_cast<std::size_t>(channel.sampler)];
      const auto values = numbers<float>(model, sampler.output);
      const bool is_turn = channel.target_path == "rotation";
      auto& to = (is_turn ? turns : slides)[static_cast<std::size_t>(channel.target_node)];
      const std::size_t components = is_turn ? 4 : 3;
      for (std::size_t c = 0; c < components; ++c) to[c] = values[n * components + c];
    }
  std::vector<Affine3d> global(model.nodes.size(), Affine3d::Identity());
  const auto place = [&](const auto& self, int at, const Affine3d& parent) -> void {
    const auto i = static_cast<std::size_t>(at);
    const auto &p = slides[i], &q = turns[i];
    global[i] = parent * Eigen::Translation3d(p[0], p[1], p[2]) * Eigen::Quaterniond(q[3], q[0], q[1], q[2]);
    for (const int child : model.nodes[i].children) self(self, child, global[i]);
  };
  for (const int root : model.scenes[0].nodes) place(place, root, Affine3d::Identity());
  return global;
}

/// Points of the skin in glTF's axes at sample n.
std::vector<Vector3d> evaluated(const tinygltf::Model& model, std::size_t n) {
  const auto global = global_transforms(model, n);
  const tinygltf::Skin& skin = model.skins[0];
  const auto binds = numbers<float>(model, skin.inverseBindMatrices);
  std::vector<Eigen::Matrix4d> joint;
  for (std::size_t j = 0; j < skin.joints.size(); ++j)
    joint.push_back(global[static_cast<std::size_t>(skin.joints[j])].matrix() *
                    Eigen::Map<const Eigen::Matrix4f>(&binds[16 * j]).cast<double>());
  const auto& attributes = model.meshes[0].primitives[0].attributes;
  const auto points = numbers<float>(model, attributes.at("POSITION"));
  const auto joints = numbers<std::uint16_t>(model, attributes.at("JOINTS_0"));
  const auto weights = numbers<float>(model, attributes.at("WEIGHTS_0"));
  std::vector<Vector3d> out;
  for (std::size_t i = 0; i < points.size() / 3; ++i) {
    const Eigen::Vector4d p(points[3 * i], points[3 * i + 1], points[3 * i + 2], 1);
    Eigen::Vector4d sum = Eigen::Vector4d::Zero();
    for (std::size_t c = 0; c < 4; ++c) sum += double(weights[4 * i + c]) * (joint[joints[4 * i + c]] * p);
    out.push_back(sum.head<3>());
  }
  return out;
}

TEST(SkinGlb, HasOneSkinOverTheSkeletonsNodes) {
  const Raise& r = raise();
  const auto bytes = glb(r.skin, r.motion, {.title = "figure", .samples_per_second = 1000});
  ASSERT_TRUE(bytes) << bytes.error().message();
  const tinygltf::Model model = parsed(*bytes);
  ASSERT_EQ(model.skins.size(), 1u);
  ASSERT_EQ(model.meshes.size(), 1u);
  const auto& attributes = model.meshes[0].primitives[0].attributes;
  const auto count = [&](int accessor) { return model.accessors[static_cast<std::size_t>(accessor)].count; };
  EXPECT_EQ(model.skins[0].joints.size(), r.skin.bones.size());
  // per arm: shoulder 7 helpers, elbow 3 (a hinge), wrist 7
  EXPECT_EQ(r.skin.bones.size(), 7 + 2 * (7 + 3 + 7));
  EXPECT_EQ(count(model.skins[0].inverseBindMatrices), r.skin.bones.size());
  for (const char* name : {"POSITION", "NORMAL", "JOINTS_0", "WEIGHTS_0"})
    EXPECT_EQ(count(attributes.at(name)), r.skin.mesh.points.size()) << name;
  EXPECT_EQ(count(model.meshes[0].primitives[0].indices), 3 * r.skin.mesh.triangles.size());
  // each part's node hangs below its parent's
  const auto node = [&](const std::string& name) -> const tinygltf::Node& {
    return *std::ranges::find(model.nodes, name, &tinygltf::Node::name);
  };
  for (const SkinJoint& joint : r.joints) {
    const auto& children = node(joint.parent.empty() ? "world" : joint.parent).children;
    EXPECT_TRUE(std::ranges::any_of(children, [&](int c) {
      return model.nodes[static_cast<std::size_t>(c)].name == joint.part;
    })) << joint.part;
  }
  // a joint does not slide: only the root has an animated translation
  for (const auto& channel : model.animations[0].channels)
    if (channel.target_path == "translation") {
      EXPECT_EQ(model.nodes[static_cast<std::size_t>(channel.target_node)].name, "trunk");
    }
}

TEST(SkinGlb, AViewerSeesTheDeformedSkin) {
  const Raise& r = raise();
  const auto bytes = glb(r.skin, r.motion, {.title = "figure", .samples_per_second = 1000});
  ASSERT_TRUE(bytes) << bytes.error().message();
  const tinygltf::Model model = parsed(*bytes);
  double moved = 0;
  for (std::size_t n = 0; n < r.motion.times.size(); ++n) {
    const auto seen = evaluated(model, n), ours = deformed(r.skin, r.poses[n]);
    ASSERT_EQ(seen.size(), ours.size());
    ASSERT_GT(seen.size(), 500u);
    double worst = 0;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      // our x, y, z (left, back, up) are glTF's x, -z, y
      worst = std::max(worst, (seen[i] - Vector3d(ours[i].x(), ours[i].z(), -ours[i].y())).norm());
      moved = std::max(moved, (ours[i] - r.skin.mesh.points[i].cast<double>()).norm());
    }
    EXPECT_LT(worst, 1e-5) << n;  // floats of 1 m, through a chain of four joints: about 1e-6
  }
  EXPECT_GT(moved, 0.4);
  const auto times = numbers<float>(model, model.animations[0].samplers[0].input);
  ASSERT_EQ(times.size(), r.motion.times.size());
  EXPECT_NEAR(times.back(), 0.4, 1e-6);
}

TEST(SkinGlb, WithoutAMotionShowsTheScansPose) {
  const Raise& r = raise();
  const auto bytes = glb(r.skin, Trajectory{});
  ASSERT_TRUE(bytes) << bytes.error().message();
  const tinygltf::Model model = parsed(*bytes);
  EXPECT_TRUE(model.animations.empty());
  const auto seen = evaluated(model, 0);
  double worst = 0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const auto& p = r.skin.mesh.points[i];
    worst = std::max(worst, (seen[i] - Vector3d(p.x(), p.z(), -p.y())).norm());
  }
  EXPECT_LT(worst, 2e-6);
}

TEST(SkinGlb, RefusesASkinWithoutWeights) {
  Skin skin = raise().skin;
  skin.weights.pop_back();
  const auto bytes = glb(skin, {});
  ASSERT_FALSE(bytes);
  EXPECT_NE(bytes.error().message().find("points have weights"), std::string::npos);
}

// Khronos' validator (npm, a development dependency of pipeline/report): no error, no warning, no hint.
TEST(SkinGlb, PassesTheValidator) {
  const std::string report = source_folder() + "/pipeline/report/";
  if (!std::filesystem::exists(report + "node_modules/gltf-validator") ||
      std::system("node --version > /dev/null 2>&1") != 0)
    GTEST_SKIP() << "needs node and gltf-validator: npm ci --prefix pipeline/report";
  const auto folder = std::filesystem::path(testing::TempDir()) / ("skin_glb_" + std::to_string(::getpid()));
  for (const bool moves : {true, false}) {
    const auto bytes = glb(raise().skin, moves ? raise().motion : Trajectory{});
    ASSERT_TRUE(bytes);
    const auto path = folder / (moves ? "moving.glb" : "still.glb");
    ASSERT_TRUE(write_whole(path, *bytes));
    EXPECT_EQ(std::system(("node " + report + "validate_glb.mjs " + path.string()).c_str()), 0) << path;
  }
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace borelli::test::skin_glb_test
