#include "segmentation/labelling/bones.hpp"

#include <cmath>
#include <string>
#include <utility>

#include "segmentation/joints/joints_along_path.hpp"
#include "segmentation/proposal/walls.hpp"
#include "segmentation/vocabulary/parts.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

void mark_path(const Anatomy& a, const LimbPath& path, double from, double to, int label,
               Volume<std::uint8_t>& seeds) {
  const auto& g = a.grid();
  for (std::size_t n = 0; n < path.points.size(); ++n) {
    const double s = LimbPath::spacing * static_cast<double>(n);
    if (s < from || s > to) continue;
    const Vector3d index = g.index(path.points[n]);
    const auto i = std::lround(index[0]), j = std::lround(index[1]), k = std::lround(index[2]);
    if (g.holds(i, j, k) && a.bone.at(i, j, k)) seeds.at(i, j, k) = static_cast<std::uint8_t>(label);
  }
}

}  // namespace

Volume<std::uint8_t> label_bones(const Anatomy& a, const Trunk& trunk, const Limbs& limbs,
                                 const PartPlanes& planes) {
  const auto& g = a.grid();
  Places places(g, a.threads, [&](std::size_t o) {
    const float off = a.off_bone[o];
    if (!a.body.voxels[o] || off > 15) return no_path;
    return off > 0 ? 4 + off * off : 1 / (0.4F + a.within_bone[o] / 10);
  });
  Volume<std::uint8_t> seeds{g, std::vector<std::uint8_t>(g.count(), 0)};
  for (std::size_t o = 0; o < g.count(); ++o)
    if (limbs.territory.owner.voxels[o] == static_cast<std::uint8_t>(Limb::axial) &&
        limbs.territory.length(o) == 0)
      seeds.voxels[o] = static_cast<std::uint8_t>(part_label("lower_trunk"));
  // no seeds within this distance of a joint: there the bones decide, mm
  constexpr double clear = 22;
  for (const int side : {left_side, right_side}) {
    const std::string at = side_suffix(side);
    const auto n = static_cast<std::size_t>(side);
    const auto mark = [&](const LimbPath& path, const JointsAlongPath& joints, const char* first,
                          const char* second, const char* third) {
      // a shaft that widens near an elbow or knee out of view is not a joint
      const bool parted = planes.parts_off(part_label(second + at));
      const bool ends = is_absent(trunk.absent, third, at);
      const double all = path.length() + 1, m = joints.middle > 0 && parted ? joints.middle : all + clear,
                   e = joints.end > 0 && !ends ? joints.end : all + clear;
      mark_path(a, path, 0, m - clear, part_label(first + at), seeds);
      mark_path(a, path, m + clear, e - clear, part_label(second + at), seeds);
      mark_path(a, path, e + clear, all, part_label(third + at), seeds);
    };
    if ((trunk.hip[n] || trunk.femur[n]) && limbs.leg(side).present)
      mark(limbs.leg(side), leg_joints(limbs.leg(side), trunk.scale), "thigh", "shank", "foot");
    if (trunk.shoulder[n] && limbs.arm(side).present)
      mark(limbs.arm(side), arm_joints(limbs.arm(side), trunk.scale), "upper_arm", "forearm", "hand");
  }
  Volume<std::uint8_t> bones = nearest_seeds(walled(a, std::move(places), kind_of_part), seeds);
  in_turns(g.size[2], a.threads, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t k = first; k < last; ++k)
      for (std::int64_t j = 0; j < g.size[1]; ++j)
        for (std::int64_t i = 0; i < g.size[0]; ++i) {
          auto& label = bones.at(i, j, k);
          if (!a.bone.at(i, j, k)) label = 0;
          if (label == part_label("lower_trunk"))
            label = static_cast<std::uint8_t>(planes.axial_part(g.point(i, j, k)));
        }
  });
  return bones;
}

}  // namespace borelli
