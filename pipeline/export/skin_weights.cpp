#include "pipeline/export/skin_weights.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "pipeline/export/skin_contacts.hpp"
#include "pipeline/export/skin_zones.hpp"
#include "threads/slabs.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;
using Index = std::array<std::int64_t, 3>;

/// Weights of the bones that move a place. Room for `most` bones; later ones are dropped.
struct BoneWeights {
  static constexpr std::size_t most = 48;
  std::array<std::uint16_t, most> bone{};
  std::array<double, most> weight{};
  std::size_t count = 0;

  void add(std::size_t of, double w) {
    if (w <= 0) return;
    const auto* const found = std::find(bone.begin(), bone.begin() + count, of);
    const auto n = static_cast<std::size_t>(found - bone.begin());
    if (n == most) return;
    if (n == count) bone[count++] = static_cast<std::uint16_t>(of);
    weight[n] += w;
  }
};

/// Bones from one pose to another at equal intervals.
using Chain = std::vector<std::size_t>;

/// The bones stand at equal steps from z = 0 to 1. Adds `scale` times linear weights of the two bones beside
/// z.
void add_ramp(BoneWeights& to, const Chain& chain, double z, double scale) {
  const double u = std::clamp(z, 0.0, 1.0) * (static_cast<double>(chain.size()) - 1);
  const auto below = std::min(static_cast<std::size_t>(u), chain.size() - 2);
  to.add(chain[below], scale * (1 - (u - static_cast<double>(below))));
  to.add(chain[below + 1], scale * (u - static_cast<double>(below)));
}

/// A joint's bones: those of its swing and, apart from them, those of its twist along a segment.
struct JointChains {
  Chain swing, twist;
};

std::vector<JointChains> chains_of(const Skin& skin) {
  std::vector<JointChains> chains(skin.parts.size());
  std::vector<Chain> helpers(skin.parts.size());
  for (std::size_t b = skin.parts.size(); b < skin.bones.size(); ++b)
    helpers[skin.bones[b].part].push_back(b);
  for (std::size_t n = 0; n < skin.parts.size(); ++n) {
    if (!skin.parts[n].has_joint) continue;
    Chain all{static_cast<std::size_t>(skin.parts[n].parent)};
    all.insert(all.end(), helpers[n].begin(), helpers[n].end());
    all.push_back(n);
    if (skin.parts[n].twist == TwistAlong::zone) {
      chains[n].swing = all;
      continue;
    }
    const auto half = static_cast<std::ptrdiff_t>(all.size() / 2);  // the bone where both meet
    const Chain first(all.begin(), all.begin() + half + 1), second(all.begin() + half, all.end());
    const bool swing_first = skin.parts[n].twist == TwistAlong::part;
    chains[n] = swing_first ? JointChains{first, second} : JointChains{second, first};
  }
  return chains;
}

/// Weights of the voxels of the isotropic grid.
///
/// Zones of several joints overlap where their cuts meet, as in the groin. A place there follows all joints
/// of one part (the middle of a star). z_j is the share of joint j's turn that the place makes; d_j is its
/// deviation from the middle's pose: z_j for a joint to a child, 1 - z_j for the middle's own joint. With D =
/// sum d_j, joint j gets the weight d_j / D, shared by its two bones beside D. To first order in the angles,
/// the place then turns by the share z_j of each joint's rotation.
class VoxelWeights {
 public:
  VoxelWeights(const Skin& skin, const Volume<std::uint8_t>& coarse, int threads)
      : parts_(skin.parts),
        chains_(chains_of(skin)),
        paths_(paths_from_cuts(skin.parts, coarse, threads)),
        joints_(skin.parts.size()),
        twister_(skin.parts.size()),
        reach_up_(skin.parts.size(), 0),
        reach_down_(skin.parts.size(), 0) {
    for (std::size_t n = 0; n < parts_.size(); ++n) {
      if (!parts_[n].has_joint) continue;
      joints_[n].push_back(n);
      joints_[parent(n)].push_back(n);
      if (parts_[n].twist == TwistAlong::part) twister_[n] = n;
      if (parts_[n].twist == TwistAlong::parent) twister_[parent(n)] = n;
    }
    for (std::size_t n = 0; n < parts_.size(); ++n)
      if (parts_[n].has_joint) set_reaches(n, coarse);
  }

  /// Adds `scale` times the weights at a voxel of `part`.
  void add(BoneWeights& to, std::size_t part, const Index& at, double scale) const {
    // the middle of the star of joints that act here most
    Star most = star(part, part, at);
    for (const std::size_t joint : joints_[part]) {
      const std::size_t other = joint == part ? parent(joint) : joint;
      if (const Star of = star(other, part, at); of.activity > most.activity) most = of;
    }
    if (most.deviation > 0) {
      const double all = std::min(1.0, most.deviation);
      for (std::size_t n = 0; n < most.count; ++n) {
        const auto [joint, deviation] = most.joints[n];
        add_ramp(to, chains_[joint].swing, joint == most.middle ? 1 - all : all,
                 scale * deviation / most.deviation);
      }
      return;
    }
    add_between(to, part, at, scale);
  }

 private:
  /// The joints of one part at a place: how far each is from the part's own pose, as a share of its turn.
  struct Star {
    std::size_t middle = 0, count = 0;
    std::array<std::pair<std::size_t, double>, 8> joints;  // and their deviations
    double deviation = 0;                                  // their sum
    double activity = 0;                                   // sum of the shares left to the nearer end
  };

  std::size_t parent(std::size_t joint) const { return static_cast<std::size_t>(parts_[joint].parent); }

  bool below(std::size_t part, std::size_t joint) const {
    for (int at = static_cast<int>(part); at >= 0; at = parts_[static_cast<std::size_t>(at)].parent)
      if (at == static_cast<int>(joint)) return true;
    return false;
  }

  /// Length of the path from the cut of a joint to a voxel of `part`, m: positive on the side of the joint's part.
  double signed_length(std::size_t joint, std::size_t part, const Index& at) const {
    const double length = paths_[joint].length(at[0], at[1], at[2]);
    return below(part, joint) ? length : -length;
  }

  Star star(std::size_t middle, std::size_t part, const Index& at) const {
    Star out;
    out.middle = middle;
    for (const std::size_t joint : joints_[middle]) {
      const double length = signed_length(joint, part, at);
      if (!std::isfinite(length) || out.count == out.joints.size()) continue;
      const double up = reach(joint, parent(joint), part, at), down = reach(joint, joint, part, at);
      const double z = std::clamp((up + length) / (up + down), 0.0, 1.0);
      if (z <= 0 || z >= 1) continue;
      out.joints[out.count] = {joint, joint == middle ? 1 - z : z};
      out.deviation += out.joints[out.count++].second;
      out.activity += std::min(z, 1 - z);
    }
    return out;
  }

  /// Weights where no joint swings: those of the part, or of the twist along it.
  void add_between(BoneWeights& to, std::size_t part, const Index& at, double scale) const {
    double from_own = -1, from_child = -1;  // m, behind the end of the joint's zone
    if (twister_[part])
      for (const std::size_t joint : joints_[part]) {
        const double length = std::abs(signed_length(joint, part, at));
        if (std::isfinite(length))
          (joint == part ? from_own : from_child) = length - reach(joint, part, part, at);
      }
    if (from_own < 0 || from_child < 0) return to.add(part, scale);
    const double all = from_own + from_child;
    add_ramp(to, chains_[*twister_[part]].twist, all > 0 ? from_own / all : 0, scale);
  }

  /// How far a joint's zone reaches into one of its parts where no other zone does.
  double wanted(std::size_t joint, std::size_t into) const {
    return joint == into ? reach_down_[joint] : reach_up_[joint];
  }

  /// The zone's reach into one of the joint's parts, m, near a voxel of `part`. It ends at the part's other
  /// end at the latest. If the part twists between its ends, both zones leave a quarter of it for the twist.
  double reach(std::size_t joint, std::size_t into, std::size_t part, const Index& at) const {
    const double most = wanted(joint, into);
    double least = most;
    for (const std::size_t other : joints_[into]) {
      if ((other == into) == (joint == into)) continue;  // joints to two children overlap
      const double room = std::abs(signed_length(joint, part, at) - signed_length(other, part, at));
      if (!std::isfinite(room)) continue;
      least = std::min(least, twister_[into] ? 0.75 * most * room / (most + wanted(other, into)) : room);
    }
    return std::max(least, 1e-4);
  }

  /// A zone reaches two half thicknesses into both parts. If other cuts of the parent are nearer (median over
  /// the cut), it reaches only as far as these, and at most 2.5 times as far into the part: a limb whose zone
  /// lies mostly below the joint's centre would bend below the joint.
  void set_reaches(std::size_t joint, const Volume<std::uint8_t>& coarse) {
    const PathsFromCut& paths = paths_[joint];
    const auto at_cut = static_cast<float>(0.51e-3 * coarse.grid.axes(0, 0));
    std::vector<double> rooms;
    std::size_t n = 0;
    for (std::int64_t k = paths.first[2]; k < paths.first[2] + paths.size[2]; ++k)
      for (std::int64_t j = paths.first[1]; j < paths.first[1] + paths.size[1]; ++j)
        for (std::int64_t i = paths.first[0]; i < paths.first[0] + paths.size[0]; ++i, ++n) {
          if (paths.lengths[n] > at_cut || coarse.at(i, j, k) != parent(joint) + 1) continue;
          double room = std::numeric_limits<double>::infinity();
          for (const std::size_t other : joints_[parent(joint)])
            if (other != joint) room = std::min<double>(room, paths_[other].length(i, j, k));
          rooms.push_back(room);
        }
    const double r = parts_[joint].half_thickness;
    reach_up_[joint] = 2 * r;
    if (!rooms.empty()) {
      const auto middle = rooms.begin() + std::ssize(rooms) / 2;
      std::nth_element(rooms.begin(), middle, rooms.end());
      reach_up_[joint] = std::min(2 * r, *middle);
    }
    reach_down_[joint] = std::min(2 * r, 2.5 * reach_up_[joint]);
  }

  const std::vector<SkinPart>& parts_;
  std::vector<JointChains> chains_;
  std::vector<PathsFromCut> paths_;
  std::vector<std::vector<std::size_t>> joints_;     // of each part: its own and its children's
  std::vector<std::optional<std::size_t>> twister_;  // of each part: the joint that twists it
  std::vector<double> reach_up_, reach_down_;        // of each joint's zone: into parent and part, m
};

/// Calls visit(index, voxel's value) for the voxels at most `reach` from a fractional index.
template <class Visit>
void each_near(const Volume<std::uint8_t>& volume, const Vector3d& at, double reach, const Visit& visit) {
  Index first{}, last{};
  for (std::size_t c = 0; c < 3; ++c) {
    const double x = at[static_cast<int>(c)];
    first[c] = std::max<std::int64_t>(0, static_cast<std::int64_t>(std::ceil(x - reach)));
    last[c] = std::min(volume.grid.size[c] - 1, static_cast<std::int64_t>(std::floor(x + reach)));
  }
  for (std::int64_t k = first[2]; k <= last[2]; ++k)
    for (std::int64_t j = first[1]; j <= last[1]; ++j)
      for (std::int64_t i = first[0]; i <= last[0]; ++i)
        if (const std::uint8_t value = volume.at(i, j, k)) visit(Index{i, j, k}, value);
}

double distance(const Index& i, const Vector3d& at) {
  return (Vector3d(double(i[0]), double(i[1]), double(i[2])) - at).norm();
}

/// The part of the voxel nearest to a point, mm; within five voxels.
std::optional<std::size_t> part_at(const Volume<std::uint8_t>& body, const Vector3d& p) {
  const Vector3d at = body.grid.index(p);
  double nearest = 1e30;
  std::optional<std::size_t> part;
  for (const double reach : {1.0, 2.0, 5.0}) {
    each_near(body, at, reach, [&](const Index& i, std::uint8_t value) {
      const double mm = (body.grid.axes * (Vector3d(double(i[0]), double(i[1]), double(i[2])) - at)).norm();
      if (mm < nearest) nearest = mm, part = value - 1U;
    });
    if (part) break;
  }
  return part;
}

/// Weights at a point, mm, of a part: trilinear between the voxels around it that flesh joins to it.
BoneWeights weights_at(const Vector3d& p, std::size_t part, const VoxelWeights& voxels,
                       const Volume<std::uint8_t>& coarse, const std::vector<SkinPart>& parts) {
  const Vector3d at = coarse.grid.index(p);
  BoneWeights out;
  each_near(coarse, at, 1, [&](const Index& i, std::uint8_t value) {
    if (value - 1U != part && !flesh_joins(parts, part, value - 1U, 1e-3 * p)) return;
    double share = 1;
    for (std::size_t c = 0; c < 3; ++c) share *= 1 - std::abs(double(i[c]) - at[static_cast<int>(c)]);
    if (share > 0) voxels.add(out, value - 1U, i, share);
  });
  if (out.count > 0) return out;
  double nearest = 1e30;
  Index best{};
  each_near(coarse, at, 3, [&](const Index& i, std::uint8_t value) {
    if (value - 1U == part && distance(i, at) < nearest) nearest = distance(i, at), best = i;
  });
  if (nearest < 1e30)
    voxels.add(out, part, best, 1);
  else
    out.add(part, 1);
  return out;
}

/// Keeps the four largest weights and makes their sum 1.
void keep_four(const BoneWeights& all, std::array<std::uint16_t, 4>& bones, std::array<float, 4>& weights) {
  std::array<std::size_t, BoneWeights::most> order{};
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.begin() + all.count, [&](std::size_t a, std::size_t b) {
    return all.weight[a] != all.weight[b] ? all.weight[a] > all.weight[b] : all.bone[a] < all.bone[b];
  });
  const std::size_t kept = std::min<std::size_t>(4, all.count);
  double sum = 0;
  for (std::size_t n = 0; n < kept; ++n) sum += all.weight[order[n]];
  bones.fill(0);
  weights.fill(0);
  float rest = 1;
  for (std::size_t n = kept; n-- > 1;) {
    const auto weight = static_cast<float>(all.weight[order[n]] / sum);
    if (weight < 1e-6F) continue;
    bones[n] = all.bone[order[n]], weights[n] = weight;
    rest -= weight;
  }
  bones[0] = all.bone[order[0]], weights[0] = rest;
}

}  // namespace

std::vector<SkinBone> skin_bones(const std::vector<SkinPart>& parts, int helpers) {
  std::vector<SkinBone> bones;
  for (std::size_t n = 0; n < parts.size(); ++n) bones.push_back({parts[n].name, n});
  const int intervals = helpers + 1;
  const auto share = [&](int k) { return static_cast<double>(k) / intervals; };
  for (std::size_t n = 0; n < parts.size(); ++n) {
    if (!parts[n].has_joint) continue;
    const auto add = [&](const char* what, int k, double swing, double twist) {
      bones.push_back({fmt::format("{}: {} {}/{}", parts[n].name, what, k, intervals), n, swing, twist});
    };
    const TwistAlong along = parts[n].twist;
    if (along == TwistAlong::zone)
      for (int k = 1; k < intervals; ++k) add("turn", k, share(k), share(k));
    if (along == TwistAlong::parent)
      for (int k = 1; k <= intervals; ++k) add("twist", k, 0, share(k));
    if (along != TwistAlong::zone)
      for (int k = 1; k < intervals + (along == TwistAlong::part); ++k)
        add("swing", k, share(k), along == TwistAlong::part ? 0 : 1);
    if (along == TwistAlong::part)
      for (int k = 1; k < intervals; ++k) add("twist", k, 1, share(k));
  }
  return bones;
}

void weigh_points(Skin& skin, const Volume<std::uint8_t>& body, const Volume<std::uint8_t>& coarse,
                  const SkinOptions& options) {
  const Mesh& mesh = skin.mesh;
  std::vector<Vector3d> inwards(mesh.points.size(), Vector3d::Zero());
  for (const auto& t : mesh.triangles) {
    const Vector3d a = mesh.points[t[0]].cast<double>(), b = mesh.points[t[1]].cast<double>(),
                   c = mesh.points[t[2]].cast<double>();
    for (const auto corner : t) inwards[corner] -= (b - a).cross(c - a);
  }
  const VoxelWeights voxels(skin, coarse, options.threads);
  const double fine_mm = 0.5 * body.grid.spacing().minCoeff(), coarse_mm = 0.5 * coarse.grid.axes(0, 0);
  skin.bones_of.resize(mesh.points.size());
  skin.weights.resize(mesh.points.size());
  in_slabs(std::ssize(mesh.points), options.threads, [&](std::int64_t first, std::int64_t last) {
    for (auto n = static_cast<std::size_t>(first); n < static_cast<std::size_t>(last); ++n) {
      const Vector3d p = 1e3 * mesh.points[n].cast<double>(), normal = inwards[n].stableNormalized();
      const std::size_t part = part_at(body, p + fine_mm * normal).value_or(0);
      keep_four(weights_at(p + coarse_mm * normal, part, voxels, coarse, skin.parts), skin.bones_of[n],
                skin.weights[n]);
    }
  });
}

}  // namespace borelli
