#include "segmentation/joints/iliac_spines.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

namespace borelli {
namespace {

using Eigen::Vector3d;

constexpr const char* source = "bone: foremost point of the iliac crest";

// Search box on one side, mm: lateral range (outwards from the hip centre) and range above it.
struct SpineBox {
  std::array<double, 2> x, z;
};

// The foremost bone of the pelvis in a box at `hip`: among the foremost bone voxels of all columns, the mean
// of those within 4 mm of the very foremost. A hand or forearm may lie in front of it; `is_pelvis` keeps it
// out.
template <class IsPelvis>
std::optional<Vector3d> foremost_bone(const Anatomy& a, int side, const Vector3d& hip, const SpineBox& box,
                                      const IsPelvis& is_pelvis) {
  const auto& g = a.grid();
  std::vector<Vector3d> front;
  double best = 1e9;
  for (auto k = std::lround((hip[2] + box.z[0] - g.origin[2]) / a.step());
       k <= std::lround((hip[2] + box.z[1] - g.origin[2]) / a.step()); ++k)
    for (std::int64_t i = 0; i < g.size[0]; ++i) {
      const double lateral = side_sign(side) * (g.origin[0] + a.step() * static_cast<double>(i) - hip[0]);
      if (lateral < box.x[0] || lateral > box.x[1]) continue;
      for (std::int64_t j = 0; j < g.size[1]; ++j) {
        if (!g.holds(i, j, k) || !is_pelvis(i, j, k)) continue;
        front.push_back(g.point(i, j, k));
        best = std::min(best, front.back()[1]);
        break;
      }
    }
  if (front.empty()) return std::nullopt;
  Vector3d where = Vector3d::Zero();
  int count = 0;
  for (const auto& p : front)
    if (p[1] < best + 4) where += p, ++count;
  where /= count;
  where[1] = best - 0.5 * a.step();
  return where;
}

// Distance of one spine from the other's mirror image in the plane midway between the hips, mm.
double unlike(const Trunk& trunk, const Vector3d& left, const Vector3d& right) {
  const Vector3d middle = 0.5 * (trunk.hip[0]->centre + trunk.hip[1]->centre),
                 across = (trunk.hip[0]->centre - trunk.hip[1]->centre).normalized();
  return (left - 2 * (left - middle).dot(across) * across - right).norm();
}

}  // namespace

void find_iliac_spines(const Anatomy& a, const Trunk& trunk, const Limbs& limbs, Landmarks& marks) {
  const double s = trunk.scale;
  // limits path length: the spines are at most 60 mm from bone above the hips that is surely the trunk's
  const auto is_pelvis = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    if (!a.bone.at(i, j, k) || limbs.arm_at(i, j, k)) return false;
    const auto owner = static_cast<Limb>(limbs.territory.owner.at(i, j, k));
    return owner != Limb::none && limbs.territory.length(i, j, k) < 120 * s;
  };
  std::array<std::optional<Vector3d>, 2> spine;
  for (const int side : {left_side, right_side}) {
    const auto n = static_cast<std::size_t>(side);
    const FoundSphere& head = *trunk.hip[n];
    // The spines lie lateral of the hips, by 14 % of the distance between them (Bell 1989). Vessels with
    // contrast lie medial.
    spine[n] = foremost_bone(a, side, head.centre, {{0, 75 * s}, {45 * s, 130 * s}}, is_pelvis);
    if (!spine[n] || (*spine[n])[1] >= head.centre[1] - 15 * s - 0.5 * a.step()) continue;
    // if the scan's end or side hides part of the ilium, its foremost visible point lies elsewhere
    constexpr double usual = 6, hidden = 30, beside = 15;
    const bool cut = head.cut || a.near_edge(*spine[n], beside * s);
    marks[std::string("asis") + side_suffix(side)] = {*spine[n], cut ? hidden : usual, 0, source};
  }
  const auto left = marks.find("asis_left"), right = marks.find("asis_right");
  if (left == marks.end() || right == marks.end()) return;
  // healthy sides agree within a finger's breadth
  constexpr double alike = 30;  // mm
  const double apart = unlike(trunk, left->second.point, right->second.point);
  if (apart < alike * s) return;
  for (Landmark* mark : {&left->second, &right->second}) {
    mark->deviation = std::max(mark->deviation, apart);
    mark->source += unlike_other_side;
  }
  // or the hips are wrong: in children without shoulders in view one was 30 mm off
  if (!trunk.shoulder[0])
    for (const char* hip : {"hip_left", "hip_right", "mid_hip"})
      if (const auto it = marks.find(hip); it != marks.end())
        it->second.deviation = std::max(it->second.deviation, apart);
}

// The ASIS is the foremost point of the wing, and bone recedes above and below it. A foremost point at the
// end of the box or of the scan is therefore none.
void find_iliac_spines_about(const Anatomy& a, const Trunk& trunk, const Limbs& limbs, double level,
                             Landmarks& marks) {
  const double s = trunk.scale;
  // Without hips, and with the sacroiliac gap blocking the paths along bones, size distinguishes the pelvis
  // from a hand's bones.
  const double large = 40e3 * std::pow(s, 3);  // mm^3; a hand's bones together have about 20e3
  const Regions bones = connected_regions(a.bone, 6);
  const auto is_pelvis = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    if (!a.bone.at(i, j, k) || limbs.arm_at(i, j, k)) return false;
    const auto number = static_cast<std::size_t>(bones.number.at(i, j, k));
    return limbs.territory.owner.at(i, j, k) != static_cast<std::uint8_t>(Limb::none) ||
           static_cast<double>(bones.list[number - 1].voxels) * a.grid().voxel_volume() > large;
  };
  std::array<std::optional<Vector3d>, 2> spine;
  for (const int side : {left_side, right_side}) {
    const Vector3d hip(trunk.middle(level) + side_sign(side) * 86 * s, 0, level);
    auto& place = spine[static_cast<std::size_t>(side)];
    place = foremost_bone(a, side, hip, {{-25 * s, 75 * s}, {20 * s, 150 * s}}, is_pelvis);
    if (!place) return;
    const double above = (*place)[2] - level;
    if (above < 25 * s || above > 140 * s || a.near_edge(*place, 10)) return;
    if ((*place)[1] > trunk.spine_at((*place)[2])[1] - 30 * s) return;
  }
  if (std::abs((*spine[0])[2] - (*spine[1])[2]) > 30 * s) return;
  constexpr double usual = 12;  // mm: without hips the assumed place may be 30 mm off
  for (const int side : {left_side, right_side})
    marks[std::string("asis") + side_suffix(side)] = {*spine[static_cast<std::size_t>(side)], usual, 0,
                                                      source};
}

}  // namespace borelli
