#include "segmentation/proposal/limb_pieces.hpp"

#include <algorithm>
#include <cmath>

#include "segmentation/grid/geodesic.hpp"
#include "segmentation/proposal/bone_chain.hpp"
#include "segmentation/proposal/limb_sides.hpp"
#include "threads/slabs.hpp"

namespace borelli {
namespace {

constexpr float core_from = 0.8F;          // probability at which a piece starts
constexpr double least_core = 8000;        // mm^3 of such voxels
constexpr double least_chain = 100;        // mm of bone in a limb that lies wholly in the scan
constexpr double least_chain_of_cut = 40;  // mm in one that the scan cuts
constexpr double voxel_volume = labelling_step * labelling_step * labelling_step;

constexpr double least_extent = 30;  // mm: volume over the area of the border with the trunk
constexpr double least_joined = 64;  // mm^2 of border across which a piece of unknown side joins another

using RegionShares = std::array<float, 4>;

// mean over a voxel's 27 neighbours (itself included) in the body
std::vector<RegionShares> region_means(const CoarseBody& b, const ClassProbabilities& probabilities) {
  const Grid& g = b.grid();
  std::vector<RegionShares> own(b.places.size()), out(b.places.size());
  std::vector<std::int32_t> place_at(g.count(), -1);
  for (std::size_t n = 0; n < b.places.size(); ++n) {
    place_at[b.places[n]] = static_cast<std::int32_t>(n);
    for (std::size_t c = 0; c < voxel_class_count; ++c)
      own[n][static_cast<std::size_t>(region_of(c))] += static_cast<float>(probabilities.of(n)[c]) / 255;
  }
  in_slabs(std::ssize(b.places), b.threads, [&](std::int64_t first, std::int64_t last) {
    for (auto n = static_cast<std::size_t>(first); n < static_cast<std::size_t>(last); ++n) {
      const auto o = static_cast<std::int64_t>(b.places[n]);
      const std::int64_t i = o % g.size[0], j = o / g.size[0] % g.size[1], k = o / (g.size[0] * g.size[1]);
      RegionShares sum{};
      for (std::int64_t c = k - 1; c <= k + 1; ++c)
        for (std::int64_t d = j - 1; d <= j + 1; ++d)
          for (std::int64_t e = i - 1; e <= i + 1; ++e) {
            if (!g.holds(e, d, c)) continue;
            const std::int32_t place = place_at[g.offset(e, d, c)];
            if (place < 0) continue;
            for (std::size_t r = 0; r < 4; ++r) sum[r] += own[static_cast<std::size_t>(place)][r];
          }
      const float total = sum[0] + sum[1] + sum[2] + sum[3];
      for (std::size_t r = 0; r < 4; ++r) out[n][r] = sum[r] / std::max(total, 1e-6F);
    }
  });
  return out;
}

struct Candidate {
  BodyRegion region;
  LimbSide side;
  Mask mask;
};

// connected regions of a mask that contain enough sure voxels
void add_candidates(const CoarseBody& b, const Mask& mask, const std::vector<float>& probability,
                    BodyRegion region, LimbSide side, std::vector<Candidate>& out) {
  const Regions regions = connected_regions(mask, 26, b.threads);
  std::vector<double> core(regions.list.size(), 0);
  for (std::size_t n = 0; n < b.places.size(); ++n) {
    const std::uint32_t o = b.places[n];
    if (mask.voxels[o] && probability[n] > core_from)
      core[static_cast<std::size_t>(regions.number.voxels[o] - 1)] += voxel_volume;
  }
  for (std::size_t r = 0; r < regions.list.size(); ++r)
    if (core[r] >= least_core)
      out.push_back({region, side, where(b.grid(), [&](std::size_t o) {
                       return regions.number.voxels[o] == static_cast<std::int32_t>(r) + 1;
                     })});
}

std::vector<Candidate> candidates_of(const CoarseBody& b, const std::vector<RegionShares>& regions,
                                     Mask& axial) {
  std::array<Mask, 4> masks;
  for (Mask& mask : masks) mask = {b.grid(), std::vector<std::uint8_t>(b.grid().count())};
  for (std::size_t n = 0; n < b.places.size(); ++n) {
    const auto best = std::max_element(regions[n].begin(), regions[n].end()) - regions[n].begin();
    masks[static_cast<std::size_t>(best)].voxels[b.places[n]] = 1;
  }
  axial = where(b.grid(), [&](std::size_t o) { return masks[0].voxels[o] || masks[1].voxels[o]; });
  std::vector<Candidate> out;
  std::vector<float> probability(b.places.size());
  for (std::size_t r = 0; r < 4; ++r) {
    const auto region = static_cast<BodyRegion>(r);
    for (std::size_t n = 0; n < b.places.size(); ++n) probability[n] = regions[n][r];
    if (!is_limb(region)) {
      add_candidates(b, masks[r], probability, region, LimbSide::none, out);
      continue;
    }
    const auto sides = part_sides(b, masks[r], axial);
    for (const LimbSide side : {LimbSide::left, LimbSide::right, LimbSide::unknown})
      add_candidates(b, where(b.grid(), [&](std::size_t o) { return sides[o] == side; }), probability, region,
                     side, out);
  }
  return out;
}

bool is_cut(const CoarseBody& b, const Mask& mask, bool bone_alone) {
  return std::any_of(b.places.begin(), b.places.end(), [&](std::uint32_t o) {
    return mask.voxels[o] && (!bone_alone || b.bone.voxels[o]) && at_scan_end(b, o);
  });
}

// calls visit(voxel offset, neighbour offset) once for each face within the body
template <class Visit>
void for_faces_within(const CoarseBody& b, const Visit& visit) {
  const std::array<std::int64_t, 3>& size = b.grid().size;
  const std::array<std::int64_t, 3> stride{1, size[0], size[0] * size[1]};
  for (const std::uint32_t o : b.places) {
    const auto n = static_cast<std::int64_t>(o);
    const std::array<std::int64_t, 3> at{n % size[0], n / size[0] % size[1], n / (size[0] * size[1])};
    for (std::size_t c = 0; c < 3; ++c)
      if (at[c] + 1 < size[c] && b.body.voxels[static_cast<std::size_t>(n + stride[c])])
        visit(static_cast<std::size_t>(o), static_cast<std::size_t>(n + stride[c]));
  }
}

// A limb is no flat slab on the trunk and contains a chain of bone; the chain may be short if the scan cuts
// the bone.
bool is_limb_piece(const CoarseBody& b, const Candidate& candidate, const Mask& axial, double bone_chain) {
  const bool bone_cut = is_cut(b, candidate.mask, true);
  if (bone_chain < (bone_cut ? least_chain_of_cut : least_chain)) return false;
  if (bone_cut) return true;
  double faces = 0, voxels = 0;
  for_faces_within(b, [&](std::size_t one, std::size_t other) {
    faces += (candidate.mask.voxels[one] && axial.voxels[other]) ||
             (candidate.mask.voxels[other] && axial.voxels[one]);
  });
  for (const std::uint8_t voxel : candidate.mask.voxels) voxels += voxel;
  return faces == 0 || labelling_step * voxels / faces >= least_extent;
}

// Joins each limb piece of unknown side, separated from the rest by wrongly classified voxels, to the piece
// of its region with the longest common border.
void join_loose_pieces(const CoarseBody& b, std::vector<BodyPiece>& list, Volume<std::uint8_t>& owner) {
  std::vector<std::vector<double>> border(list.size(), std::vector<double>(list.size(), 0));
  for_faces_within(b, [&](std::size_t one, std::size_t other) {
    const int p = owner.voxels[one] - 1, q = owner.voxels[other] - 1;
    if (p < 0 || q < 0 || p == q) return;
    border[static_cast<std::size_t>(p)][static_cast<std::size_t>(q)] += labelling_step * labelling_step;
    border[static_cast<std::size_t>(q)][static_cast<std::size_t>(p)] += labelling_step * labelling_step;
  });
  std::vector<std::uint8_t> joins(list.size() + 1, 0);
  for (std::size_t p = 0; p <= list.size(); ++p) joins[p] = static_cast<std::uint8_t>(p);
  for (std::size_t p = 0; p < list.size(); ++p) {
    if (!is_limb(list[p].region) || list[p].side >= 0) continue;
    double most = least_joined;
    for (std::size_t q = 0; q < list.size(); ++q)
      if (list[q].region == list[p].region && list[q].side >= 0 && border[p][q] >= most)
        most = border[p][q], joins[p + 1] = static_cast<std::uint8_t>(q + 1);
    if (joins[p + 1] == p + 1) continue;
    BodyPiece& whole = list[joins[p + 1] - 1U];
    whole.bone_chain += list[p].bone_chain;
    whole.cut |= list[p].cut;
  }
  // renumbers the pieces that are left
  std::vector<BodyPiece> kept;
  std::vector<std::uint8_t> number(list.size() + 1, 0);
  for (std::size_t p = 0; p < list.size(); ++p) {
    if (joins[p + 1] != p + 1) continue;
    kept.push_back(list[p]);
    number[p + 1] = static_cast<std::uint8_t>(kept.size());
  }
  for (const std::uint32_t o : b.places) owner.voxels[o] = number[joins[owner.voxels[o]]];
  list = std::move(kept);
}

// Median along each axis: a hand that lies on the trunk shifts it less than the mean.
Eigen::Vector3d median_of(std::vector<Eigen::Vector3d> points) {
  Eigen::Vector3d out;
  for (int c = 0; c < 3; ++c) {
    const auto middle = points.begin() + static_cast<std::ptrdiff_t>(points.size() / 2);
    std::nth_element(points.begin(), middle, points.end(),
                     [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return a[c] < b[c]; });
    out[c] = (*middle)[c];
  }
  return out;
}

// the median of the faces between a limb and the trunk
void measure_root(const CoarseBody& b, const BodyPieces& pieces, std::size_t number, BodyPiece& piece) {
  const Grid& g = b.grid();
  std::vector<std::int16_t> at(g.count(), -1);
  for (std::size_t n = 0; n < b.places.size(); ++n) at[b.places[n]] = pieces.piece[n];
  std::vector<Eigen::Vector3d> faces, faces_in_bone;
  for (std::size_t n = 0; n < b.places.size(); ++n) {
    if (pieces.piece[n] != static_cast<std::int16_t>(number)) continue;
    const auto o = static_cast<std::int64_t>(b.places[n]);
    const std::array<std::int64_t, 3> here{o % g.size[0], o / g.size[0] % g.size[1],
                                           o / (g.size[0] * g.size[1])};
    for (std::size_t c = 0; c < 3; ++c)
      for (const std::int64_t step : {-1, 1}) {
        auto next = here;
        next[c] += step;
        if (!g.holds(next[0], next[1], next[2])) continue;
        const std::size_t q = g.offset(next[0], next[1], next[2]);
        if (at[q] < 0 || pieces.list[static_cast<std::size_t>(at[q])].region != BodyRegion::trunk) continue;
        const Eigen::Vector3d face =
            0.5 * (g.point(here[0], here[1], here[2]) + g.point(next[0], next[1], next[2]));
        faces.push_back(face);
        if (b.bone.voxels[static_cast<std::size_t>(o)] && b.bone.voxels[q]) faces_in_bone.push_back(face);
      }
  }
  if (faces.empty()) return;
  constexpr std::size_t few = 3;
  piece.root_area = static_cast<double>(faces.size()) * labelling_step * labelling_step;
  piece.root_in_bone = faces_in_bone.size() > few;
  piece.root = median_of(piece.root_in_bone ? std::move(faces_in_bone) : std::move(faces));
}

// Wrongly classified voxels may separate a whole limb from the trunk, so that its side stays unknown until
// the piece has grown. The place where its bone meets the trunk's then tells the side, unless that side has
// such a limb already.
void name_sides_by_roots(const Mask& axial, std::vector<BodyPiece>& list) {
  constexpr double whole = 200;  // mm of bone
  for (BodyPiece& piece : list) {
    if (!is_limb(piece.region) || piece.side >= 0 || !piece.root_in_bone || piece.bone_chain < whole)
      continue;
    const LimbSide beside = side_beside(axial, *piece.root);
    if (beside != LimbSide::left && beside != LimbSide::right) continue;
    const int side = beside == LimbSide::left ? left_side : right_side;
    if (std::none_of(list.begin(), list.end(), [&](const BodyPiece& other) {
          return other.region == piece.region && other.side == side && other.root_in_bone;
        }))
      piece.side = side;
  }
}

}  // namespace

BodyPieces body_pieces(const CoarseBody& b, const ClassProbabilities& probabilities) {
  BodyPieces out;
  out.regions = region_means(b, probabilities);
  Volume<std::uint8_t> seeds{b.grid(), std::vector<std::uint8_t>(b.grid().count())};
  Mask axial;
  const std::vector<Candidate> candidates = candidates_of(b, out.regions, axial);
  for (const Candidate& candidate : candidates) {
    BodyPiece piece;
    piece.region = candidate.region;
    piece.cut = is_cut(b, candidate.mask, false);
    if (is_limb(candidate.region)) {
      piece.side = candidate.side == LimbSide::unknown ? -1
                   : candidate.side == LimbSide::left  ? left_side
                                                       : right_side;
      piece.bone_chain = bone_chain_length(candidate.mask, b.bone, b.threads);
      if (!is_limb_piece(b, candidate, axial, piece.bone_chain)) continue;
    }
    if (out.list.size() >= 254) break;
    out.list.push_back(piece);
    for (std::size_t o = 0; o < seeds.voxels.size(); ++o)
      if (candidate.mask.voxels[o]) seeds.voxels[o] = static_cast<std::uint8_t>(out.list.size());
  }
  // the remaining voxels go to the nearest piece
  Volume<std::uint8_t> owner = nearest_seeds(
      Places(b.grid(), b.threads, [&](std::size_t o) { return b.body.voxels[o] ? 1.0F : no_path; }), seeds);
  join_loose_pieces(b, out.list, owner);
  out.piece.resize(b.places.size());
  std::vector<double> sums(out.list.size(), 0);
  for (std::size_t n = 0; n < b.places.size(); ++n) {
    out.piece[n] = static_cast<std::int16_t>(owner.voxels[b.places[n]] - 1);
    if (out.piece[n] < 0) continue;
    const auto own = static_cast<std::size_t>(out.piece[n]);
    out.list[own].volume += voxel_volume;
    sums[own] += out.regions[n][static_cast<std::size_t>(out.list[own].region)];
  }
  for (std::size_t n = 0; n < out.list.size(); ++n) {
    out.list[n].confidence = sums[n] * voxel_volume / std::max(out.list[n].volume, voxel_volume);
    if (is_limb(out.list[n].region)) measure_root(b, out, n, out.list[n]);
  }
  name_sides_by_roots(axial, out.list);
  return out;
}

}  // namespace borelli
