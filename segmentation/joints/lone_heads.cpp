#include "segmentation/joints/lone_heads.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <optional>
#include <string>

#include "segmentation/joints/likeliest_head.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

double middle_x(const std::array<std::optional<FoundSphere>, 2>& pair) {
  return 0.5 * (pair[0]->centre[0] + pair[1]->centre[0]);
}

struct Cuboid {
  Vector3d low, high;  // mm
  Cuboid mirrored(double middle) const {
    Cuboid box = *this;
    box.low[0] = 2 * middle - high[0], box.high[0] = 2 * middle - low[0];
    return box;
  }
};

struct Content {
  double bone = 0, body = 0, shown = 0;  // mm^3; mm^3; share of the box
};

Content content_of(const Anatomy& a, const Cuboid& box) {
  const Grid &g = a.grid(), &scan = a.source->grid;
  const Vector3d low = g.index(box.low), high = g.index(box.high);
  double all = 0, shown = 0, bone = 0, body = 0;
  for (auto k = std::lround(low[2]); k <= std::lround(high[2]); ++k)
    for (auto j = std::lround(low[1]); j <= std::lround(high[1]); ++j)
      for (auto i = std::lround(low[0]); i <= std::lround(high[0]); ++i) {
        ++all;
        if (g.holds(i, j, k)) {
          shown += a.scan.seen.at(i, j, k);
          bone += a.bone.at(i, j, k);
          body += a.body.at(i, j, k);
        } else {  // the scan also covers air outside the work grid
          const Vector3d at = scan.index(
              g.point(Vector3d(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k))));
          shown += scan.holds(std::lround(at[0]), std::lround(at[1]), std::lround(at[2]));
        }
      }
  return {bone * g.voxel_volume(), body * g.voxel_volume(), all > 0 ? shown / all : 0};
}

// True if `own` contains a limb's bone, while its mirror image is in view and contains less than `hardly`
// times as much.
bool limb_is_gone(const Anatomy& a, const Cuboid& own, double middle, double hardly) {
  constexpr double least = 15e3, in_view = 0.6;  // mm^3
  const Content here = content_of(a, own), there = content_of(a, own.mirrored(middle));
  return here.bone > least && there.bone < hardly * here.bone && there.shown > in_view;
}

Cuboid cuboid_of(const Vector3d& a, const Vector3d& b) { return {a.cwiseMin(b), a.cwiseMax(b)}; }

// True if the other side has no thigh bone below its hip, or no trochanter beside it. Every stump of a thigh
// has a trochanter. The bone there differs by at most 27 % between the two sides of ten warped bodies.
bool leg_is_gone(const Anatomy& a, const FoundSphere& hip, double middle, int side) {
  constexpr double near_middle = 15, outside = 120, deep = 100, below = 90, far_below = 300;
  constexpr double near_head = 20, beside = 100, behind = 70, above = 20, lowest = 70;
  const Vector3d c = hip.centre;
  const double out = side_sign(side);
  return limb_is_gone(a,
                      cuboid_of(Vector3d(middle + out * near_middle, c[1] - deep, c[2] - far_below),
                                Vector3d(c[0] + out * outside, c[1] + deep, c[2] - below)),
                      middle, 0.1) ||
         limb_is_gone(a,
                      cuboid_of(Vector3d(c[0] + out * near_head, c[1] - behind, c[2] - lowest),
                                Vector3d(c[0] + out * beside, c[1] + behind, c[2] + above)),
                      middle, 0.25);
}

// True if, at some level, the scan shows much less flesh beside and below the other head of a pair than
// beside and below the head of `side`. Both heads may be false, up to 100 mm above the hips: if one femoral
// head is missing, two other round bones may pass for a pair.
bool may_lack_other_leg(const Anatomy& a, const std::array<std::optional<FoundSphere>, 2>& pair, int side) {
  constexpr double near_head = 20, beside = 100, behind = 70, lowest = 150, layer = 50;  // mm
  constexpr double in_view = 0.5, smaller = 0.35;
  for (double below = layer; below <= lowest; below += layer) {
    const auto region = [&](int of) {
      const Vector3d c = pair[static_cast<std::size_t>(of)]->centre;
      const double out = side_sign(of);
      return content_of(a, cuboid_of(Vector3d(c[0] + out * near_head, c[1] - behind, c[2] - below),
                                     Vector3d(c[0] + out * beside, c[1] + behind, c[2] - below + layer)));
    };
    const Content own = region(side), other = region(1 - side);
    if (std::min(own.shown, other.shown) > in_view && other.body < smaller * own.body) return true;
  }
  return false;
}

// Compares the regions of the two arms below the humeral heads and outside the ribs.
bool arm_is_gone(const Anatomy& a, const Vector3d& head, double middle, int side, double hardly) {
  constexpr double inside = 5, outside = 100, deep = 100, below = 60, far_below = 330;
  // a raised arm does not lie beside the chest
  constexpr double inwards = 60, above = 60, far_above = 200, most = 5e3, in_view = 0.6;  // mm, mm^3
  const Content raised = content_of(
      a, cuboid_of(Vector3d(head[0] - side_sign(side) * inwards, head[1] - deep, head[2] + above),
                   Vector3d(head[0] + side_sign(side) * outside, head[1] + deep, head[2] + far_above))
             .mirrored(middle));
  if (raised.bone > most || raised.shown < in_view) return false;
  return limb_is_gone(
      a,
      cuboid_of(Vector3d(head[0] - side_sign(side) * inside, head[1] - deep, head[2] - far_below),
                Vector3d(head[0] + side_sign(side) * outside, head[1] + deep, head[2] - below)),
      middle, hardly);
}

// Why one hip is searched alone.
enum class Reason {
  no_pair,      // no pair of hips was found
  absent_leg,   // the user names the other leg as absent
  uneven_pair,  // a pair was found, but flesh is missing beside one of its heads
};

// The midsagittal plane of a body with this hip, x in mm.
double middle_beside(const FoundSphere& hip, int side, const Trunk& trunk) {
  return trunk.shoulder[0] && trunk.shoulder[1] ? middle_x(trunk.shoulder)
                                                : hip.centre[0] - side_sign(side) * hips_half;
}

std::optional<FoundSphere> hip_of(int side, const Anatomy& a, const HeadsInBody& body, RoundHeads& candidates,
                                  const Trunk& trunk, Reason reason) {
  constexpr double lowest = 330, highest = 650, nearest = 50, farthest = 130, deep = 150;  // mm
  const double out = side_sign(side);
  return likeliest_head(a, body, candidates, [&](const FoundSphere& ball) {
    if (!body.below_lungs(ball.centre[2])) return false;
    const double middle = middle_beside(ball, side, trunk);
    if (trunk.shoulder[0] && trunk.shoulder[1]) {
      const Vector3d d = 0.5 * (trunk.shoulder[0]->centre + trunk.shoulder[1]->centre) - ball.centre;
      const double aside = -out * d[0];
      if (d[2] < lowest || d[2] > highest || aside < nearest || aside > farthest || std::abs(d[1]) > deep)
        return false;
    } else {
      const Vector3d other = mirror_image(ball, middle).centre;
      const Vector3d &left = out > 0 ? ball.centre : other, &right = out > 0 ? other : ball.centre;
      if (!(reason == Reason::uneven_pair ? body.deep_below_lungs(left, right) : body.near_hips(left, right)))
        return false;
    }
    return (reason == Reason::absent_leg ? body.below_flank(ball.centre)
                                         : leg_is_gone(a, ball, middle, side)) &&
           body.on_femur(ball, side);
  });
}

}  // namespace

void find_lone_hip(const Anatomy& a, const HeadsInBody& body, RoundHeads& candidates, Trunk& trunk) {
  for (const int side : {left_side, right_side}) {
    const auto n = static_cast<std::size_t>(side), other = 1 - n;
    if (is_absent(trunk.absent, "thigh", side_suffix(side))) continue;
    Reason reason = Reason::no_pair;
    if (is_absent(trunk.absent, "thigh", side_suffix(1 - side)))
      reason = Reason::absent_leg;
    else if (trunk.hip[0] && trunk.hip[1]) {
      if (!may_lack_other_leg(a, trunk.hip, side)) continue;
      reason = Reason::uneven_pair;
    } else if (!(trunk.shoulder[0] && trunk.shoulder[1]))
      continue;  // a single hip is hard to distinguish from other round bone
    const auto hip = hip_of(side, a, body, candidates, trunk, reason);
    if (!hip) continue;
    trunk.hip[n] = *hip, trunk.hip[other] = mirror_image(*hip, middle_beside(*hip, side, trunk));
    trunk.no_leg[other] = true;
    return;
  }
}

void find_lone_shoulder(const Anatomy& a, const HeadsInBody& body, RoundHeads& candidates, Trunk& trunk) {
  if (!trunk.hip[0] || !trunk.hip[1]) return;
  const double middle = middle_x(trunk.hip);
  for (const int side : {left_side, right_side}) {
    const auto n = static_cast<std::size_t>(side), other = 1 - n;
    const bool stated = is_absent(trunk.absent, "upper_arm", side_suffix(1 - side));
    if (is_absent(trunk.absent, "upper_arm", side_suffix(side))) continue;
    if (!stated && trunk.shoulder[n]) {
      // a false pair of heads lies farther medial, among the ribs
      Vector3d outer = trunk.shoulder[n]->centre;
      const double aside = std::max(std::abs(trunk.shoulder[0]->centre[0] - middle),
                                    std::abs(trunk.shoulder[1]->centre[0] - middle));
      outer[0] = middle + side_sign(side) * aside;
      if (!arm_is_gone(a, outer, middle, side, 0.5)) continue;
    }
    const auto shoulder = find_shoulder_over(*trunk.hip[n], side, a, body, candidates);
    // a true pair has two heads, however short the other arm's stump
    constexpr double same = 10;  // mm
    if (shoulder && !stated && trunk.shoulder[n] &&
        (trunk.shoulder[n]->centre - shoulder->centre).norm() < same)
      return;
    if (!shoulder || (!stated && !arm_is_gone(a, shoulder->centre, middle, side, 0.1))) continue;
    trunk.shoulder[n] = *shoulder, trunk.shoulder[other] = mirror_image(*shoulder, middle);
    trunk.no_arm[other] = true;
    return;
  }
}

std::array<bool, 2> sides_without_leg(const Trunk& trunk) {
  return {trunk.no_leg[0] || is_absent(trunk.absent, "thigh", "_left"),
          trunk.no_leg[1] || is_absent(trunk.absent, "thigh", "_right")};
}

AbsentParts gone_parts(const Trunk& trunk) {
  AbsentParts gone = trunk.absent;
  for (const int side : {left_side, right_side}) {
    const std::string at = side_suffix(side);
    const auto lacks = [&](std::initializer_list<const char*> limb) {
      for (const char* part : limb) gone[static_cast<std::size_t>(part_label(part + at))] = true;
    };
    if (trunk.no_leg[static_cast<std::size_t>(side)]) lacks({"thigh", "shank", "foot"});
    if (trunk.no_arm[static_cast<std::size_t>(side)]) lacks({"upper_arm", "forearm", "hand"});
  }
  return gone;
}

void put_middle_of_hips(const Trunk& trunk, Landmarks& marks) {
  constexpr double alike = 5;  // mm, sides of one body
  for (const int side : {left_side, right_side})
    if (const auto hip = marks.find(std::string("hip") + side_suffix(1 - side));
        trunk.no_leg[static_cast<std::size_t>(side)] && hip != marks.end())
      marks["mid_hip"] = {0.5 * (trunk.hip[0]->centre + trunk.hip[1]->centre),
                          std::hypot(hip->second.deviation, alike), 0,
                          "middle of the hip centres, one of them mirrored"};
}

void settle_lone_heads(Trunk& trunk) {
  if (trunk.spine.empty()) return;
  for (const std::size_t gone : {0, 1}) {
    const std::size_t there = 1 - gone;
    if (trunk.no_leg[gone] && trunk.hip[there]) {
      // uses the lumbar levels: beside the sacrum an ilium contains as much bone
      constexpr double lowest = 120, highest = 240;  // mm over the hips
      const double hip = trunk.hip[there]->centre[2];
      double sum = 0, levels = 0;
      for (const Vector3d& p : trunk.spine)
        if (p[2] > hip + lowest && p[2] < hip + highest) sum += p[0], ++levels;
      if (levels > 0) trunk.hip[gone] = mirror_image(*trunk.hip[there], sum / levels);
    }
    if (trunk.no_arm[gone] && trunk.shoulder[there])
      trunk.shoulder[gone] =
          mirror_image(*trunk.shoulder[there], trunk.spine_at(trunk.shoulder[there]->centre[2])[0]);
  }
}

}  // namespace borelli
