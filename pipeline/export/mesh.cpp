#include "pipeline/export/mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <mutex>
#include <new>
#include <numeric>

#include "pipeline/export/decimate.hpp"
#include "pipeline/on_demand/vtk.hpp"
#include "process/memory.hpp"
#include "process/on_demand.hpp"
#include "threads/slabs.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr double largest_loss = 0.005;  // over a part's volume

/// Smallest index box that contains one label's voxels; empty if last < first.
struct VoxelBox {
  std::array<std::int64_t, 3> first{1, 1, 1}, last{0, 0, 0};
  std::size_t voxels = 0;
  std::size_t runs = 0;  // rows of adjacent voxels along the first axis
};

std::vector<VoxelBox> boxes_of(const LabelMap& labels) {
  std::vector<VoxelBox> boxes(256);
  const auto& size = labels.grid.size;
  std::size_t n = 0;
  for (std::int64_t k = 0; k < size[2]; ++k) {
    for (std::int64_t j = 0; j < size[1]; ++j) {
      for (std::int64_t i = 0; i < size[0]; ++i, ++n) {
        const std::uint8_t label = labels.voxels[n];
        if (label == 0) continue;
        VoxelBox& box = boxes[label];
        const std::array<std::int64_t, 3> at{i, j, k};
        for (std::size_t c = 0; c < 3; ++c) {
          box.first[c] = box.voxels ? std::min(box.first[c], at[c]) : at[c];
          box.last[c] = box.voxels ? std::max(box.last[c], at[c]) : at[c];
        }
        ++box.voxels;
        if (i == 0 || labels.voxels[n - 1] != label) ++box.runs;
      }
    }
  }
  return boxes;
}

/// Voxels of one label, or of all labels (the whole body).
struct OneLabel {
  std::uint8_t label;
  bool operator()(std::uint8_t voxel) const { return voxel == label; }
};
struct AnyLabel {
  bool operator()(std::uint8_t voxel) const { return voxel != 0; }
};

/// The share of each block of voxels that is inside, in a box with an empty layer around, so that the surface
/// also closes at the grid's border.
struct Shares {
  std::vector<unsigned char> voxels;  ///< 0 to 255
  std::array<int, 3> size{};          ///< of the image, voxels
  Vector3d origin, block;             ///< grid index = image index times block plus origin
};

/// Size of blocks: one voxel, or as many as fit into twice the tolerance, since decimation would remove a
/// finer surface anyway.
Vector3i blocks_for(const Grid& grid, double tolerance_mm) {
  constexpr double most = 64;  // keeps sums of a block's voxels within 32 bits
  return (2 * tolerance_mm * grid.spacing().cwiseInverse() + Vector3d::Constant(1e-9))
      .cwiseMin(most)
      .cast<int>()
      .cwiseMax(1);
}

template <class Inside>
Shares shares_of(const LabelMap& labels, const Inside& inside, const VoxelBox& box, const Vector3i& block) {
  std::array<std::int64_t, 3> count{};
  Shares out;
  out.block = block.cast<double>();
  for (int c = 0; c < 3; ++c) {
    count[c] = (box.last[c] - box.first[c]) / block[c] + 3;
    out.origin[c] = static_cast<double>(box.first[c]) + (block[c] - 1) / 2.0 - block[c];
  }
  for (std::size_t c = 0; c < 3; ++c) out.size[c] = static_cast<int>(count[c]);
  out.voxels.assign(static_cast<std::size_t>(count[0] * count[1] * count[2]), 0);
  std::vector<std::uint32_t> sums(static_cast<std::size_t>(count[0] * count[1]));
  const std::uint32_t whole = static_cast<std::uint32_t>(block.prod());
  for (std::int64_t layer = 1; layer + 1 < count[2]; ++layer) {
    std::fill(sums.begin(), sums.end(), 0u);
    const std::int64_t k = box.first[2] + (layer - 1) * block[2];
    for (std::int64_t kk = k; kk <= std::min(k + block[2] - 1, box.last[2]); ++kk)
      for (std::int64_t j = 0; j <= box.last[1] - box.first[1]; ++j) {
        const std::uint8_t* const row =
            labels.voxels.data() + labels.grid.offset(box.first[0], box.first[1] + j, kk);
        std::uint32_t* const to = sums.data() + (1 + j / block[1]) * count[0] + 1;
        const std::int64_t n = box.last[0] - box.first[0] + 1;
        if (block[0] == 1)
          for (std::int64_t i = 0; i < n; ++i) to[i] += inside(row[i]);
        else
          for (std::int64_t i = 0; i < n; ++i) to[i / block[0]] += inside(row[i]);
      }
    unsigned char* const plane = out.voxels.data() + layer * count[0] * count[1];
    for (std::size_t n = 0; n < sums.size(); ++n)
      plane[n] = static_cast<unsigned char>(255 * sums[n] / whole);
  }
  return out;
}

// index to mm (by our own affine map, which may be sheared); triangles face outwards
TriangleSurface placed(TriangleSurface surface, const Shares& shares, const Grid& grid) {
  for (Vector3d& p : surface.points) p = grid.point(shares.origin + shares.block.cwiseProduct(p));
  if (grid.axes.determinant() < 0)
    for (auto& t : surface.triangles) std::swap(t[1], t[2]);
  return surface;
}

double volume_of(const TriangleSurface& surface) {
  if (surface.points.empty()) return 0;
  const Vector3d near = surface.points.front();
  double six = 0;
  for (const auto& t : surface.triangles) {
    const Vector3d a = surface.points[t[0]] - near, b = surface.points[t[1]] - near,
                   c = surface.points[t[2]] - near;
    six += a.dot(b.cross(c));
  }
  return six / 6;
}

// Moves the points along their normals, by at most `most`, until the surface encloses `volume`.
void restore_volume(TriangleSurface& surface, double volume, double most) {
  double moved = 0;
  for (int round = 0; round < 20 && std::abs(volume_of(surface) / volume - 1) > 1e-6; ++round) {
    std::vector<Vector3d> normals(surface.points.size(), Vector3d::Zero());
    double area = 0;
    for (const auto& t : surface.triangles) {
      const Vector3d& p = surface.points[t[0]];
      const Vector3d twice = (surface.points[t[1]] - p).cross(surface.points[t[2]] - p);
      area += twice.norm() / 2;
      for (const auto v : t) normals[v] += twice;
    }
    if (area == 0) return;
    const double step = std::clamp((volume - volume_of(surface)) / area, -most - moved, most - moved);
    moved += step;
    for (std::size_t n = 0; n < normals.size(); ++n)
      surface.points[n] += step * normals[n].stableNormalized();
  }
}

Mesh to_mesh(const TriangleSurface& surface, const std::string& name) {
  Mesh mesh{name, {}, surface.triangles};
  mesh.points.reserve(surface.points.size());
  for (const Vector3d& p : surface.points) mesh.points.push_back((1e-3 * p).cast<float>());
  return mesh;
}

// The surface encloses `volume`, mm^3.
template <class Inside>
TriangleSurface surface_within(const VtkFunctions& vtk, const LabelMap& labels, const Inside& inside,
                               const VoxelBox& box, double volume, double tolerance_mm,
                               double longest_edge_mm) {
  const Grid& grid = labels.grid;
  Shares shares = shares_of(labels, inside, box, blocks_for(grid, tolerance_mm));
  // half a voxel: the resolution of the labels
  const double most = 0.5 * grid.spacing().cwiseProduct(shares.block).minCoeff();
  TriangleSurface surface = placed(vtk.smooth_surface(shares.voxels, shares.size), shares, grid);
  restore_volume(surface, volume, most);
  if (tolerance_mm > 0) {
    surface = decimate(surface, tolerance_mm, longest_edge_mm);
    restore_volume(surface, volume, most);
  }
  return surface;
}

template <class Inside>
TriangleSurface finest_needed(const VtkFunctions& vtk, const LabelMap& labels, const Inside& inside,
                              const VoxelBox& box, double volume, double tolerance,
                              double longest_edge = std::numeric_limits<double>::infinity()) {
  const double finest = 0.05 * labels.grid.spacing().minCoeff();  // mm
  double across = 0;                                              // mm, twice the diagonal of the part's box
  for (int c = 0; c < 3; ++c)
    across += 2 * labels.grid.axes.col(c).norm() * static_cast<double>(box.last[c] - box.first[c] + 1);
  double tolerance_mm = std::min(1e3 * tolerance, across);
  TriangleSurface surface =
      surface_within(vtk, labels, inside, box, volume, tolerance_mm, 1e3 * longest_edge);
  // parts thinner than the tolerance would lose their shape
  while (tolerance_mm > 0 && std::abs(volume_of(surface) / volume - 1) > largest_loss) {
    tolerance_mm = tolerance_mm > finest ? tolerance_mm / 2 : 0;
    surface = surface_within(vtk, labels, inside, box, volume, tolerance_mm, 1e3 * longest_edge);
  }
  return surface;
}

Mesh part_mesh(const VtkFunctions& vtk, const LabelMap& labels, std::uint8_t label, const VoxelBox& box,
               double tolerance) {
  const double volume = static_cast<double>(box.voxels) * labels.grid.voxel_volume();
  return to_mesh(finest_needed(vtk, labels, OneLabel{label}, box, volume, tolerance), labels.names[label]);
}

// Smallest box of several boxes.
VoxelBox around_all(const std::vector<VoxelBox>& boxes) {
  VoxelBox all;
  for (const VoxelBox& box : boxes) {
    if (box.voxels == 0) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      all.first[c] = all.voxels ? std::min(all.first[c], box.first[c]) : box.first[c];
      all.last[c] = all.voxels ? std::max(all.last[c], box.last[c]) : box.last[c];
    }
    all.voxels += box.voxels;
    all.runs += box.runs;
  }
  return all;
}

// Bytes of all surfaces when threads make them concurrently. A run of voxels has about six faces, two for
// each axis, and each face about one point. VTK and this file hold several copies of a point.
double bytes_of_surfaces(const std::vector<VoxelBox>& boxes, const Grid& grid, const MeshOptions& options) {
  constexpr double bytes_a_point = 400;
  double points = 0;
  for (const VoxelBox& box : boxes) points += 6.0 * static_cast<double>(box.runs);
  const double voxels_a_face =
      std::pow(blocks_for(grid, 1e3 * options.tolerance).cast<double>().prod(), 2. / 3);
  return bytes_a_point * points / voxels_a_face;
}

}  // namespace

Result<std::vector<Mesh>> part_meshes(const LabelMap& labels, const MeshOptions& options) {
  const auto vtk = on_demand<VtkFunctions>();
  if (!vtk) return tl::unexpected(vtk.error());
  const auto boxes = boxes_of(labels);
  std::vector<std::uint8_t> present;
  std::size_t all = 0;
  for (std::size_t label = 1; label < boxes.size(); ++label) {
    if (boxes[label].voxels == 0) continue;
    if (label >= labels.names.size() || labels.names[label].empty())
      return failure("meshes",
                     "label " + std::to_string(label) +
                         " has voxels but no name; add it to the label map's file of names (--label-names)");
    present.push_back(static_cast<std::uint8_t>(label));
    all += boxes[label].voxels;
  }

  if (auto fits =
          admit_memory("meshes", "building the surfaces", bytes_of_surfaces(boxes, labels.grid, options));
      !fits)
    return tl::unexpected(fits.error());

  // parts are independent; threads take the largest remaining one first, so that no thread ends alone with a
  // large part
  std::vector<Mesh> meshes(present.size());
  std::vector<std::size_t> order(present.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::greater(), [&](std::size_t n) { return boxes[present[n]].voxels; });
  std::atomic<std::size_t> next = 0, done = 0;
  std::mutex telling;
  std::atomic<bool> stopped = false;
  const auto make = [&] {
    for (std::size_t m = next++; m < present.size() && !stopped; m = next++) {
      const std::size_t n = order[m];
      const VoxelBox& box = boxes[present[n]];
      meshes[n] = part_mesh(**vtk, labels, present[n], box, options.tolerance);
      meshes[n].label = present[n];
      const std::lock_guard lock(telling);
      done += box.voxels;
      if (options.progress && !options.progress(static_cast<double>(done) / static_cast<double>(all)))
        stopped = true;
    }
  };
  try {
    in_slabs(std::ssize(present), options.threads, [&](std::int64_t, std::int64_t) { make(); });
  } catch (const std::bad_alloc&) {
    return out_of_memory("meshes", "building the triangles (a coarser grid has fewer)");
  }
  if (stopped) return failure("meshes", "stopped on request");
  return meshes;
}

Result<Mesh> body_mesh(const LabelMap& labels, double volume, const std::string& name, double tolerance,
                       double longest_edge) {
  const auto vtk = on_demand<VtkFunctions>();
  if (!vtk) return tl::unexpected(vtk.error());
  const VoxelBox box = around_all(boxes_of(labels));
  if (box.voxels == 0) return failure(name, "no voxel has a label, so there is no surface");
  if (auto fits =
          admit_memory(name, "building the surface",
                       bytes_of_surfaces({box}, labels.grid, {.tolerance = tolerance, .progress = {}}));
      !fits)
    return tl::unexpected(fits.error());
  try {
    return to_mesh(finest_needed(**vtk, labels, AnyLabel{}, box, 1e9 * volume, tolerance, longest_edge),
                   name);
  } catch (const std::bad_alloc&) {
    return out_of_memory(name, "building the triangles (a coarser grid has fewer)");
  }
}

double enclosed_volume(const Mesh& mesh) {
  if (mesh.points.empty()) return 0;
  const Vector3d near = mesh.points.front().cast<double>();
  const auto p = [&](std::uint32_t n) -> Vector3d { return mesh.points[n].cast<double>() - near; };
  double six = 0;
  for (const auto& t : mesh.triangles) six += p(t[0]).dot(p(t[1]).cross(p(t[2])));
  return six / 6;
}

bool is_closed(const Mesh& mesh) { return is_closed(mesh.points.size(), mesh.triangles); }

}  // namespace borelli
