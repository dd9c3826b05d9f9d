#include "segmentation/segment.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "segmentation/anatomy.hpp"
#include "segmentation/axial_bones.hpp"
#include "segmentation/body_mask.hpp"
#include "segmentation/bones.hpp"
#include "segmentation/bones_at_joints.hpp"
#include "segmentation/class_parts.hpp"
#include "segmentation/column_levels.hpp"
#include "segmentation/frame_points.hpp"
#include "segmentation/given_landmarks.hpp"
#include "segmentation/joint_centres.hpp"
#include "segmentation/landmark_seeds.hpp"
#include "segmentation/limb_tips.hpp"
#include "segmentation/missing_elbows.hpp"
#include "segmentation/part_findings.hpp"
#include "segmentation/part_planes.hpp"
#include "segmentation/slabs.hpp"
#include "segmentation/soft_tissue.hpp"
#include "segmentation/trunk_landmarks.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

// labels on the scan's own voxels: in the body by the voxel's own value at the skin, by the work grid's mask
// in hollows; the part by the flesh's owner on the work grid and the planes at the voxel's centre; where
// classes tell of a voxel, these first
LabelMap label_voxels(const GreyVolume& volume, const Anatomy& a, const Volume<std::uint8_t>& owner,
                      const PartPlanes& planes, const ClassParts* classes, int threads) {
  LabelMap map;
  map.grid = volume.grid;
  map.voxels.assign(volume.grid.count(), 0);
  for (const Part& part : parts) map.names.emplace_back(part.name);
  const auto& g = volume.grid;
  const double step = a.step();
  in_slabs(g.size[2], threads, [&](std::int64_t k0, std::int64_t k1) {
    for (std::int64_t k = k0; k < k1; ++k)
      for (std::int64_t j = 0; j < g.size[1]; ++j)
        for (std::int64_t i = 0; i < g.size[0]; ++i) {
          const Vector3d p =
              g.point(Vector3d(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)));
          const Vector3d index = (p - a.grid().origin) / step;
          const auto wi = std::lround(index[0]), wj = std::lround(index[1]), wk = std::lround(index[2]);
          const bool held = a.grid().holds(wi, wj, wk);
          const std::size_t w = held ? a.grid().offset(wi, wj, wk) : 0;
          if (const auto told = classes ? classes->place(g.offset(i, j, k)) : ClassParts::Place::open;
              told != ClassParts::Place::open) {
            if (told == ClassParts::Place::body)
              map.at(i, j, k) = static_cast<std::uint8_t>(
                  classes->part(g.offset(i, j, k), held ? owner.voxels[w] : 0, p, planes));
            continue;
          }
          if (!held) continue;
          if (!owner.voxels[w]) continue;
          const bool in_mask = a.body.voxels[w] != 0;
          const bool dense_there = a.scan.hu.voxels[w] > skin_edge_hu;
          const std::size_t o = g.offset(i, j, k);
          const bool dense = hu_of(volume.voxels[o], volume.quantity) > skin_edge_hu;
          // a dense voxel counts but where its surroundings are a thing that was taken away; air counts in
          // hollows and deep inside
          const bool inside =
              dense ? in_mask || !dense_there
                    : in_mask && (!dense_there || a.depth.voxels[w] > 2 * static_cast<float>(step));
          if (inside) map.voxels[o] = static_cast<std::uint8_t>(planes.part(owner.voxels[w], p));
        }
  });
  return map;
}

using Progress = std::function<void(double, std::string_view)>;

// Parts and landmarks of a body whose trunk is known. `options` as for this volume: where a body of unusual
// size is looked at as one of usual size, their lengths are enlarged as it is.
Segmentation parts_of(const GreyVolume& volume, const Anatomy& a, const Trunk& trunk, ClassParts* classes,
                      const SegmentOptions& options, const Progress& progress) {
  progress(0.5, "following the limbs");
  const Limbs limbs = trace_limbs(a, trunk);
  Segmentation out;
  find_limb_landmarks(a, trunk, limbs, out.landmarks);
  find_trunk_landmarks(a, trunk, limbs, out.landmarks);
  out.convention = options.convention;
  put_given(options.given, out.landmarks);
  if (options.convention != Convention::deleva1996) {
    find_column_levels(a, trunk, out.landmarks);
    seat_spine_joints(options.convention, out.landmarks);
    put_given(options.given, out.landmarks);
  }

  progress(0.6, "parting bones");
  bool by_hand = false;
  auto bones = label_bones(a, trunk, limbs, PartPlanes(out.landmarks));
  if (classes) {
    bones = classes->seeds(a, bones, PartPlanes(out.landmarks), out.landmarks);
    classes->find_joints(a, bones, out.landmarks, out.warnings);
    for (const auto& list : {options.classes->warnings, classes->warnings()})
      out.warnings.insert(out.warnings.end(), list.begin(), list.end());
    put_given(options.given, out.landmarks);
  } else if (!trunk.hip[0] && !trunk.shoulder[0] && !options.given.empty()) {
    bones = seeds_by_landmarks(a, out.landmarks);
    by_hand = std::any_of(bones.voxels.begin(), bones.voxels.end(), [](std::uint8_t v) { return v != 0; });
  } else if (options.convention == Convention::bone) {
    part_bones_at_joints(a, out.landmarks, trunk.scale, bones);
    part_axial_bones(a, trunk, out.landmarks, bones);
  }
  progress(0.7, "parting soft tissue");
  const auto owner = label_soft_tissue(a, bones, options.step);
  // by `bone` no plane parts what hangs on an elbow that is not in view
  if (options.convention != Convention::bone)
    place_missing_elbows(a, limbs, owner, trunk.scale, out.landmarks);
  find_limb_tips(a, limbs, owner, trunk.scale, out.landmarks);
  put_given(options.given, out.landmarks);
  find_frame_points(a, trunk, owner, out.landmarks);
  put_given(options.given, out.landmarks);
  const PartPlanes planes(out.landmarks, options.convention);
  progress(0.9, "cutting at the joints");
  out.labels = label_voxels(volume, a, owner, planes, classes, options.threads);
  judge_parts(a, owner, planes, out);
  if (by_hand)
    out.warnings.push_back(
        "neither both hips nor both shoulders were found: parts are by the given landmarks alone");
  else if (!trunk.hip[0] && !trunk.shoulder[0] && !classes)
    out.warnings.push_back(
        "neither both hips nor both shoulders are in view: no part could be told, and none is labelled");
  warn_of_parts(out);
  return out;
}

bool has_both(const Trunk& trunk) {
  return trunk.hip[0] && trunk.hip[1] && trunk.shoulder[0] && trunk.shoulder[1];
}

bool has_body(const Anatomy& a) {
  return std::any_of(a.body.voxels.begin(), a.body.voxels.end(), [](std::uint8_t v) { return v != 0; });
}

Grid enlarged(Grid grid, double factor) {
  grid.axes *= factor;
  grid.origin *= factor;
  return grid;
}

Landmarks enlarged(Landmarks landmarks, double factor) {
  for (auto& [name, landmark] : landmarks)
    landmark.point *= factor, landmark.deviation *= factor, landmark.radius *= factor;
  return landmarks;
}

// A body of unusual size is looked at as though it were of usual size: the lengths that bones, gaps and flesh
// are told by are an adult's. `size`: of the body, in parts of an adult's. Nothing where hips and shoulders
// of such a body are not both in the scan.
std::optional<Segmentation> parts_at_size(const GreyVolume& volume, double size,
                                          const SegmentOptions& options, const Progress& progress) {
  const GreyVolume usual{enlarged(volume.grid, 1 / size), volume.voxels, volume.quantity};
  const Anatomy a = look(usual, options.step / size, options.threads);
  if (!has_body(a)) return std::nullopt;
  const Trunk trunk = find_trunk(a);
  constexpr double least = 0.75, most = 1.25;  // no other size fits better by far
  if (!has_both(trunk) || trunk.scale < least || trunk.scale > most) return std::nullopt;
  SegmentOptions as_usual = options;
  as_usual.step /= size;
  as_usual.given = enlarged(options.given, 1 / size);
  Segmentation out = parts_of(usual, a, trunk, nullptr, as_usual, progress);
  out.labels.grid = volume.grid;
  out.landmarks = enlarged(out.landmarks, size);
  for (PartFinding& part : out.part) part.volume *= size * size * size;
  for (const auto& [name, landmark] : options.given) out.landmarks[name] = landmark;
  return out;
}

// The sizes at which to look again, given what an adult's lengths find: that which is found where it is
// unusual, or a child's and a giant's where the scan may hold a whole trunk of that size.
std::vector<double> other_sizes(const Anatomy& a, const Trunk& trunk) {
  constexpr double small = 0.82, large = 1.14;
  if (has_both(trunk)) {
    if (trunk.scale >= small && trunk.scale <= large) return {};
    return {trunk.scale};
  }
  if (trunk.shoulder[0]) return {};  // lungs bear those out: only the hips are not in view
  constexpr double child = 0.68, giant = 1.22, trunk_and_more = 800;  // mm of an adult: from knee to chin
  std::vector<double> sizes;
  const double height = a.step() * static_cast<double>(a.grid().size[2]);
  for (const double size : {child, giant})
    if (height > trunk_and_more * size) sizes.push_back(size);
  return sizes;
}

}  // namespace

Result<Segmentation> segment(const GreyVolume& volume, const SegmentOptions& options) {
  if (volume.quantity != Quantity::hu && volume.quantity != Quantity::density_kgm3)
    return failure(
        "segmentation",
        volume.quantity == Quantity::labels
            ? "this volume is a label map, and parts are found in CT numbers or densities: give the scan "
              "that "
              "it belongs to as the volume, and this file with --labels"
            : "parts are found in CT numbers or densities only; this volume holds magnetic resonance signal: "
              "give a label map of its parts with --labels, or say what it holds (--quantity hu or "
              "density_kgm3)");
  if (volume.grid.count() == 0 || volume.voxels.size() != volume.grid.count())
    return failure("segmentation", "the volume holds no voxels");
  if (!(options.step >= finest_step && options.step <= coarsest_step))
    return bad_use("segmentation", fmt::format("the work grid's step is {:.6g} mm: choose {:g} to {:g} mm",
                                               options.step, finest_step, coarsest_step));
  const auto progress = [&](double share, std::string_view what) {
    if (options.progress) options.progress(share, what);
  };

  progress(0, "finding body and bones");
  Anatomy a = look(volume, options.step, options.threads);
  std::optional<ClassParts> classes;
  if (options.classes) {
    classes.emplace(*options.classes, volume.grid, a.grid(), options.threads);
    classes->mend(a, options.threads);
  }
  if (!has_body(a))
    return failure("segmentation",
                   "no body is in the volume: nothing in it is denser than air over more than a few "
                   "centimetres (does it hold Hounsfield units?)");
  progress(0.45, "finding hips, shoulders and spine");
  const Trunk trunk = find_trunk(a);
  if (!classes)  // they know better
    for (const double size : other_sizes(a, trunk))
      if (auto found = parts_at_size(volume, size, options, progress)) {
        warn_of_joints(volume.grid, *found);
        progress(1, "");
        return *std::move(found);
      }
  Segmentation out = parts_of(volume, a, trunk, classes ? &*classes : nullptr, options, progress);
  warn_of_joints(volume.grid, out);
  progress(1, "");
  return out;
}

}  // namespace borelli
