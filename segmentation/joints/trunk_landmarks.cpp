#include "segmentation/joints/trunk_landmarks.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "segmentation/grid/work_grid.hpp"
#include "segmentation/joints/iliac_spines.hpp"
#include "segmentation/joints/trunk_front.hpp"
#include "segmentation/joints/vertebrae.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

bool level_seen(const Anatomy& a, double z) {
  const auto k = std::lround((z - a.grid().origin[2]) / a.step());
  if (k < 1 || k + 1 >= a.grid().size[2]) return false;
  for (std::int64_t j = 0; j < a.grid().size[1]; j += 4)
    for (std::int64_t i = 0; i < a.grid().size[0]; i += 4)
      if (a.scan.seen.at(i, j, k) && a.body.at(i, j, k)) return true;
  return false;
}

// the midline bone in front of the spine: its upper end, and its lower end, the xiphoid's tip
struct Sternum {
  Vector3d top, tip;
  bool tip_hidden = false;  // thick bone, perhaps contrast in the heart, lies at or just below the tip
};

// The foremost bone in the midline at a level of the work grid.
struct FrontBone {
  std::optional<Vector3d> middle;  // of its front
  bool thick = false;  // thicker than a sternum: contrast in the heart, alone or with a sternum before it
};

// The foremost bone within 18 mm of the middle, 55 mm or more in front of the column, and nearer to the skin
// than to the column (a vertebra's front is not).
FrontBone front_bone(const Anatomy& a, const Trunk& trunk, const Limbs& limbs, std::int64_t k) {
  constexpr double aside = 18, before = 55;  // mm
  constexpr double thickest = 25;  // mm, of a sternum that leans forward, in a mask of coarse voxels
  const auto& g = a.grid();
  const double z = g.origin[2] + a.step() * static_cast<double>(k);
  const Vector3d column = trunk.spine_at(z);
  const auto mid = std::lround((column[0] - g.origin[0]) / a.step()), half = std::lround(aside / a.step());
  const auto behind = std::min<std::int64_t>(
      std::lround((column[1] - before * trunk.scale - g.origin[1]) / a.step()), g.size[1]);
  const auto first = std::max<std::int64_t>(0, mid - half), end = std::min(g.size[0] - 1, mid + half);
  const auto bone = [&](std::int64_t i, std::int64_t j) {
    return a.bone.at(i, j, k) && !limbs.arm_at(i, j, k);
  };
  for (std::int64_t j = 0; j < behind; ++j) {
    auto i = first, last = end;
    while (i <= end && !bone(i, j)) ++i;
    if (i > end) continue;
    while (!bone(last, j)) --last;
    const Vector3d middle = 0.5 * (g.point(i, j, k) + g.point(last, j, k));
    if (a.depth[g.offset((i + last) / 2, j, k)] >= column[1] - middle[1]) continue;
    auto back = j;
    while (back < g.size[1] && bone(i, back)) ++back;
    return {middle, a.step() * static_cast<double>(back - j) > thickest * trunk.scale + 2 * a.over_fine()};
  }
  return {};
}

std::optional<Sternum> find_sternum(const Anatomy& a, const Trunk& trunk, const Limbs& limbs, double from,
                                    double to) {
  const auto& g = a.grid();
  std::vector<FrontBone> front;
  const auto k0 = std::max<std::int64_t>(0, std::lround((from - g.origin[2]) / a.step()));
  const auto k1 = std::min<std::int64_t>(g.size[2] - 1, std::lround((to - g.origin[2]) / a.step()));
  for (std::int64_t k = k0; k <= k1; ++k) front.push_back(front_bone(a, trunk, limbs, k));
  // The sternum is the longest stretch of levels with at least 40 mm of thin bone. Short breaks are its
  // joints. Its front is smooth: a step of 22 mm leads to another structure, and so does a smaller one beside
  // thick bone.
  constexpr double leap = 22, along = 4, slope = 0.6, plates = 40, shortest = 60;  // mm; slope: mm/mm
  std::size_t best_low = 0, best_high = 0, length = 0;
  const auto may_miss = static_cast<std::size_t>(std::lround(12 / a.step()));
  const auto joins = [&](std::size_t low, std::size_t high) {
    const double step = std::abs((*front[high].middle)[1] - (*front[low].middle)[1]);
    return step < (front[low].thick || front[high].thick
                       ? along + slope * a.step() * static_cast<double>(high - low)
                       : leap);
  };
  for (std::size_t n = 0; n < front.size(); ++n) {
    if (!front[n].middle) continue;
    std::size_t high = n, q = n, thin = 0;
    for (; q < front.size() && q - high <= may_miss; ++q)
      if (front[q].middle && (q == n || joins(high, q))) high = q, thin += !front[q].thick;
    if (high - n + 1 > length && static_cast<double>(thin) * a.step() > plates * trunk.scale)
      length = high - n + 1, best_low = n, best_high = high;
    n = high;
  }
  if (static_cast<double>(length) * a.step() < shortest * trunk.scale) return std::nullopt;
  // if it leaves the scan in front or below, its true end is elsewhere
  constexpr double beyond = 10;  // mm
  const Vector3d tip = *front[best_low].middle;
  if (!a.sees(tip - Vector3d(0, 2 * a.step(), 0)) || !a.sees(tip - Vector3d(0, 0, beyond)))
    return std::nullopt;
  return Sternum{*front[best_high].middle, tip,
                 front[best_low].thick || (best_low > 0 && front[best_low - 1].thick)};
}

// Lower end of the sternum's bone near `tip` (mm, patient z), from the area of its sections in the scan
// itself: the end tapers and is too slender for voxel edges. The last section that counts is about 3 mm
// across in an adult.
std::optional<double> sternum_end(const Anatomy& a, const Vector3d& tip, double scale) {
  constexpr double soft = 120, bone = 320, up = 8, down = 12, step = 0.5;  // CT numbers; mm
  const double least = 8 * scale * scale;                                  // mm^2
  const CloseUp view = close_up(*a.source, tip, 30);
  const auto area = [&](double dz) {
    double sum = 0;
    for (double x = -6; x <= 6; x += 1)
      for (double y = -3; y <= 7; y += 1)
        sum += std::clamp((view.at(tip + Vector3d(x, y, dz)) - soft) / (bone - soft), 0.0, 1.0);
    return sum;
  };
  double before = area(up);
  for (double dz = up; dz >= -down && before >= least; dz -= step) {
    const double here = area(dz);
    if (here < least) return tip[2] + dz + step * (least - here) / (before - here);
    before = here;
  }
  return std::nullopt;
}

// Upper end of the manubrium if the rest of the sternum does not show as bone: the highest midline bone well
// in front of the spine, 25 to 95 mm below the neck (in an adult). Clavicles lie beside it, the larynx above.
std::optional<Vector3d> find_notch(const Anatomy& a, const Trunk& trunk, const Vector3d& neck) {
  const auto& g = a.grid();
  const double s = trunk.scale, half = 8 * s;
  for (double z = neck[2] - 25 * s; z > neck[2] - 95 * s; z -= a.step()) {
    const Vector3d column = trunk.spine_at(z);
    const Vector3d index = g.index(Vector3d(trunk.middle(z), column[1], z));
    const auto i = std::lround(index[0]), k = std::lround(index[2]), reach = std::lround(half / a.step());
    Vector3d sum = Vector3d::Zero();
    int count = 0;
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (auto x = i - reach; x <= i + reach; ++x) {
        if (!g.holds(x, j, k) || !a.bone.at(x, j, k)) continue;
        const Vector3d p = g.point(x, j, k);
        const double before = column[1] - p[1];
        if (before > 30 * s && before < 100 * s) sum += p, ++count;
      }
    if (count * a.step() * a.step() > 60 * s * s)  // a manubrium has 16 x 12 mm there
      return Vector3d(sum / count + Vector3d(0, 0, 0.5 * a.step()));
  }
  return std::nullopt;
}

// de Leva (1996), male, Table 4: lengths in mm at stature 1.741 m
constexpr double vertex_to_neck = 242.9, neck_to_xiphion = 242.1, xiphion_to_omphalion = 215.5,
                 omphalion_to_hip = 145.7;
constexpr double neck_to_hip = neck_to_xiphion + xiphion_to_omphalion + omphalion_to_hip;

// highest point of the head, above the neck; flesh near an arm's bones is excluded
std::optional<Landmark> find_vertex(const Anatomy& a, const Limbs& limbs, const Vector3d& neck,
                                    double scale) {
  const auto& g = a.grid();
  // A forearm on the head hides where its flesh ends. The scalp is no thicker than a finger above the skull,
  // which ends at the first slice without bone.
  constexpr double scalp = 12, in_skull = 130;
  Vector3d crown = neck;  // centre of the skull's last slice
  double reach = 130;
  const auto shows_bone = [&](std::int64_t k) {
    Vector3d sum = Vector3d::Zero();
    int count = 0;
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        const Vector3d p = g.point(i, j, k);
        if (a.bone.at(i, j, k) &&
            limbs.territory.owner.at(i, j, k) == static_cast<std::uint8_t>(Limb::axial) &&
            (p - neck).head<2>().norm() < 130 * scale)
          sum += p, ++count;
      }
    if (count > 0) crown = sum / count, reach = 45;
    return count > 0;
  };
  std::int64_t last = std::lround(g.index(neck + Vector3d(0, 0, in_skull * scale))[2]);
  while (last >= 0 && last < g.size[2] && shows_bone(last)) ++last;
  last = std::min(g.size[2] - 1, last + std::lround(scalp * scale / a.step()));
  bool hidden = false;  // by an arm on the head
  for (std::int64_t k = last; k > 0; --k) {
    Vector3d sum = Vector3d::Zero();
    int count = 0;
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        const Vector3d p = g.point(i, j, k);
        if (!a.body.at(i, j, k) || (p - crown).head<2>().norm() > reach * scale) continue;
        const auto owner = static_cast<Limb>(limbs.territory.owner.at(i, j, k));
        if (owner == Limb::arm_left || owner == Limb::arm_right) {
          hidden = true;
          continue;
        }
        sum += p;
        ++count;
      }
    if (count == 0) continue;
    Vector3d vertex = sum / count;
    vertex[2] += 0.5 * a.step();
    // a cut head has a large top section
    if (count * a.step() * a.step() > 5000) return std::nullopt;
    if (vertex[2] < neck[2] + 120 * scale) return std::nullopt;
    // a nod of 15 degrees moves the head's own vertex 40 mm away from its highest point
    constexpr double usual = 25, beside_an_arm = 30;  // mm
    return Landmark{vertex, hidden ? beside_an_arm : usual, 0, "skin: highest point of the head"};
  }
  return std::nullopt;
}

// level of the neck from the shoulders alone, mm, patient z
double neck_above_shoulders(const Trunk& trunk) {
  return 0.5 * (trunk.shoulder[0]->centre[2] + trunk.shoulder[1]->centre[2]) + 68 * trunk.scale;
}

void find_neck(const Anatomy& a, const Trunk& trunk, const Limbs& limbs, Landmarks& marks) {
  const bool hips = trunk.hip[0] && trunk.hip[1], shoulders = trunk.shoulder[0] && trunk.shoulder[1];
  Landmark neck;
  double z = 0;
  if (shoulders) {
    z = neck_above_shoulders(trunk);
    neck.deviation = 20, neck.source = "proportion: above the shoulders";
  } else if (hips) {
    z = 0.5 * (trunk.hip[0]->centre[2] + trunk.hip[1]->centre[2]) + neck_to_hip * trunk.scale;
    neck.deviation = 35, neck.source = "proportion: above the hips";
  } else if (trunk.brain) {
    constexpr double below_brain = 165;
    z = (*trunk.brain)[2] - below_brain * trunk.scale;
    neck.deviation = 20, neck.source = "proportion: below the brain";
  } else {
    return;
  }
  // jaws beside the spine are no ribs: a lone head's first rib lies near the level estimated from the brain
  constexpr double jaw = 45;
  const auto rib = first_rib(a, trunk, z);
  if (rib && (!trunk.brain || *rib < z + jaw * trunk.scale)) {
    // the first rib's neck lies beside the upper half of the first thoracic vertebra
    z = *rib + 7 * trunk.scale;
    neck.deviation = 12, neck.source = "bone: above the first rib";
    constexpr double half_a_body = 5;  // mm: the disc is searched within this standard deviation
    if (const auto disc = disc_near(a, trunk, z, half_a_body)) {
      z = *disc;
      neck.deviation = std::hypot(2.5, 2 * a.over_fine()), neck.source = "bone: disc above the first rib";
    } else if (const auto hidden = disc_between_slices(a, trunk, z)) {
      z = *hidden;
      neck.deviation = 3.5, neck.source = "bone: between slices, by the discs beside";
    }
  }
  if (!level_seen(a, z)) {
    // a lone head ends below the scan's end: nothing in view belongs to the trunk
    if (trunk.brain) marks["neck"] = neck, marks["neck"].point = trunk.spine_at(z);
    return;
  }
  if (const auto vertex = find_vertex(a, limbs, trunk.spine_at(z), trunk.scale)) {
    marks["vertex"] = *vertex;
    if (neck.deviation > 15 && (shoulders || hips)) {
      z = 0.5 * (z + vertex->point[2] - vertex_to_neck * trunk.scale);
      neck.deviation = 12, neck.source = "proportion: between shoulders and vertex";
    }
  }
  neck.point = vertebral_body(a, trunk, z, true);
  marks["neck"] = neck;
  if (const auto tip = spinous_tip(a, neck.point, trunk.scale))
    // thick slices may miss a spinous process and show its neighbour's
    marks["cervicale"] = {*tip, neck.deviation + (a.source->grid.spacing().maxCoeff() > 4 ? 6 : 3), 0,
                          "bone: hindmost point of the seventh cervical vertebra"};
}

// If an arm's elbow was not found although the scan does not cut the arm, the arm may not be separated from
// the trunk's front: the foremost skin and bone there may be the arm's. A stump, which ends above the elbow,
// does not reach the front.
void doubt_front(const Trunk& trunk, const Limbs& limbs, Landmarks& marks) {
  constexpr double arm_thick = 40, shortest = 230;  // mm; of an upper arm about 280
  for (const int side : {left_side, right_side}) {
    const LimbPath& arm = limbs.arm(side);
    if (!arm.present || arm.cut || marks.contains(std::string("elbow") + side_suffix(side))) continue;
    if (is_absent(trunk.absent, "forearm", side_suffix(side)) || arm.length() < shortest * trunk.scale)
      continue;
    for (const char* name : {"omphalion", "asis_left", "asis_right"})
      if (const auto it = marks.find(name); it != marks.end())
        it->second.deviation = std::max(it->second.deviation, arm_thick);
  }
}

}  // namespace

void find_trunk_landmarks(const Anatomy& a, const Trunk& trunk, const Limbs& limbs, Landmarks& marks) {
  const bool hips = trunk.hip[0] && trunk.hip[1];
  if (hips) find_iliac_spines(a, trunk, limbs, marks);
  find_neck(a, trunk, limbs, marks);
  const auto neck = marks.find("neck");
  const bool has_neck = neck != marks.end(), shoulders = trunk.shoulder[0] && trunk.shoulder[1];
  if (!hips && !shoulders) return;
  const double hip_level = hips ? 0.5 * (trunk.hip[0]->centre[2] + trunk.hip[1]->centre[2]) : 0;
  const double top = has_neck    ? neck->second.point[2]
                     : shoulders ? neck_above_shoulders(trunk)
                                 : hip_level + neck_to_hip * trunk.scale;
  const double bottom = hips ? hip_level : top - neck_to_hip * trunk.scale;
  const double length = top - bottom;
  if (!hips) find_iliac_spines_about(a, trunk, limbs, bottom, marks);
  const TrunkFront front(a, trunk, limbs, bottom, top);
  const double spread = has_neck && hips ? 15 : 30;

  // if the scan's side cuts off the skin, the point lies on that side, and only its level is valid
  const auto hidden = [&](const Vector3d& skin) -> std::string {
    return a.sees(skin - Vector3d(0, 2 * a.step(), 0))
               ? ""
               : "; only its level is known, because the skin is out of view";
  };
  double xiphion = bottom + length * (omphalion_to_hip + xiphion_to_omphalion) / neck_to_hip;
  if (const auto sternum = find_sternum(a, trunk, limbs, bottom + 0.45 * length, bottom + 1.0 * length)) {
    Vector3d tip = sternum->tip - Vector3d(0, 0, 0.5 * a.step());
    if (const auto end = sternum_end(a, tip, trunk.scale)) tip[2] = *end;
    // far from the usual level, noise or another bone may pass for the sternum
    constexpr double measured = 4, hidden_end = 12, by_chance = 3;  // mm; mm; standard deviations
    const double off = std::abs(tip[2] - xiphion);
    xiphion = tip[2];
    marks["xiphion"] = {
        tip, std::max(sternum->tip_hidden ? hidden_end : measured, off > by_chance * spread ? off / 2 : 0), 0,
        "bone: lower end of the sternum"};
    if (has_neck)
      marks["suprasternale"] = {sternum->top + Vector3d(0, 0, 0.5 * a.step()), 11, 0,
                                "bone: upper end of the sternum"};
  } else if (level_seen(a, xiphion)) {
    if (const auto notch = has_neck ? find_notch(a, trunk, neck->second.point) : std::nullopt)
      marks["suprasternale"] = {*notch, 11, 0,
                                "bone: highest point in the midline in front of the base of the neck"};
    constexpr double below_skin = 20;  // mm
    if (const auto skin = front.skin_at(xiphion))
      marks["xiphion"] = {*skin + Vector3d(0, below_skin * trunk.scale, 0), spread, 0,
                          "proportion: between neck and hips" + hidden(*skin)};
  }
  const double omphalion =
      bottom + (xiphion - bottom) * omphalion_to_hip / (omphalion_to_hip + xiphion_to_omphalion);
  // standard deviations of the usual level, mm: navels of adults differ, hips out of view are placed by
  // proportion
  constexpr double navels_differ = 25, unseen_hips = 50;
  const double of_xiphion = marks.contains("xiphion") ? marks["xiphion"].deviation : spread;
  const double usual_spread =
      std::hypot(navels_differ * trunk.scale, 0.4 * of_xiphion, hips ? 0 : unseen_hips);
  if (const auto navel = front.navel(bottom + 0.25 * (xiphion - bottom), bottom + 0.62 * (xiphion - bottom),
                                     omphalion, usual_spread)) {
    marks["omphalion"] = *navel;
  } else if (level_seen(a, omphalion)) {
    const auto skin = front.skin_at(omphalion);
    if (skin) marks["omphalion"] = {*skin, spread, 0, "proportion: between xiphion and hips" + hidden(*skin)};
  }
  doubt_front(trunk, limbs, marks);
  for (const auto& [joint, level] : {std::pair{"spine_upper", "xiphion"}, {"spine_lower", "omphalion"}}) {
    const auto it = marks.find(level);
    if (it == marks.end() || !trunk.spine_holds(it->second.point[2])) continue;
    marks[joint] = {vertebral_body(a, trunk, it->second.point[2]), std::max(5.0, it->second.deviation), 0,
                    std::string("bone: middle of the spine at the level of the ") + level};
  }
}

}  // namespace borelli
