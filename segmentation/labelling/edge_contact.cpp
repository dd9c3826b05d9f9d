#include "segmentation/labelling/edge_contact.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <mutex>

#include "segmentation/body/body_mask.hpp"
#include "segmentation/files/class_labels.hpp"
#include "segmentation/grid/work_grid.hpp"
#include "threads/slabs.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

constexpr float least_depth = 10;  // mm

std::array<float, 256> deepest_of(const Distances& depth, const Volume<std::uint8_t>& owner) {
  std::array<float, 256> deepest{};
  std::mutex mutex;
  in_slabs(std::ssize(depth.squares), 0, [&](std::int64_t first, std::int64_t last) {
    std::array<float, 256> own{};
    for (auto o = static_cast<std::size_t>(first); o < static_cast<std::size_t>(last); ++o)
      if (const auto label = owner.voxels[o]) own[label] = std::max(own[label], depth[o]);
    const std::lock_guard lock(mutex);
    for (std::size_t n = 0; n < own.size(); ++n) deepest[n] = std::max(deepest[n], own[n]);
  });
  return deepest;
}

bool is_tissue(const GreyVolume& scan, std::size_t offset) {
  return hu_of(scan.voxels[offset], scan.quantity) > skin_edge_hu;
}

// For each label: its area on the outer faces of the scan or of the labelled box, divided by its volume to
// the power 2/3. A face of the box counts where tissue goes on behind it.
std::array<double, 256> face_share(const LabelMap& labels, const GreyVolume& scan) {
  const Grid& grid = labels.grid;
  std::array<double, 256> area{}, share{};
  std::array<std::int64_t, 256> count{};
  for (const auto label : labels.voxels) ++count[label];
  const IndexBox box =
      labels.labelled.value_or(IndexBox{{}, {grid.size[0] - 1, grid.size[1] - 1, grid.size[2] - 1}});
  for (std::size_t c = 0; c < 3; ++c) {
    const std::size_t a = (c + 1) % 3, b = (c + 2) % 3;
    const double face = grid.axes.col(static_cast<int>(a)).cross(grid.axes.col(static_cast<int>(b))).norm();
    for (const std::int64_t outwards : {-1, 1}) {
      std::array<std::int64_t, 3> at{}, next{};
      at[c] = outwards < 0 ? box.first[c] : box.last[c];
      for (at[a] = box.first[a]; at[a] <= box.last[a]; ++at[a])
        for (at[b] = box.first[b]; at[b] <= box.last[b]; ++at[b]) {
          next = at;
          next[c] += outwards;
          if (!grid.holds(next[0], next[1], next[2]) ||
              is_tissue(scan, grid.offset(next[0], next[1], next[2])))
            area[labels.at(at[0], at[1], at[2])] += face;
        }
    }
  }
  for (std::size_t label = 1; label < 256; ++label)
    if (count[label] > 0)
      share[label] = area[label] / std::pow(static_cast<double>(count[label]) * grid.voxel_volume(), 2. / 3);
  return share;
}

}  // namespace

std::array<double, 256> edge_contact(const Mask& body, const Mask& seen, const Distances& depth,
                                     const Volume<std::uint8_t>& owner,
                                     const std::function<int(std::uint8_t, const Vector3d&)>& part) {
  std::array<double, 256> contact{};
  const auto deepest = deepest_of(depth, owner);
  const Grid& g = body.grid;
  const double face = g.axes(0, 0) * g.axes(0, 0);
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        const std::uint8_t own = owner.at(i, j, k);
        if (!body.at(i, j, k) || !own) continue;
        if (depth.at(i, j, k) < std::max(least_depth, deepest[own] / 4)) continue;
        const std::array<std::array<std::int64_t, 3>, 6> around{
            {{i - 1, j, k}, {i + 1, j, k}, {i, j - 1, k}, {i, j + 1, k}, {i, j, k - 1}, {i, j, k + 1}}};
        for (const auto& n : around)
          if (!g.holds(n[0], n[1], n[2]) || !seen.at(n[0], n[1], n[2]))
            contact[static_cast<std::size_t>(part(own, g.point(i, j, k)))] += face;
      }
  return contact;
}

bool runs_out(const std::vector<std::array<std::int64_t, 3>>& places, const Mask& seen,
              const Vector3d& outwards) {
  constexpr double towards = 0.5, inwards = 10, alike = 0.5;  // cosine; mm; ratio of sections
  const double step = seen.grid.axes(0, 0);
  const auto layers = std::lround(inwards / step);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double along = outwards[static_cast<Eigen::Index>(axis)];
    if (std::abs(along) < towards) continue;
    // area of the part's sections, by the number of voxels between a section and the scan's end
    std::vector<double> section(static_cast<std::size_t>(layers + 1), 0);
    for (auto place : places)
      for (std::size_t n = 0; n < section.size(); ++n) {
        place[axis] += along > 0 ? 1 : -1;
        if (seen.grid.holds(place[0], place[1], place[2]) && seen.at(place[0], place[1], place[2])) continue;
        section[n] += step * step;
        break;
      }
    if (section.front() > cut_section && section.front() > alike * section.back()) return true;
  }
  return false;
}

std::array<bool, 256> cut_labels(const LabelMap& labels, const GreyVolume& scan, int threads) {
  constexpr double step = 3, much = 0.1;  // mm; fraction of a cube's face area
  const Grid g = work_grid(scan, step, threads);
  const LabelMap owner = labels_on(labels, g, threads);
  const Eigen::Matrix3d to_index = scan.grid.axes.inverse();
  Mask body{g, std::vector<std::uint8_t>(g.count(), 0)}, seen = body, skin = body;
  in_slabs(g.size[2], threads, [&](std::int64_t k0, std::int64_t k1) {
    for (std::int64_t k = k0; k < k1; ++k)
      for (std::int64_t j = 0; j < g.size[1]; ++j)
        for (std::int64_t i = 0; i < g.size[0]; ++i) {
          double value = 0;
          const Vector3d at = to_index * (g.point(i, j, k) - scan.grid.origin);
          seen.at(i, j, k) = sample(scan, at, value);
          if (labels.labelled && hu_of(value, scan.quantity) > skin_edge_hu &&
              !labels.labelled->holds(std::lround(at[0]), std::lround(at[1]), std::lround(at[2])))
            seen.at(i, j, k) = 0;
          body.at(i, j, k) = seen.at(i, j, k) && owner.at(i, j, k);
          skin.at(i, j, k) = seen.at(i, j, k) && !owner.at(i, j, k);
        }
  });
  auto depth = distance_to(skin, 200, false, threads);
  for (std::size_t o = 0; o < depth.squares.size(); ++o)
    if (!body.voxels[o]) depth.squares[o] = 0;
  const auto contact =
      edge_contact(body, seen, depth, owner, [](std::uint8_t own, const Vector3d&) { return own; });
  const auto deepest = deepest_of(depth, owner);
  const auto share = face_share(labels, scan);
  std::array<bool, 256> cut{};
  for (std::size_t label = 1; label < 256; ++label)
    cut[label] = labels.beyond.contains(static_cast<std::uint8_t>(label)) || contact[label] > cut_section ||
                 (deepest[label] < least_depth && share[label] >= much);
  return cut;
}

}  // namespace borelli
