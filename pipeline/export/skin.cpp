#include "pipeline/export/skin.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "pipeline/export/skin_contacts.hpp"
#include "pipeline/export/skin_weights.hpp"
#include "pipeline/export/skin_zones.hpp"
#include "process/memory.hpp"
#include "segmentation/labelling/segments.hpp"

namespace borelli {
namespace {

std::vector<std::string> names_present(const LabelMap& labels) {
  std::array<bool, 256> present{};
  for (const std::uint8_t label : labels.voxels) present[label] = true;
  std::vector<std::string> names;
  for (std::size_t label = 1; label < std::min<std::size_t>(256, labels.names.size()); ++label)
    if (present[label]) names.push_back(labels.names[label]);
  return names;
}

Result<std::vector<SkinPart>> skin_parts(const std::vector<SkinJoint>& joints, const ScanPoses& X_WS) {
  std::vector<SkinPart> parts;
  for (const SkinJoint& joint : joints) {
    const auto index_of = [&](const std::string& name) {
      const auto found = std::ranges::find(parts, name, &SkinPart::name);
      return found == parts.end() ? -1 : static_cast<int>(found - parts.begin());
    };
    if (index_of(joint.part) >= 0) return failure(joint.part, "two joints of the skin belong to this part");
    SkinPart part;
    part.name = joint.part;
    part.parent = joint.parent.empty() ? -1 : index_of(joint.parent);
    if (!joint.parent.empty() && part.parent < 0)
      return failure(joint.part, fmt::format("its parent '{}' must come before it", joint.parent));
    part.has_joint = part.parent >= 0 && joint.centre;
    part.centre = joint.centre.value_or(Eigen::Vector3d::Zero());
    const auto pose = X_WS.find(joint.part);
    part.X_WS = pose != X_WS.end() ? pose->second : Pose{Eigen::Matrix3d::Identity(), part.centre};
    parts.push_back(std::move(part));
  }
  return parts;
}

/// The label map with part indices + 1.
Result<LabelMap> numbered(const LabelMap& labels, const std::vector<SkinPart>& parts) {
  std::array<std::uint8_t, 256> number{};
  std::array<bool, 256> known{};
  known[0] = true;
  for (std::size_t label = 1; label < std::min<std::size_t>(256, labels.names.size()); ++label) {
    const auto found = std::ranges::find(parts, labels.names[label], &SkinPart::name);
    if (found == parts.end()) continue;
    known[label] = true;
    number[label] = static_cast<std::uint8_t>(found - parts.begin() + 1);
  }
  LabelMap out = labels;
  for (std::uint8_t& voxel : out.voxels) {
    if (!known[voxel]) {
      const std::string name = voxel < labels.names.size() ? labels.names[voxel] : "";
      return failure("skin", fmt::format("label {} '{}' has voxels but no joint", voxel, name));
    }
    voxel = number[voxel];
  }
  return out;
}

/// A bent limb is as round as its bones allow only with an edge or more between two bones: of the zone's four
/// half thicknesses (skin_weights.hpp).
double longest_edge(const std::vector<SkinPart>& parts, int helpers) {
  double thinnest = std::numeric_limits<double>::infinity();
  for (const SkinPart& part : parts)
    if (part.has_joint) thinnest = std::min(thinnest, part.half_thickness);
  return 4 * thinnest / (helpers + 2);
}

}  // namespace

std::vector<SkinJoint> skin_joints(const LabelMap& labels, const Landmarks& landmarks) {
  std::vector<Part> tree = segment_tree(names_present(labels));
  std::vector<SkinJoint> joints;
  const auto listed = [&](std::string_view name) {
    return std::ranges::find(joints, name, &SkinJoint::part) != joints.end();
  };
  // parents first: the tree is in the order of the labels
  for (std::size_t left = tree.size() + 1; joints.size() < tree.size() && left > 0; --left)
    for (const Part& part : tree) {
      if (listed(part.name) || (!part.parent.empty() && !listed(part.parent))) continue;
      SkinJoint joint{std::string(part.name), std::string(part.parent), {}, true};
      if (const auto found = landmarks.find(part.joint); found != landmarks.end())
        joint.centre = 1e-3 * found->second.point;
      joint.twists = !part.joint.starts_with("elbow") && !part.joint.starts_with("knee");
      joints.push_back(std::move(joint));
    }
  return joints;
}

Result<Skin> skin_of(const LabelMap& labels, const std::vector<SkinJoint>& joints, const ScanPoses& X_WS,
                     const SkinOptions& options) {
  auto parts = skin_parts(joints, X_WS);
  if (!parts) return tl::unexpected(parts.error());
  if (auto fits = admit_memory("skin", "its label map", static_cast<double>(labels.grid.count())); !fits)
    return tl::unexpected(fits.error());
  try {
    auto body = numbered(labels, *parts);
    if (!body) return tl::unexpected(body.error());
    const auto outside = std::ranges::count(body->voxels, std::uint8_t{0});
    const double volume =
        1e-9 * labels.grid.voxel_volume() * static_cast<double>(std::ssize(body->voxels) - outside);
    if (volume == 0) return failure("skin", "no voxel has a label, so there is no surface");

    Volume<std::uint8_t> coarse =
        isotropic_parts(*body, std::max(options.step, 1e-3 * std::cbrt(labels.grid.voxel_volume())));
    measure_joints(*parts, joints, coarse);
    open_contacts(coarse, *parts);
    open_contacts(*body, *parts);

    Skin skin;
    auto mesh = body_mesh(*body, volume, "skin", options.tolerance, longest_edge(*parts, options.helpers));
    if (!mesh) return tl::unexpected(mesh.error());
    skin.mesh = std::move(*mesh);
    skin.parts = std::move(*parts);
    skin.bones = skin_bones(skin.parts, options.helpers);
    weigh_points(skin, *body, coarse, options);
    return skin;
  } catch (const std::bad_alloc&) {
    return out_of_memory("skin", "weighing its points (a coarser grid has fewer)");
  }
}

}  // namespace borelli
