#include "segmentation/joints/limb_lengths.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace borelli {

bool is_doubted(const Landmark& mark) {
  return mark.source.ends_with(unlike_other_side) || mark.source.ends_with(unlike_body);
}

void raise_deviation(const std::string& joint, const std::string& side, double least, Landmarks& marks) {
  for (const char* end : {"", "_medial", "_lateral"})
    if (const auto mark = marks.find(joint + end + side); mark != marks.end())
      mark->second.deviation = std::max(mark->second.deviation, least);
}

namespace {

struct Length {
  const char *from, *to;
  bool arms;
  double usual;  // de Leva (1996), male, Table 4, mm
};
constexpr std::array<Length, 4> lengths{{{"hip", "knee", false, 422.2},
                                         {"knee", "ankle", false, 434.0},
                                         {"shoulder", "elbow", true, 281.7},
                                         {"elbow", "wrist", true, 268.9}}};

// Marks the joint at a limb's far end as doubtful.
void doubt(const std::string& joint, int side, double by, std::string_view why, Landmarks& marks) {
  raise_deviation(joint, side_suffix(side), by, marks);
  marks.at(joint + side_suffix(side)).source += why;
}

// A limb's length on one side, and the joints at its ends.
struct Side {
  const Landmark* from = nullptr;
  const Landmark* to = nullptr;
  double length() const { return (to->point - from->point).norm(); }
  double variance() const { return from->deviation * from->deviation + to->deviation * to->deviation; }
  // a proportion was copied from the other side, so it cannot be compared
  bool measured() const { return from && to && !to->source.starts_with("proportion") && !is_doubted(*from); }
};

}  // namespace

void place_cut_ankles(const Trunk& trunk, const Limbs& limbs, Landmarks& marks) {
  for (const int side : {left_side, right_side}) {
    const std::string at = side_suffix(side), other = side_suffix(1 - side);
    const LimbPath& path = limbs.leg(side);
    const auto knee = marks.find("knee" + at), far_knee = marks.find("knee" + other),
               far_ankle = marks.find("ankle" + other);
    if (is_absent(trunk.absent, "foot", at)) continue;
    if (!path.present || knee == marks.end() || marks.contains("ankle" + at) || far_knee == marks.end() ||
        far_ankle == marks.end())
      continue;
    const double length = (far_ankle->second.point - far_knee->second.point).norm();
    bool past_knee = false, cut = false;
    for (std::size_t n = 0; n < path.points.size(); ++n) {
      const double r = (path.points[n] - knee->second.point).norm();
      past_knee = past_knee || r < 40;
      if (!past_knee) continue;
      cut = cut || path.at_edge[n];
      if (r < length) continue;
      // left and right lengths differ by about 2 %; the path stays within the visible part of the bones
      constexpr double within = 15;
      if (cut)
        marks["ankle" + at] = {path.points[n], std::hypot(0.02 * length, within), 0,
                               "proportion: the other leg's length along the shank"};
      break;
    }
  }
}

void doubt_unlike_lengths(const Trunk& trunk, const Limbs& limbs, Landmarks& marks, bool large_voxels) {
  constexpr double sides_differ = 0.03;  // of a length
  // relative to de Leva's male at this size: his women and phantoms drawn from both have .81 to 1.11
  constexpr double shortest = 0.75, longest = 1.2;
  // forearm relative to the upper arm, if only that gives its length, or if the arm is cut (noise in a cut
  // forearm passes for a wrist's gap): .87 to 1.13 in phantoms
  constexpr std::array<double, 2> of_arm{0.8, 1.2}, of_cut_arm{0.85, 1.15};
  constexpr double surer = 1.5;  // ratio of deviations
  const bool size_is_told = trunk.hip[0] && trunk.hip[1] && trunk.shoulder[0] && trunk.shoulder[1];
  std::array<Side, 2> before, side;
  for (const Length& limb : lengths) {
    before = side;
    side = {};
    for (const int n : {left_side, right_side}) {
      const auto from = marks.find(limb.from + std::string(side_suffix(n))),
                 to = marks.find(limb.to + std::string(side_suffix(n)));
      if (from != marks.end() && to != marks.end())
        side[static_cast<std::size_t>(n)] = {&from->second, &to->second};
    }
    const auto by_arm = [&](int n) {
      return &limb == &lengths[3] && before[static_cast<std::size_t>(n)].measured() &&
             (!size_is_told || limbs.arm(n).cut);
    };
    const auto usual = [&](int n) {  // 0: unknown
      if (by_arm(n)) return limb.usual / lengths[2].usual * before[static_cast<std::size_t>(n)].length();
      return size_is_told ? limb.usual * trunk.scale : 0;
    };
    const auto unlikely = [&](int n) {
      const double length = side[static_cast<std::size_t>(n)].length(), expected = usual(n);
      const auto [least, most] = !by_arm(n)         ? std::array{shortest, longest}
                                 : limbs.arm(n).cut ? of_cut_arm
                                                    : of_arm;
      return expected > 0 && (length < least * expected || length > most * expected);
    };
    if (side[0].measured() && side[1].measured()) {
      const double apart = std::abs(side[0].length() - side[1].length());
      const double longer = std::max(side[0].length(), side[1].length());
      if (apart > sides_differ * longer + std::sqrt(side[0].variance() + side[1].variance())) {
        const double v0 = side[0].variance(), v1 = side[1].variance();
        const bool odd0 = unlikely(0), odd1 = unlikely(1);
        bool doubt0 = true, doubt1 = true;
        if (!large_voxels && !(limb.arms && limbs.arms_meet)) {
          if (v0 > surer * surer * v1)
            doubt1 = false;
          else if (v1 > surer * surer * v0)
            doubt0 = false;
          else if (odd0 != odd1)
            doubt0 = odd0, doubt1 = odd1;
        }
        if (doubt0) doubt(limb.to, left_side, apart, unlike_other_side, marks);
        if (doubt1) doubt(limb.to, right_side, apart, unlike_other_side, marks);
        continue;
      }
    }
    for (const int n : {left_side, right_side}) {
      const Side& s = side[static_cast<std::size_t>(n)];
      if (s.measured() && unlikely(n)) doubt(limb.to, n, std::abs(s.length() - usual(n)), unlike_body, marks);
    }
  }
}

}  // namespace borelli
