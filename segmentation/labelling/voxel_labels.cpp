#include "segmentation/labelling/voxel_labels.hpp"

#include <array>
#include <vector>

#include "segmentation/body/body_mask.hpp"
#include "segmentation/volume/nearest_whole.hpp"
#include "threads/slabs.hpp"

namespace borelli {

LabelMap label_voxels(const GreyVolume& volume, const Anatomy& a, const Volume<std::uint8_t>& owner,
                      const PartPlanes& planes, const ClassParts* classes, const AbsentParts& absent,
                      int threads) {
  LabelMap map;
  map.grid = volume.grid;
  map.voxels.assign(volume.grid.count(), 0);
  for (const Part& part : parts) map.names.emplace_back(part.name);
  const auto& g = volume.grid;
  const double step = a.step();
  using Place = std::array<std::int64_t, 3>;
  const auto place_at_work = [&](std::int64_t i, std::int64_t j, std::int64_t k) -> Place {
    const Eigen::Vector3d index = (g.point(i, j, k) - a.grid().origin) / step;
    return {nearest_whole(index[0]), nearest_whole(index[1]), nearest_whole(index[2])};
  };
  // if the scan's axes are the patient's, each scan index maps to one work-grid index: computed once
  const bool straight = g.axes.isDiagonal(0);
  std::array<std::vector<std::int64_t>, 3> at_work;
  for (std::size_t c = 0; straight && c < 3; ++c)
    for (std::int64_t n = 0; n < g.size[c]; ++n)
      at_work[c].push_back(place_at_work(c == 0 ? n : 0, c == 1 ? n : 0, c == 2 ? n : 0)[c]);
  in_turns(g.size[2], threads, [&](std::int64_t k0, std::int64_t k1) {
    for (std::int64_t k = k0; k < k1; ++k)
      for (std::int64_t j = 0; j < g.size[1]; ++j)
        for (std::int64_t i = 0; i < g.size[0]; ++i) {
          const auto [wi, wj, wk] = straight ? Place{at_work[0][static_cast<std::size_t>(i)],
                                                     at_work[1][static_cast<std::size_t>(j)],
                                                     at_work[2][static_cast<std::size_t>(k)]}
                                             : place_at_work(i, j, k);
          const bool on_grid = a.grid().holds(wi, wj, wk);
          const std::size_t w = on_grid ? a.grid().offset(wi, wj, wk) : 0;
          if (const auto place = classes ? classes->place(g.offset(i, j, k)) : ClassParts::Place::open;
              place != ClassParts::Place::open) {
            if (place == ClassParts::Place::body)
              map.at(i, j, k) = static_cast<std::uint8_t>(
                  classes->part(g.offset(i, j, k), on_grid ? owner.voxels[w] : 0, g.point(i, j, k), planes));
            continue;
          }
          if (!on_grid) continue;
          if (!owner.voxels[w]) continue;
          const bool in_mask = a.body.voxels[w] != 0;
          const bool dense_there = a.scan.hu.voxels[w] > skin_edge_hu;
          const std::size_t o = g.offset(i, j, k);
          const bool dense = hu_of(volume.voxels[o], volume.quantity) > skin_edge_hu;
          // Count a dense voxel unless it belongs to a removed object (table, blanket). Count air in hollows
          // and deep inside. (A voxel that is body only because of a class does not make its neighbours a
          // hollow.)
          const bool hollow = !dense_there && !(classes && classes->at_work(w));
          const bool inside = dense ? in_mask || !dense_there
                                    : in_mask && (hollow || a.depth[w] > 2 * static_cast<float>(step));
          if (inside)
            map.voxels[o] = static_cast<std::uint8_t>(planes.part(owner.voxels[w], g.point(i, j, k)));
        }
  });
  leave_out(absent, map.voxels);
  return map;
}

}  // namespace borelli
