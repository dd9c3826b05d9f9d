#include "pipeline/export/glb.hpp"

#include <fmt/format.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>
#include <sstream>

#include "pipeline/export/skin.hpp"
#include "pipeline/export/skin_pose.hpp"

namespace borelli {

namespace {

/// A growing buffer, with a view and an accessor for each array.
class Buffer {
 public:
  explicit Buffer(tinygltf::Model& model) : model_(model) { model_.buffers.emplace_back(); }

  /// Appends `count` elements of `components` numbers each; returns the accessor's index. `target`: use of
  /// the view (vertices, indices), 0 for animation data.
  template <class Number>
  int put(const std::vector<Number>& numbers, int components, int target) {
    auto& bytes = model_.buffers.front().data;
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = bytes.size();
    view.byteLength = numbers.size() * sizeof(Number);
    view.target = target;
    const auto* first = reinterpret_cast<const unsigned char*>(numbers.data());
    bytes.insert(bytes.end(), first, first + view.byteLength);
    bytes.resize((bytes.size() + 3) / 4 * 4);  // every accessor starts at a multiple of its number's size
    model_.bufferViews.push_back(std::move(view));

    tinygltf::Accessor accessor;
    accessor.bufferView = static_cast<int>(model_.bufferViews.size()) - 1;
    accessor.count = numbers.size() / static_cast<std::size_t>(components);
    accessor.componentType = std::is_same_v<Number, float>           ? TINYGLTF_COMPONENT_TYPE_FLOAT
                             : std::is_same_v<Number, std::uint16_t> ? TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT
                                                                     : TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
    accessor.type = components == 1   ? TINYGLTF_TYPE_SCALAR
                    : components == 3 ? TINYGLTF_TYPE_VEC3
                    : components == 4 ? TINYGLTF_TYPE_VEC4
                                      : TINYGLTF_TYPE_MAT4;
    model_.accessors.push_back(std::move(accessor));
    return static_cast<int>(model_.accessors.size()) - 1;
  }

  /// Sets the minimum and maximum of each component, which glTF requires for positions and times.
  void state_range(int accessor, const std::vector<float>& numbers, int components) {
    auto& stated = model_.accessors[static_cast<std::size_t>(accessor)];
    for (int c = 0; c < components; ++c) {
      float low = numbers[static_cast<std::size_t>(c)], high = low;
      for (auto i = static_cast<std::size_t>(c); i < numbers.size();
           i += static_cast<std::size_t>(components)) {
        low = std::min(low, numbers[i]);
        high = std::max(high, numbers[i]);
      }
      stated.minValues.push_back(low);
      stated.maxValues.push_back(high);
    }
  }

 private:
  tinygltf::Model& model_;
};

Result<void> check(const Mesh& mesh) {
  if (mesh.triangles.empty()) return failure(mesh.name, "its mesh has no triangles");
  for (const auto& triangle : mesh.triangles)
    for (const auto corner : triangle)
      if (corner >= mesh.points.size())
        return failure(mesh.name, fmt::format("a triangle refers to point {} of a mesh with {} points",
                                              corner, mesh.points.size()));
  for (const auto& point : mesh.points)
    for (const float coordinate : point)
      if (!std::isfinite(coordinate)) return failure(mesh.name, "a point of its mesh is not finite");
  return {};
}

Result<void> check(const std::vector<Mesh>& meshes) {
  if (meshes.empty()) return failure("body.glb", "no part has a surface, so there is nothing to draw");
  std::set<std::string_view> names;
  for (const Mesh& mesh : meshes) {
    if (!names.insert(mesh.name).second) return failure(mesh.name, "two meshes have this name");
    if (auto checked = check(mesh); !checked) return checked;
  }
  return {};
}

/// Points in the solid's frame and unit normals: area-weighted means of the triangles' normals. Points of no
/// triangle get an arbitrary normal, since glTF requires unit normals.
struct Surface {
  std::vector<float> points, normals;
};

Surface surface_in(const Pose& X_SW, const Mesh& mesh) {
  std::vector<Eigen::Vector3d> p_S(mesh.points.size());
  std::ranges::transform(mesh.points, p_S.begin(),
                         [&](const auto& p_W) { return X_SW * Eigen::Vector3d(p_W[0], p_W[1], p_W[2]); });
  std::vector<Eigen::Vector3d> sums(p_S.size(), Eigen::Vector3d::Zero());
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d twice_area = (p_S[t[1]] - p_S[t[0]]).cross(p_S[t[2]] - p_S[t[0]]);
    for (const auto corner : t) sums[corner] += twice_area;
  }
  Surface surface;
  surface.points.reserve(3 * p_S.size());
  surface.normals.reserve(3 * p_S.size());
  for (std::size_t i = 0; i < p_S.size(); ++i) {
    const double length = sums[i].norm();
    const Eigen::Vector3d normal = length > 0 ? Eigen::Vector3d(sums[i] / length) : Eigen::Vector3d::UnitZ();
    for (int c = 0; c < 3; ++c) {
      surface.points.push_back(static_cast<float>(p_S[i][c]));
      surface.normals.push_back(static_cast<float>(normal[c]));
    }
  }
  return surface;
}

int put_triangles(Buffer& buffer, const Mesh& mesh) {
  const auto flat = [&]<class Index>(Index) {
    std::vector<Index> indices;
    indices.reserve(3 * mesh.triangles.size());
    for (const auto& triangle : mesh.triangles)
      for (const auto corner : triangle) indices.push_back(static_cast<Index>(corner));
    return buffer.put(indices, 1, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
  };
  // 65535 is glTF's "primitive restart", not an index
  return mesh.points.size() < 65535 ? flat(std::uint16_t{}) : flat(std::uint32_t{});
}

/// Adds the part's mesh and material; returns the mesh's index.
int add_mesh(tinygltf::Model& model, Buffer& buffer, const Mesh& mesh, const Pose& X_SW,
             const Colour& colour) {
  const auto linear = [](std::uint8_t srgb) {  // glTF's factors are linear; IEC 61966-2-1
    const double c = srgb / 255.0;
    return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
  };
  tinygltf::Material material;
  material.name = mesh.name;
  material.pbrMetallicRoughness.baseColorFactor = {linear(colour.red), linear(colour.green),
                                                   linear(colour.blue), 1};
  material.pbrMetallicRoughness.metallicFactor = 0;
  material.pbrMetallicRoughness.roughnessFactor = 0.7;
  model.materials.push_back(std::move(material));

  const Surface surface = surface_in(X_SW, mesh);
  tinygltf::Primitive primitive;
  primitive.mode = TINYGLTF_MODE_TRIANGLES;
  primitive.material = static_cast<int>(model.materials.size()) - 1;
  const int points = buffer.put(surface.points, 3, TINYGLTF_TARGET_ARRAY_BUFFER);
  buffer.state_range(points, surface.points, 3);
  primitive.attributes["POSITION"] = points;
  primitive.attributes["NORMAL"] = buffer.put(surface.normals, 3, TINYGLTF_TARGET_ARRAY_BUFFER);
  primitive.indices = put_triangles(buffer, mesh);

  tinygltf::Mesh drawn;
  drawn.name = mesh.name;
  drawn.primitives.push_back(std::move(primitive));
  model.meshes.push_back(std::move(drawn));
  return static_cast<int>(model.meshes.size()) - 1;
}

/// One solid's poses at the kept times, as the two arrays of its glTF channels.
struct Track {
  std::vector<float> translations, rotations;  // x y z; x y z w

  void append(const Pose& X_WS) {
    Quaternion turn = quaternion(X_WS.R);
    // q and -q are the same rotation; the nearer one avoids interpolation the long way round
    if (turn.dot(last_) < 0) turn = -turn;
    last_ = turn;
    for (int c = 0; c < 3; ++c) translations.push_back(static_cast<float>(X_WS.p[c]));
    for (const int c : {1, 2, 3, 0}) rotations.push_back(static_cast<float>(turn[c]));
  }

 private:
  Quaternion last_ = identity_quaternion();
};

void add_channel(tinygltf::Animation& animation, int node, const char* path, int times, int values) {
  tinygltf::AnimationSampler sampler;
  sampler.interpolation = "LINEAR";
  sampler.input = times;
  sampler.output = values;
  animation.samplers.push_back(std::move(sampler));
  tinygltf::AnimationChannel channel;
  channel.sampler = static_cast<int>(animation.samplers.size()) - 1;
  channel.target_node = node;
  channel.target_path = path;
  animation.channels.push_back(std::move(channel));
}

/// The pose as a matrix of 4 x 4 by columns, as glTF writes them: a viewer places with it what is known in
/// the patient's frame.
tinygltf::Value scan_pose(const Pose& X_WS) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = X_WS.R;
  matrix.topRightCorner<3, 1>() = X_WS.p;
  tinygltf::Value::Array numbers;
  for (int i = 0; i < 16; ++i) numbers.emplace_back(matrix.data()[i]);
  return tinygltf::Value(
      tinygltf::Value::Object{{"patient_from_solid", tinygltf::Value(std::move(numbers))}});
}

void place(tinygltf::Node& node, const Track& track) {
  node.translation.assign(track.translations.begin(), track.translations.begin() + 3);
  node.rotation.assign(track.rotations.begin(), track.rotations.begin() + 4);
}

/// The times of a trajectory's kept samples, and the channels over them.
class Tracks {
 public:
  Tracks(Buffer& buffer, const Trajectory& trajectory, const GlbSettings& settings)
      : buffer_(buffer),
        trajectory_(trajectory),
        kept_(kept_samples(trajectory.times, settings.samples_per_second)) {
    animation_.name = "motion";
  }

  const std::vector<std::size_t>& kept() const { return kept_; }

  /// Animates a node by `track`, one row per kept sample; with one sample there is no animation.
  void add(int node, const Track& track, bool slides = true, bool turns = true) {
    if (kept_.size() < 2) return;
    if (slides) add_channel(animation_, node, "translation", times(), buffer_.put(track.translations, 3, 0));
    if (turns) add_channel(animation_, node, "rotation", times(), buffer_.put(track.rotations, 4, 0));
  }

  void add_to(tinygltf::Model& model) {
    if (!animation_.channels.empty()) model.animations.push_back(std::move(animation_));
  }

 private:
  int times() {  // an accessor shared by all tracks
    if (times_ >= 0) return times_;
    std::vector<float> seconds;
    for (const std::size_t i : kept_)
      seconds.push_back(static_cast<float>(trajectory_.times[i] - trajectory_.times[0]));
    times_ = buffer_.put(seconds, 1, 0);
    buffer_.state_range(times_, seconds, 1);
    return times_;
  }

  Buffer& buffer_;
  const Trajectory& trajectory_;
  std::vector<std::size_t> kept_;
  tinygltf::Animation animation_;
  int times_ = -1;
};

/// A document whose first node turns our Z up into glTF's Y up.
tinygltf::Model document() {
  tinygltf::Model model;
  model.asset.version = "2.0";
  model.asset.generator = "borelli";
  tinygltf::Node world;
  world.name = "world";
  world.rotation = {-std::sqrt(0.5), 0, 0, std::sqrt(0.5)};  // a quarter turn about x
  model.nodes.push_back(std::move(world));
  return model;
}

void add_scene(tinygltf::Model& model, const std::string& title, const std::vector<int>& nodes) {
  tinygltf::Scene scene;
  scene.name = title;
  scene.nodes = nodes;
  model.scenes.push_back(std::move(scene));
  model.defaultScene = 0;
}

/// glTF's axes from ours: y up from z up.
Pose y_up() {
  Pose X_YW;
  X_YW.R << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  return X_YW;
}

/// Whether a later row of `numbers` differs from the first by more than a float's rounding.
bool varies(const std::vector<float>& numbers, std::size_t components) {
  for (std::size_t n = components; n < numbers.size(); ++n)
    if (std::abs(numbers[n] - numbers[n % components]) > 1e-7F) return true;
  return false;
}

/// The node that a bone's pose is relative to: its part's parent, a helper's too; -1: the world.
int parent_bone(const Skin& skin, std::size_t bone) { return skin.parts[skin.bones[bone].part].parent; }

/// Adds a node for each bone below the first node, node 1 + b for bone b, and their motion.
void add_bones(tinygltf::Model& model, const Skin& skin, const Trajectory& trajectory, Tracks& tracks) {
  std::vector<Track> of_bone(skin.bones.size());
  const auto append = [&](const ScanPoses& X_WS) {
    const std::vector<Pose> X_WB = bone_poses(skin, X_WS);
    for (std::size_t b = 0; b < X_WB.size(); ++b) {
      const int parent = parent_bone(skin, b);
      of_bone[b].append(parent < 0 ? X_WB[b] : X_WB[static_cast<std::size_t>(parent)].inverse() * X_WB[b]);
    }
  };
  for (const std::size_t i : tracks.kept()) {
    ScanPoses X_WS;
    for (std::size_t s = 0; s < trajectory.solids.size(); ++s)
      X_WS[trajectory.solids[s]] = trajectory.pose(i, s);
    append(X_WS);
  }
  if (tracks.kept().empty()) append({});
  for (std::size_t b = 0; b < skin.bones.size(); ++b) {
    tinygltf::Node node;
    node.name = skin.bones[b].name;
    place(node, of_bone[b]);
    const int index = static_cast<int>(model.nodes.size());
    model.nodes.push_back(std::move(node));
    model.nodes[static_cast<std::size_t>(parent_bone(skin, b) + 1)].children.push_back(index);
    tracks.add(index, of_bone[b], varies(of_bone[b].translations, 3), varies(of_bone[b].rotations, 4));
  }
}

/// Adds bones' rest poses and the points' weights.
void add_skin(tinygltf::Model& model, Buffer& buffer, const Skin& skin) {
  tinygltf::Skin bound;
  bound.name = "skin";
  bound.skeleton = 0;
  std::vector<float> inverse_binds;  // X_BY: columns first
  for (const Pose& X_WB : rest_poses(skin)) {
    const Pose X_BY = X_WB.inverse() * y_up().inverse();
    for (int column = 0; column < 4; ++column)
      for (int row = 0; row < 4; ++row)
        inverse_binds.push_back(row == 3     ? static_cast<float>(column == 3)
                                : column < 3 ? static_cast<float>(X_BY.R(row, column))
                                             : static_cast<float>(X_BY.p[row]));
    bound.joints.push_back(static_cast<int>(bound.joints.size()) + 1);
  }
  bound.inverseBindMatrices = buffer.put(inverse_binds, 16, 0);
  model.skins.push_back(std::move(bound));

  std::vector<std::uint16_t> bones;
  std::vector<float> weights;
  for (const auto& of_point : skin.bones_of) bones.insert(bones.end(), of_point.begin(), of_point.end());
  for (const auto& of_point : skin.weights) weights.insert(weights.end(), of_point.begin(), of_point.end());
  auto& attributes = model.meshes.back().primitives.front().attributes;
  attributes["JOINTS_0"] = buffer.put(bones, 4, TINYGLTF_TARGET_ARRAY_BUFFER);
  attributes["WEIGHTS_0"] = buffer.put(weights, 4, TINYGLTF_TARGET_ARRAY_BUFFER);
}

Result<std::string> written(const tinygltf::Model& model) {
  std::ostringstream stream;
  tinygltf::TinyGLTF writer;
  if (!writer.WriteGltfSceneToStream(&model, stream, false, true) || !stream)
    return failure("body.glb", "cannot be assembled");
  return stream.str();
}

}  // namespace

std::vector<std::size_t> kept_samples(const std::vector<double>& times, double samples_per_second) {
  std::vector<std::size_t> kept;
  const double gap = (1 - 1e-9) / samples_per_second;
  for (std::size_t i = 0; i < times.size(); ++i) {
    const bool first = kept.empty(), last = i + 1 == times.size();
    if (!first && times[i] - times[kept.back()] < gap) {
      if (!last ||
          static_cast<float>(times[i] - times[0]) <= static_cast<float>(times[kept.back()] - times[0]))
        continue;
      if (kept.size() > 1) kept.pop_back();  // the end of the motion replaces the sample just before it
    }
    kept.push_back(i);
  }
  return kept;
}

Result<std::string> glb(const std::vector<Mesh>& meshes, const ScanPoses& X_WS_scan,
                        const Trajectory& trajectory, const GlbSettings& settings) {
  if (const auto checked = check(meshes); !checked) return tl::unexpected(checked.error());
  tinygltf::Model model = document();
  Buffer buffer(model);
  Tracks tracks(buffer, trajectory, settings);
  for (const Mesh& mesh : meshes) {
    const auto scan = X_WS_scan.find(mesh.name);
    const auto solid = std::ranges::find(trajectory.solids, mesh.name);
    const bool has_solid =
        scan != X_WS_scan.end() && solid != trajectory.solids.end() && !tracks.kept().empty();
    const Pose X_WS = scan != X_WS_scan.end() ? scan->second : Pose{};

    Track track;
    if (!has_solid) track.append(X_WS);
    for (const std::size_t i : has_solid ? tracks.kept() : std::vector<std::size_t>{})
      track.append(trajectory.pose(i, static_cast<std::size_t>(solid - trajectory.solids.begin())));

    tinygltf::Node node;
    node.name = mesh.name;
    const auto colour = settings.colours.find(mesh.name);
    node.mesh = add_mesh(model, buffer, mesh, X_WS.inverse(),
                         colour != settings.colours.end() ? colour->second : part_colour(mesh.name));
    if (scan != X_WS_scan.end()) node.extras = scan_pose(X_WS);
    place(node, track);
    const int index = static_cast<int>(model.nodes.size());
    if (has_solid) tracks.add(index, track);
    model.nodes.front().children.push_back(index);
    model.nodes.push_back(std::move(node));
  }
  tracks.add_to(model);
  add_scene(model, settings.title, {0});
  return written(model);
}

Result<std::string> glb(const Skin& skin, const Trajectory& trajectory, const GlbSettings& settings) {
  if (const auto checked = check(skin.mesh); !checked) return tl::unexpected(checked.error());
  const std::size_t points = skin.mesh.points.size();
  if (skin.bones_of.size() != points || skin.weights.size() != points)
    return failure("skin", fmt::format("{} of its {} points have weights", skin.weights.size(), points));
  tinygltf::Model model = document();
  Buffer buffer(model);
  Tracks tracks(buffer, trajectory, settings);
  add_bones(model, skin, trajectory, tracks);

  const auto colour = settings.colours.find(skin.mesh.name);
  tinygltf::Node node;  // a viewer ignores its pose and parents; glTF asks for none
  node.name = skin.mesh.name;
  node.mesh = add_mesh(model, buffer, skin.mesh, y_up(),
                       colour != settings.colours.end() ? colour->second : Colour{0xd8, 0xa8, 0x8c});
  node.skin = 0;
  add_skin(model, buffer, skin);
  model.nodes.push_back(std::move(node));
  tracks.add_to(model);
  add_scene(model, settings.title, {0, static_cast<int>(model.nodes.size()) - 1});
  return written(model);
}

}  // namespace borelli
