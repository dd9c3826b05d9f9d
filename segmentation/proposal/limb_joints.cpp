#include "segmentation/proposal/limb_joints.hpp"

#include <algorithm>
#include <cmath>

#include "segmentation/grid/geodesic.hpp"
#include "segmentation/proposal/coarse_body.hpp"
#include "segmentation/vocabulary/parts.hpp"

namespace borelli {
namespace {

constexpr double bin = 4;             // mm along the limb
constexpr double about_cut = 8;       // mm to each side
constexpr double least_segment = 20;  // mm: a shorter segment is dropped, and its cut is no joint

// A limb's voxels with their distances along it.
struct Along {
  std::vector<std::size_t> places;
  std::vector<float> length;  // from the root, mm; by index into places
};

// Probabilities summed per bin: the limb's three classes, the first at the root.
using Profile = std::vector<std::array<double, 3>>;

struct Cuts {
  std::size_t first = 0, second = 0;  // bins before which the second and the third segment begin
  double score = 0;
};

// the two cuts with the greatest sum of probabilities, from cumulative sums
Cuts best_cuts(const Profile& profile) {
  const std::size_t n = profile.size();
  std::vector<std::array<double, 3>> sums(n + 1, {0, 0, 0});
  for (std::size_t s = 0; s < n; ++s)
    for (std::size_t c = 0; c < 3; ++c) sums[s + 1][c] = sums[s][c] + profile[s][c];
  Cuts best;
  best.score = -1;
  for (std::size_t first = 0; first <= n; ++first)
    for (std::size_t second = first; second <= n; ++second) {
      const double score = sums[first][0] + sums[second][1] - sums[first][1] + sums[n][2] - sums[second][2];
      if (score > best.score) best = {first, second, score};
    }
  return best;
}

Along along_from(const CoarseBody& b, const std::vector<std::size_t>& places,
                 const Volume<std::uint8_t>& seeds, const std::vector<char>& in_piece) {
  const Geodesic paths = geodesic(
      Places(b.grid(), b.threads, [&](std::size_t o) { return in_piece[o] ? 1.0F : no_path; }), seeds, false);
  Along out;
  for (const std::size_t n : places) {
    const float length = paths.length(b.places[n]);
    if (length == no_path) continue;
    out.places.push_back(n), out.length.push_back(length);
  }
  return out;
}

Profile profile_of(const Along& along, const ClassProbabilities& probabilities, std::size_t first_class) {
  float longest = 0;
  for (const float length : along.length) longest = std::max(longest, length);
  Profile profile(static_cast<std::size_t>(longest / bin) + 1, {0, 0, 0});
  for (std::size_t n = 0; n < along.places.size(); ++n)
    for (std::size_t c = 0; c < 3; ++c)
      profile[static_cast<std::size_t>(along.length[n] / bin)][c] +=
          probabilities.of(along.places[n])[first_class + c] / 255.0;
  return profile;
}

// Distances from the limb's root. Without a root: from the end of the limb that gives the better cuts.
std::pair<Along, Cuts> order_limb(const CoarseBody& b, const ClassProbabilities& probabilities,
                                  const BodyPieces& pieces, std::size_t number,
                                  const std::vector<std::size_t>& places) {
  const Grid& g = b.grid();
  const BodyPiece& piece = pieces.list[number];
  const std::size_t first_class = piece.region == BodyRegion::arm ? 2 : 5;
  std::vector<char> in_piece(g.count(), 0);
  for (const std::size_t n : places) in_piece[b.places[n]] = 1;
  const auto point = [&](std::size_t n) {
    const auto o = static_cast<std::int64_t>(b.places[n]);
    return g.point(o % g.size[0], o / g.size[0] % g.size[1], o / (g.size[0] * g.size[1]));
  };
  const auto from = [&](const auto& is_seed) {
    Volume<std::uint8_t> seeds{g, std::vector<std::uint8_t>(g.count())};
    for (const std::size_t n : places) seeds.voxels[b.places[n]] = is_seed(n);
    Along along = along_from(b, places, seeds, in_piece);
    const Cuts cuts = best_cuts(profile_of(along, probabilities, first_class));
    return std::pair(std::move(along), cuts);
  };
  if (piece.root) {
    std::size_t nearest = places.front();
    for (const std::size_t n : places)
      if ((point(n) - *piece.root).squaredNorm() < (point(nearest) - *piece.root).squaredNorm()) nearest = n;
    return from([&](std::size_t n) { return n == nearest; });
  }
  const auto farthest = [&](const Along& along) {
    const auto at = std::max_element(along.length.begin(), along.length.end()) - along.length.begin();
    return along.places[static_cast<std::size_t>(at)];
  };
  const std::size_t start = farthest(from([&](std::size_t n) { return n == places.front(); }).first);
  auto one = from([&](std::size_t n) { return n == start; });
  const std::size_t end = farthest(one.first);
  auto other = from([&](std::size_t n) { return n == end; });
  return one.second.score > other.second.score ? one : other;
}

std::optional<Eigen::Vector3d> bone_at(const CoarseBody& b, const Along& along, double length) {
  const Grid& g = b.grid();
  Eigen::Vector3d of_bone = Eigen::Vector3d::Zero(), of_all = Eigen::Vector3d::Zero();
  double bones = 0, all = 0;
  for (std::size_t n = 0; n < along.places.size(); ++n) {
    if (std::abs(along.length[n] - length) > about_cut) continue;
    const auto o = static_cast<std::int64_t>(b.places[along.places[n]]);
    const Eigen::Vector3d p = g.point(o % g.size[0], o / g.size[0] % g.size[1], o / (g.size[0] * g.size[1]));
    of_all += p, ++all;
    if (b.bone.voxels[static_cast<std::size_t>(o)]) of_bone += p, ++bones;
  }
  constexpr double few = 3;
  if (bones > few) return Eigen::Vector3d(of_bone / bones);
  if (all > 0) return Eigen::Vector3d(of_all / all);
  return std::nullopt;
}

constexpr std::array<std::array<std::string_view, 2>, 2> joint_names{{{"elbow", "wrist"}, {"knee", "ankle"}}};

void add_joints(const CoarseBody& b, const BodyPieces& pieces, std::size_t number, const Along& along,
                const Cuts& cuts, const Forest& forest, std::vector<ProposedJoint>& joints) {
  const BodyPiece& piece = pieces.list[number];
  float longest = 0;
  for (const float length : along.length) longest = std::max(longest, length);
  const std::array<double, 4> bounds{0, bin * static_cast<double>(cuts.first),
                                     bin * static_cast<double>(cuts.second), static_cast<double>(longest)};
  for (std::size_t n = 0; n < 2; ++n) {
    if (bounds[n + 1] - bounds[n] < least_segment || bounds[n + 2] - bounds[n + 1] < least_segment) continue;
    const auto point = bone_at(b, along, bounds[n + 1]);
    if (!point) continue;
    const std::string stem(joint_names[piece.region == BodyRegion::arm ? 0 : 1][n]);
    const auto deviation = forest.deviations.find(stem);
    joints.push_back({number, piece.region, piece.side,
                      stem + (piece.side < 0 ? "" : side_suffix(piece.side)), *point,
                      deviation == forest.deviations.end() ? 0 : deviation->second});
  }
}

int part_of(std::size_t voxel_class, int side) {
  if (voxel_class == 0) return part_label("head");
  if (voxel_class == 1) return part_label("upper_trunk");
  return side < 0 ? 0 : part_label(std::string(voxel_classes[voxel_class]) + side_suffix(side));
}

}  // namespace

LimbSegments limb_segments(const CoarseBody& b, const ClassProbabilities& probabilities,
                           const BodyPieces& pieces, const Forest& forest) {
  LimbSegments out;
  out.part.assign(b.places.size(), 0);
  out.voxel_class.assign(b.places.size(), 1);
  std::vector<std::vector<std::size_t>> by_piece(pieces.list.size());
  for (std::size_t n = 0; n < b.places.size(); ++n)
    if (pieces.piece[n] >= 0) by_piece[static_cast<std::size_t>(pieces.piece[n])].push_back(n);
  const auto put = [&](std::size_t n, std::size_t voxel_class, int side) {
    out.voxel_class[n] = static_cast<std::uint8_t>(voxel_class);
    out.part[n] = static_cast<std::uint8_t>(part_of(voxel_class, side));
  };
  for (std::size_t p = 0; p < pieces.list.size(); ++p) {
    const BodyPiece& piece = pieces.list[p];
    if (by_piece[p].empty()) continue;
    if (!is_limb(piece.region)) {
      for (const std::size_t n : by_piece[p]) put(n, static_cast<std::size_t>(piece.region), -1);
      continue;
    }
    const std::size_t first_class = piece.region == BodyRegion::arm ? 2 : 5;
    // voxels that no path reaches stay with the first segment
    for (const std::size_t n : by_piece[p]) put(n, first_class, piece.side);
    const auto [along, cuts] = order_limb(b, probabilities, pieces, p, by_piece[p]);
    for (std::size_t n = 0; n < along.places.size(); ++n) {
      const auto at = static_cast<std::size_t>(along.length[n] / bin);
      put(along.places[n], first_class + (at >= cuts.first) + (at >= cuts.second), piece.side);
    }
    add_joints(b, pieces, p, along, cuts, forest, out.joints);
  }
  return out;
}

}  // namespace borelli
