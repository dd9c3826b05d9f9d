#include "segmentation/joints/limbs.hpp"
#include "segmentation/proposal/walls.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace borelli {
namespace {

using Eigen::Vector3d;

// half a joint's gap, mm: at this distance from bone a step costs twice as much as along bone
constexpr double gap = 2;
// bone more than this medial of a head's centre is the trunk's, mm
constexpr double medial = 30;
// extents with a finger's breadth more, mm in a body of usual size: pelvis and its wings in front of and
// behind the hips, breastbone in front of the spine, clavicles above the shoulders
constexpr double pelvis_front = 80, pelvis_back = 95, wing_back = 70, chest_front = 150, girdle_top = 60;

// Cost per mm at a distance from bone. Beyond half of any joint's gap, bones are neighbours by chance, as a
// hand's beside the hip. Such paths are expensive, so that they do not enter another limb's bones. They are
// not closed, since coarse or noisy voxels lose small bones.
double step_cost(double off_bone) {
  constexpr double no_joint = 4;  // mm
  return 1 + std::pow(off_bone / gap, 2) * std::pow(std::max(1.0, off_bone / no_joint), 3);
}

Vector3d middle_of(const std::array<std::optional<FoundSphere>, 2>& pair) {
  return 0.5 * (pair[0]->centre + pair[1]->centre);
}

// Middle and direction of the trunk at a level. Between hips and shoulders it may bend and turn.
struct TrunkAcross {
  Vector3d middle, left;  // mm; unit direction, horizontal
};

Vector3d level_direction(const std::array<std::optional<FoundSphere>, 2>& pair) {
  Vector3d left = pair[0]->centre - pair[1]->centre;
  left[2] = 0;
  return left.normalized();
}

TrunkAcross across_trunk(const Trunk& trunk, double z) {
  const Vector3d hips = middle_of(trunk.hip), left = level_direction(trunk.hip);
  if (!(trunk.shoulder[0] && trunk.shoulder[1])) return {hips, left};
  const Vector3d up = middle_of(trunk.shoulder) - hips;
  const double t = std::clamp((z - hips[2]) / up[2], 0.0, 1.0);
  return {hips + t * up, ((1 - t) * left + t * level_direction(trunk.shoulder)).normalized()};
}

// Marks the trunk's own bones. `wings`: those marked only by their place above the hips, where the iliac
// wings lie and perhaps a hand.
void mark_axial(const Anatomy& a, const Trunk& trunk, Volume<std::uint8_t>& seeds, Mask& wings) {
  const auto& g = a.grid();
  const bool hips = trunk.hip[0] && trunk.hip[1], shoulders = trunk.shoulder[0] && trunk.shoulder[1];
  const double half_hips = hips ? 0.5 * (trunk.hip[0]->centre - trunk.hip[1]->centre).norm() : 0;
  const auto between = [](const std::array<std::optional<FoundSphere>, 2>& pair, const Vector3d& p) {
    const Vector3d left = (pair[0]->centre - pair[1]->centre).normalized();
    return left.dot(p - pair[0]->centre) < -medial && left.dot(p - pair[1]->centre) > medial;
  };
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        if (!a.bone.at(i, j, k)) continue;
        const Vector3d p = g.point(i, j, k);
        // a hand on the belly, on the chest or over the head also lies between hips and shoulders, but
        // farther forward or higher than the trunk's own bones
        const double size = trunk.scale;
        const bool at_pelvis = hips && p[1] > middle_of(trunk.hip)[1] - pelvis_front * size &&
                               p[1] < middle_of(trunk.hip)[1] + pelvis_back * size &&
                               (!shoulders || p[2] < middle_of(trunk.shoulder)[2] + girdle_top * size);
        const bool at_chest = shoulders && p[2] < middle_of(trunk.shoulder)[2] + girdle_top * size &&
                              p[1] > (trunk.spine_holds(p[2]) ? trunk.spine_at(p[2])[1]
                                                              : middle_of(trunk.shoulder)[1] + 35 * size) -
                                         chest_front * size;
        bool axial = trunk.spine_holds(p[2]) && (p - trunk.spine_at(p[2])).norm() < 40;
        constexpr double skull = 110;  // mm from the brain's middle
        if (trunk.brain && (p - *trunk.brain).norm() < skull * trunk.scale) axial = true;
        if (at_pelvis && p[2] > std::min(trunk.hip[0]->centre[2], trunk.hip[1]->centre[2]) - 30)
          axial = axial || between(trunk.hip, p);
        if (at_chest && p[2] > std::min(trunk.shoulder[0]->centre[2], trunk.shoulder[1]->centre[2]) - 165)
          axial = axial || between(trunk.shoulder, p);
        // more than 60 mm above both hips no bone is a leg's
        if (at_pelvis && p[2] > std::max(trunk.hip[0]->centre[2], trunk.hip[1]->centre[2]) + 60 * size) {
          const TrunkAcross here = across_trunk(trunk, p[2]);
          const bool behind_wings = p[1] > middle_of(trunk.hip)[1] + wing_back * size;
          if (!behind_wings && std::abs(here.left.dot(p - here.middle)) < half_hips + 25 && !axial)
            axial = true, wings.at(i, j, k) = 1;
        }
        if (axial) seeds.at(i, j, k) = static_cast<std::uint8_t>(Limb::axial);
      }
}

void mark_ball(const Anatomy& a, const Vector3d& centre, double r, Limb limb, Volume<std::uint8_t>& seeds) {
  const auto& g = a.grid();
  const Vector3d low = g.index(centre - Vector3d::Constant(r)),
                 high = g.index(centre + Vector3d::Constant(r));
  for (auto k = std::lround(low[2]); k <= std::lround(high[2]); ++k)
    for (auto j = std::lround(low[1]); j <= std::lround(high[1]); ++j)
      for (auto i = std::lround(low[0]); i <= std::lround(high[0]); ++i) {
        const Vector3d p = g.point(i, j, k);
        if (g.holds(i, j, k) && (p - centre).norm() < r) seeds.at(i, j, k) = static_cast<std::uint8_t>(limb);
      }
}

// Bone of a limb at one distance from its root.
struct Shell {
  double volume = 0;      // mm^3
  float farthest = 0;     // largest distance of its voxels, mm of path
  std::uint32_t end = 0;  // the voxel there
  bool at_edge = false;   // the scan's edge cuts bone here
};

// Number of shells up to the limb's end. Beyond a wide gap, calcium, contrast or noise in the flesh may pass
// for bone. The bones of fingers that coarse voxels show apart are more.
std::size_t shells_of_limb(const std::vector<Shell>& shells) {
  constexpr double widest = 150;               // mm of path across a gap: about 14 mm
  constexpr double thin = 0.02, least = 0.01;  // of the mean section before a gap; of the bone before it
  double all = 0, before = 0;
  for (const Shell& shell : shells) all += shell.volume;
  std::size_t bone = 0;  // number of shells up to the last one with bone
  for (std::size_t n = 0; n < shells.size(); ++n) {
    before += shells[n].volume;
    if (shells[n].volume > thin * before / static_cast<double>(n + 1)) {
      if (static_cast<double>(n - bone) * LimbPath::spacing > widest &&
          all - before + shells[n].volume < least * before)
        return bone;
      bone = n + 1;
    }
  }
  return bone;
}

LimbPath follow(const Anatomy& a, const Geodesic& territory, Limb limb) {
  LimbPath path;
  const auto& g = a.grid();
  const auto nx = static_cast<std::uint32_t>(g.size[0]), ny = static_cast<std::uint32_t>(g.size[1]);
  const auto point = [&](std::uint32_t o) {
    return g.point(Vector3d(o % nx, o / nx % ny, o / nx / ny));  // NOLINT: exact integers
  };
  std::vector<Shell> shells;
  const double voxel = std::pow(a.step(), 3);
  for (std::size_t o = 0; o < g.count(); ++o) {
    if (!a.bone.voxels[o] || territory.owner.voxels[o] != static_cast<std::uint8_t>(limb)) continue;
    const float length = territory.length(o);
    const auto n = static_cast<std::size_t>(length / LimbPath::spacing);
    if (n >= shells.size()) shells.resize(n + 1);
    Shell& shell = shells[n];
    shell.volume += voxel;
    if (!shell.at_edge && a.near_edge(point(static_cast<std::uint32_t>(o)), a.step())) shell.at_edge = true;
    if (length > shell.farthest) shell.farthest = length, shell.end = static_cast<std::uint32_t>(o);
  }
  shells.resize(shells_of_limb(shells));
  if (shells.empty() || shells.back().farthest <= 0) return path;
  const float farthest = shells.back().farthest;
  const std::uint32_t end = shells.back().end;
  path.present = true;
  path.cut = a.near_edge(point(end), 8);
  // resamples at equal path lengths, then smooths over about 15 mm
  const auto voxels = territory.path_to(end);
  std::vector<Vector3d> raw;
  std::size_t at = 0;
  for (double s = 0; s <= farthest; s += LimbPath::spacing) {
    while (at + 1 < voxels.size() && territory.length(voxels[at + 1]) <= s) ++at;
    Vector3d p = point(voxels[at]);
    if (at + 1 < voxels.size()) {
      const double s0 = territory.length(voxels[at]), s1 = territory.length(voxels[at + 1]);
      if (s1 > s0) p += (s - s0) / (s1 - s0) * (point(voxels[at + 1]) - p);
    }
    raw.push_back(p);
    const Vector3d index = g.index(p);
    path.off_bone.push_back(
        a.off_bone.at(std::lround(index[0]), std::lround(index[1]), std::lround(index[2])));
  }
  const auto count = static_cast<std::int64_t>(raw.size());
  for (std::int64_t n = 0; n < count; ++n) {
    Vector3d sum = Vector3d::Zero();
    double area = 0;
    const std::int64_t half = std::min<std::int64_t>({3, n, count - 1 - n});
    for (std::int64_t q = n - half; q <= n + half; ++q) sum += raw[static_cast<std::size_t>(q)];
    int averaged = 0;
    for (std::int64_t q = std::max<std::int64_t>(0, n - 1); q <= std::min(count - 1, n + 1); ++q, ++averaged)
      area += static_cast<std::size_t>(q) < shells.size()
                  ? shells[static_cast<std::size_t>(q)].volume / LimbPath::spacing
                  : 0;
    path.points.push_back(sum / static_cast<double>(2 * half + 1));
    path.section.push_back(area / averaged);
    path.at_edge.push_back(static_cast<std::size_t>(n) < shells.size() &&
                           shells[static_cast<std::size_t>(n)].at_edge);
  }
  return path;
}

constexpr float longest_limb = 3000;  // mm of path
constexpr SeedKinds kind_of_limb{
    0,
    wall_kind(limb_of(BodyRegion::leg, left_side)),
    wall_kind(limb_of(BodyRegion::leg, right_side)),
    wall_kind(limb_of(BodyRegion::arm, left_side)),
    wall_kind(limb_of(BodyRegion::arm, right_side)),
    wall_kind(limb_of(BodyRegion::trunk, -1)),
};

Limbs limbs_of(const Anatomy& a, const Trunk& trunk, Geodesic territory) {
  Limbs limbs;
  limbs.territory = std::move(territory);
  in_turns(std::ssize(limbs.path) - 1, a.threads, [&](std::int64_t first, std::int64_t last) {
    for (auto n = static_cast<std::size_t>(first) + 1; n <= static_cast<std::size_t>(last); ++n) {
      const bool leg = n <= 2;
      const auto& head = leg ? trunk.hip[n - 1] : trunk.shoulder[n - 3];
      const bool headless = leg && trunk.femur[n - 1];
      if (leg ? trunk.no_leg[n - 1] : trunk.no_arm[n - 3]) continue;
      if (head || headless) limbs.path[n] = follow(a, limbs.territory, static_cast<Limb>(n));
      limbs.path[n].headless = headless;
    }
  });
  return limbs;
}

// Removes the trunk's seeds above the hips in small bones without any other seed of the trunk: those of a
// hand. The iliac wings are large, and ribs begin at the spine.
void unmark_hands(const Anatomy& a, const Trunk& trunk, const Mask& wings, Volume<std::uint8_t>& seeds) {
  const double small = 40e3 * std::pow(trunk.scale, 3);  // mm^3; a hand's bones together have about 20e3
  constexpr auto axial = static_cast<std::uint8_t>(Limb::axial);
  const Regions bones = connected_regions(a.bone, 6);
  std::vector<char> own(bones.list.size() + 1, 0);
  for (std::size_t o = 0; o < seeds.voxels.size(); ++o)
    if (seeds.voxels[o] == axial && !wings.voxels[o])
      own[static_cast<std::size_t>(bones.number.voxels[o])] = 1;
  for (std::size_t o = 0; o < seeds.voxels.size(); ++o) {
    if (!wings.voxels[o]) continue;
    const auto number = static_cast<std::size_t>(bones.number.voxels[o]);
    if (!own[number] && static_cast<double>(bones.list[number - 1].voxels) * a.grid().voxel_volume() < small)
      seeds.voxels[o] = 0;
  }
}

// Paths along bones with a limited trunk: it extends only along bone from its seeds and less than a gap
// beyond. The rest goes to the limbs, however far from their heads.
Geodesic territory_of_kept_trunk(const Anatomy& a, const Trunk& trunk, const Volume<float>& cost,
                                 const Volume<std::uint8_t>& seeds) {
  constexpr double along_bone = 150, beyond = 30;  // mm of path: half a rib; less than a gap's cost
  constexpr auto axial = static_cast<std::uint8_t>(Limb::axial);
  Volume<float> open = cost;
  for (std::size_t o = 0; o < open.voxels.size(); ++o)
    if (a.off_bone[o] > 0) open.voxels[o] = no_path;
  const auto joined = nearest_seeds(walled(a, {open, a.threads}, kind_of_limb), seeds,
                                    static_cast<float>(along_bone * trunk.scale));
  Volume<std::uint8_t> wider = seeds;
  for (std::size_t o = 0; o < wider.voxels.size(); ++o)
    if (joined.voxels[o] == axial) wider.voxels[o] = axial;
  const auto kept =
      geodesic(walled(a, {cost, a.threads}, kind_of_limb), wider, false, static_cast<float>(beyond));
  open = cost;
  for (std::size_t o = 0; o < wider.voxels.size(); ++o) {
    if (kept.owner.voxels[o] == axial) open.voxels[o] = no_path;
    if (wider.voxels[o] == axial) wider.voxels[o] = 0;
  }
  Geodesic territory = geodesic(walled(a, {open, a.threads}, kind_of_limb), wider, true, longest_limb);
  for (std::size_t o = 0; o < wider.voxels.size(); ++o)
    if (kept.owner.voxels[o] == axial) territory.begin_at(o, axial, kept.length(o));
  return territory;
}

bool arms_meet(const Geodesic& territory) {
  constexpr auto left = static_cast<std::uint8_t>(Limb::arm_left),
                 right = static_cast<std::uint8_t>(Limb::arm_right);
  const auto& owner = territory.owner;
  const auto nx = static_cast<std::size_t>(owner.grid.size[0]);
  for (std::size_t o = 0; o < owner.voxels.size(); ++o) {
    const auto p = owner.voxels[o];
    if (p != left && p != right) continue;
    const auto other = p == left ? right : left;
    for (const std::size_t stride : {std::size_t{1}, nx, nx * static_cast<std::size_t>(owner.grid.size[1])})
      if (o >= stride && owner.voxels[o - stride] == other) return true;
  }
  return false;
}

// Separates the arms. If one hand lies on the other hand or forearm, the path to the other's bones may be
// shorter than along its own. Bones that an arm reaches across no more than a joint's gap are its own; each
// arm's paths are then found without the other's bones.
void part_arms(const Anatomy& a, const Volume<float>& cost, const Volume<std::uint8_t>& seeds, Limbs& limbs) {
  // cost by the gaps crossed, hardly by the length along bone; a joint's gap is thin, so it looks less dark
  constexpr float along_bone = 0.02F;
  constexpr double soft = 50, bone = 200, widest = 8;  // CT numbers; mm off bone
  Volume<float> open = cost;
  for (std::size_t o = 0; o < open.voxels.size(); ++o) {
    const double off = a.off_bone[o];
    if (open.voxels[o] == no_path || off > widest) {
      open.voxels[o] = no_path;
    } else {
      const double dark = off > 0 ? std::clamp((bone - a.scan.hu.voxels[o]) / (bone - soft), 0.0, 1.0) : 0;
      open.voxels[o] = along_bone + static_cast<float>(dark * dark * (step_cost(off) - 1));
    }
  }
  const auto joined = nearest_seeds(walled(a, {open, a.threads}, kind_of_limb), seeds);
  std::array<Geodesic, 2> alone;
  constexpr std::array<Limb, 2> arms{Limb::arm_left, Limb::arm_right};
  for (std::size_t n = 0; n < 2; ++n) {
    const auto other = static_cast<std::uint8_t>(arms[1 - n]);
    open = cost;
    Volume<std::uint8_t> from = seeds;
    for (std::size_t o = 0; o < open.voxels.size(); ++o) {
      if (joined.voxels[o] == other) open.voxels[o] = no_path;
      if (from.voxels[o] == other) from.voxels[o] = 0;
    }
    alone[n] = geodesic(walled(a, {open, a.threads}, kind_of_limb), from, true, longest_limb);
  }
  Geodesic& territory = limbs.territory;
  territory = std::move(alone[0]);
  territory.take_nearer(alone[1]);
  for (std::size_t n = 0; n < 2; ++n) {
    if (n == 1) territory.take_paths(std::move(alone[1]));
    LimbPath& path = limbs.path[static_cast<std::size_t>(arms[n])];
    if (path.present) path = follow(a, territory, arms[n]);
  }
}

}  // namespace

Limbs trace_limbs(const Anatomy& a, const Trunk& trunk) {
  const auto& g = a.grid();
  const auto cost_at = [&](std::size_t o) {
    const float off = a.off_bone[o];
    return a.body.voxels[o] && off < 40 ? static_cast<float>(step_cost(off)) : no_path;
  };
  const auto cost = [&] {
    Volume<float> out{g, std::vector<float>(g.count())};
    for (std::size_t o = 0; o < g.count(); ++o) out.voxels[o] = cost_at(o);
    return out;
  };
  Volume<std::uint8_t> seeds{g, std::vector<std::uint8_t>(g.count(), 0)};
  Mask wings{g, std::vector<std::uint8_t>(g.count(), 0)};
  mark_axial(a, trunk, seeds, wings);
  unmark_hands(a, trunk, wings, seeds);
  for (const int side : {left_side, right_side}) {
    const auto n = static_cast<std::size_t>(side);
    const Limb leg = side == left_side ? Limb::leg_left : Limb::leg_right,
               arm = side == left_side ? Limb::arm_left : Limb::arm_right;
    const auto core = [](const FoundSphere& head) { return 0.7 * std::min(head.radius, 27.0); };
    constexpr double shaft = 12;  // mm
    if (trunk.hip[n] && !trunk.no_leg[n]) mark_ball(a, trunk.hip[n]->centre, core(*trunk.hip[n]), leg, seeds);
    if (trunk.femur[n]) mark_ball(a, *trunk.femur[n], shaft, leg, seeds);
    if (trunk.shoulder[n] && !trunk.no_arm[n])
      mark_ball(a, trunk.shoulder[n]->centre, core(*trunk.shoulder[n]), arm, seeds);
  }
  Limbs limbs = limbs_of(
      a, trunk, geodesic(walled(a, Places(g, a.threads, cost_at), kind_of_limb), seeds, true, longest_limb));
  limbs.arms_meet = arms_meet(limbs.territory);
  if (limbs.arms_meet) part_arms(a, cost(), seeds, limbs);
  // A hand on the hip is as near to the pelvis' bones as to its own, and the path from there is shorter than
  // along its arm. The arm then ends early, or before the other arm does.
  constexpr double far_enough = 500, gained = 100;  // mm; a whole arm's path has about 700
  const auto ends_early = [&](int side) {
    const LimbPath &path = limbs.arm(side), &other = limbs.arm(1 - side);
    return path.present && !path.cut &&
           (path.length() < far_enough * trunk.scale ||
            (other.present && path.length() < other.length() - gained * trunk.scale));
  };
  if (!ends_early(left_side) && !ends_early(right_side)) return limbs;
  Limbs kept = limbs_of(a, trunk, territory_of_kept_trunk(a, trunk, cost(), seeds));
  kept.arms_meet = limbs.arms_meet;
  for (const int side : {left_side, right_side})
    if (ends_early(side) && kept.arm(side).length() > limbs.arm(side).length() + gained * trunk.scale)
      return kept;
  return limbs;
}

}  // namespace borelli
