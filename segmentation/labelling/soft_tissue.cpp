#include "segmentation/labelling/soft_tissue.hpp"

#include <array>

#include "segmentation/body/tissues.hpp"
#include "segmentation/grid/geodesic.hpp"
#include "segmentation/labelling/touching_flesh.hpp"
#include "segmentation/proposal/walls.hpp"
#include "segmentation/vocabulary/parts.hpp"
#include "threads/slabs.hpp"

namespace borelli {
namespace {

// cost of a step through fat, per mm: between two limbs it must exceed the cost from either limb's bones
constexpr float through_fat = 10;
// the same for a voxel with much air between limbs
constexpr float through_air = 100;

bool below_waist(std::uint8_t label) {
  return label == part_label("lower_trunk") ||
         (label >= part_label("thigh_left") && label <= part_label("foot_right"));
}

bool of_trunk(std::uint8_t label) {
  return label >= part_label("upper_trunk") && label <= part_label("lower_trunk");
}

// spreads labels to unlabelled neighbours, one voxel layer at a time
void spread(Volume<std::uint8_t>& labels, int layers, int threads) {
  const auto& g = labels.grid;
  for (int n = 0; n < layers; ++n) {
    const auto before = labels.voxels;
    in_slabs(g.size[2], threads, [&](std::int64_t first, std::int64_t last) {
      for (std::int64_t k = first; k < last; ++k)
        for (std::int64_t j = 0; j < g.size[1]; ++j)
          for (std::int64_t i = 0; i < g.size[0]; ++i) {
            auto& label = labels.at(i, j, k);
            if (label) continue;
            const std::array<std::array<std::int64_t, 3>, 6> around{
                {{i - 1, j, k}, {i + 1, j, k}, {i, j - 1, k}, {i, j + 1, k}, {i, j, k - 1}, {i, j, k + 1}}};
            for (const auto& a : around)
              if (g.holds(a[0], a[1], a[2]) && before[g.offset(a[0], a[1], a[2])]) {
                label = before[g.offset(a[0], a[1], a[2])];
                break;
              }
          }
    });
  }
}

}  // namespace

Volume<std::uint8_t> label_soft_tissue(const Anatomy& a, const LeanFlesh& lean,
                                       const Volume<std::uint8_t>& bones, double margin,
                                       Convention convention) {
  const auto& g = a.grid();
  Volume<std::uint8_t> owner =
      nearest_seeds(walled(a,
                           Places(g, a.threads,
                                  [&](std::size_t o) {
                                    return !a.body.voxels[o]                   ? no_path
                                           : lean.mask.voxels[o]               ? 1 / (1 + lean.depth[o])
                                           : a.scan.hu.voxels[o] >= lung_to_hu ? through_fat
                                                                               : through_air;
                                  }),
                           kind_of_part),
                    bones);

  // `is_one`: the parts that plain path length divides
  const auto part_by_length = [&](bool (*is_one)(std::uint8_t)) {
    Volume<std::uint8_t> own_bones = bones;
    for (auto& label : own_bones.voxels)
      if (label && !is_one(label)) label = 0;
    const auto by_length = nearest_seeds(
        walled(
            a,
            Places(g, a.threads,
                   [&](std::size_t o) { return owner.voxels[o] && is_one(owner.voxels[o]) ? 1 : no_path; }),
            kind_of_part),
        own_bones);
    for (std::size_t o = 0; o < g.count(); ++o)
      if (by_length.voxels[o]) owner.voxels[o] = by_length.voxels[o];
  };
  // if no plane divides the trunk, depth would give the abdomen to the ribs
  if (convention == Convention::bone) part_by_length(of_trunk);
  part_by_length(below_waist);
  part_touching_flesh(a, lean.mask, owner);
  spread(owner, static_cast<int>(margin / a.step() + 0.5), a.threads);
  return owner;
}

}  // namespace borelli
