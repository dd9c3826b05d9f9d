#include "segmentation/labelling/axial_bones.hpp"

#include <cmath>
#include <optional>

#include "segmentation/grid/geodesic.hpp"
#include "segmentation/vocabulary/parts.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

constexpr std::uint8_t head = part_label("head"), upper = part_label("upper_trunk"),
                       middle = part_label("middle_trunk"), lower = part_label("lower_trunk");

std::optional<Vector3d> find(const Landmarks& landmarks, const char* name) {
  const auto it = landmarks.find(name);
  if (it == landmarks.end()) return std::nullopt;
  return it->second.point;
}

}  // namespace

void part_axial_bones(const Anatomy& a, const Trunk& trunk, const Landmarks& landmarks,
                      Volume<std::uint8_t>& bones) {
  const auto& g = a.grid();
  const auto neck = find(landmarks, "neck"), high = find(landmarks, "t12_l1"), low = find(landmarks, "l5_s1");
  if (!neck && !high && !low) return;
  // the sacrum's upper end plate slopes forwards by 40 degrees on average (Legaye et al (1998) Eur Spine J
  // 7:99)
  const auto of_column = [&](const Vector3d& p) {
    const double z = p[2], slope = low ? 0.84 * (p[1] - (*low)[1]) : 0;
    if (neck && z > (*neck)[2]) return head;
    if (high && z > (*high)[2]) return upper;
    if (low && z > (*low)[2] + slope) return middle;
    return !low && high ? middle : !low && !high ? upper : lower;
  };
  Volume<float> cost{g, std::vector<float>(g.count(), no_path)};
  Volume<std::uint8_t> seeds{g, std::vector<std::uint8_t>(g.count(), 0)};
  const double column = 14 * trunk.scale, hip = 55 * trunk.scale, shoulder = 45 * trunk.scale;
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        const std::size_t o = g.offset(i, j, k);
        // as in label_bones, but bones of other parts are barriers
        if (!a.body.voxels[o] || a.off_bone[o] > 15) continue;
        if (a.bone.voxels[o] && !is_axial(bones.voxels[o])) continue;
        const float off = a.off_bone[o];
        cost.voxels[o] = off > 0 ? 4 + off * off : 1 / (0.4F + a.within_bone[o] / 10);
        if (!is_axial(bones.voxels[o])) continue;
        const Vector3d p = g.point(i, j, k);
        if (neck && p[2] > (*neck)[2] + 100 * trunk.scale) seeds.voxels[o] = head;
        if (trunk.spine_holds(p[2]) && (p - trunk.spine_at(p[2])).norm() < column)
          seeds.voxels[o] = of_column(p);
        for (const auto& ball : trunk.hip)
          if (ball && (p - ball->centre).norm() < hip) seeds.voxels[o] = lower;
        for (const auto& ball : trunk.shoulder)
          if (ball && (p - ball->centre).norm() < shoulder) seeds.voxels[o] = upper;
      }
  const auto owner = nearest_seeds({cost, a.threads}, seeds);
  for (std::size_t o = 0; o < g.count(); ++o)
    if (is_axial(bones.voxels[o]) && owner.voxels[o]) bones.voxels[o] = owner.voxels[o];
}

}  // namespace borelli
