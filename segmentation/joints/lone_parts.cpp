#include "segmentation/joints/lone_parts.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "segmentation/body/bone_edges.hpp"
#include "segmentation/grid/morphology.hpp"
#include "segmentation/joints/joints_along_path.hpp"
#include "segmentation/joints/limbs.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

// Centres (mm, LPS) of sections of bone that may be femora, in the work grid's uppermost slice that shows
// body; largest first. Limits in mm^2.
std::vector<Vector3d> sections_at_top(const Anatomy& a) {
  constexpr double least = 250, most = 2500;
  const auto& g = a.grid();
  const auto slice = static_cast<std::size_t>(g.size[0] * g.size[1]);
  const auto last = std::find(a.body.voxels.rbegin(), a.body.voxels.rend(), 1);
  const auto k = static_cast<std::int64_t>(static_cast<std::size_t>(a.body.voxels.rend() - last - 1) / slice);
  Mask bone{g, {}};
  bone.grid.size[2] = 1;
  const auto first = a.bone.voxels.begin() + static_cast<std::ptrdiff_t>(g.offset(0, 0, k));
  bone.voxels.assign(first, first + static_cast<std::ptrdiff_t>(slice));
  const Regions pieces = connected_regions(bone, 6);
  std::vector<Vector3d> out;
  for (const Region& piece : pieces.list) {
    const double area = static_cast<double>(piece.voxels) * a.step() * a.step();
    const Vector3d centre = g.point(piece.centre + Vector3d(0, 0, static_cast<double>(k)));
    if (area >= least && area <= most && a.near_edge(centre, 3 * a.step())) out.push_back(centre);
  }
  return out;
}

// Body size from the shanks of two legs; 0 if these are no legs.
double size_of_legs(const Limbs& limbs) {
  constexpr double knee_to_ankle = 434, condyle = 22, least = 0.6, most = 1.3;  // mm of an adult
  double sum = 0;
  for (const int side : {left_side, right_side}) {
    const LimbPath& path = limbs.leg(side);
    if (!path.present) return 0;
    double scale = 1;
    for (int round = 0; round < 4; ++round) {
      const JointsAlongPath joints = leg_joints(path, scale);
      if (joints.end == 0) return 0;
      scale = (joints.end - joints.middle) / (knee_to_ankle - condyle);
      if (scale < least || scale > most) return 0;
    }
    sum += 0.5 * scale;
  }
  return sum;
}

void find_legs(const Anatomy& a, Trunk& trunk) {
  constexpr double nearest = 60, farthest = 450;  // between the femora, mm
  constexpr std::size_t most = 4;
  const auto sections = sections_at_top(a);
  for (std::size_t p = 0; p < std::min(most, sections.size()); ++p)
    for (std::size_t q = 0; q < p; ++q) {
      const double apart = std::abs(sections[p][0] - sections[q][0]);
      if (apart < nearest || apart > farthest) continue;
      Trunk legs = trunk;
      legs.femur[left_side] = sections[sections[p][0] > sections[q][0] ? p : q];
      legs.femur[right_side] = sections[sections[p][0] > sections[q][0] ? q : p];
      legs.scale = size_of_legs(trace_limbs(a, legs));
      if (legs.scale == 0) continue;
      trunk = legs;
      return;
    }
}

struct Brain {
  Vector3d centre;
  double radius;  // mean distance to the skull, mm
};

// Soft tissue without fat and air, enclosed by bone at a brain's distance. Belly and chest contain fat or
// air, and their bones stand apart.
std::optional<Brain> find_brain(const Anatomy& a) {
  constexpr float deep = 35;                       // mm off bone
  constexpr double least_core = 10e3;              // mm^3 deeper than that
  constexpr double nearest = 30, farthest = 130;   // mm from its middle to the skull
  constexpr double all_soft = 0.95, round = 0.85;  // least fractions: soft tissue on rays; hits
  constexpr double most_open = 0.4;                // largest fraction of rays that leave the scan
  constexpr int soft_from = -20, soft_to = 120;    // CT numbers
  const auto& g = a.grid();
  Mask core{g, std::vector<std::uint8_t>(g.count())};
  for (std::size_t o = 0; o < g.count(); ++o) core.voxels[o] = a.body.voxels[o] && a.off_bone[o] > deep;
  const Regions pieces = connected_regions(core, 6);
  for (const Region& piece : pieces.list) {
    if (static_cast<double>(piece.voxels) * g.voxel_volume() < least_core) break;  // the largest come first
    const Vector3d centre = g.point(piece.centre);
    int hits = 0, open = 0, all = 0, soft = 0, passed = 0;
    double radius_sum = 0;
    for (const Vector3d& u : even_directions(300)) {
      ++all;
      double r = 0;
      int soft_here = 0, here = 0;
      bool hit = false, left = false;
      for (; r < farthest && !hit; r += a.step()) {
        const Vector3d index = g.index(centre + r * u);
        const auto i = std::lround(index[0]), j = std::lround(index[1]), k = std::lround(index[2]);
        if (!g.holds(i, j, k) || !a.scan.seen.at(i, j, k)) {
          left = true;
          break;
        }
        hit = a.bone.at(i, j, k);
        const int hu = a.scan.hu.at(i, j, k);
        ++here, soft_here += hu >= soft_from && hu <= soft_to;
      }
      if (left) {
        ++open;
      } else if (hit && r > nearest) {
        ++hits, radius_sum += r, soft += soft_here, passed += here;
      }
    }
    if (open < most_open * all && hits > round * (all - open) && soft > all_soft * passed)
      return Brain{centre, radius_sum / hits};
  }
  return std::nullopt;
}

}  // namespace

void find_lone_parts(const Anatomy& a, Trunk& trunk) {
  find_legs(a, trunk);
  if (trunk.femur[0]) return;
  const auto brain = find_brain(a);
  if (!brain) return;
  constexpr double usual = 68, under_skull = 60;  // mm: an adult's brain's radius; to the column's upper end
  trunk.brain = brain->centre;
  trunk.scale = std::clamp(brain->radius / usual, 0.8, 1.15);
  constexpr double aside = 30;  // mm: jaws contain as much bone as the spine
  find_spine(a, brain->centre[0], a.grid().origin[2] + a.step(), brain->centre[2] - under_skull * trunk.scale,
             aside, 0, trunk);
}

}  // namespace borelli
