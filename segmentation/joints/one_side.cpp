#include "segmentation/joints/one_side.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "segmentation/joints/likeliest_head.hpp"
#include "segmentation/vocabulary/parts.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

// standard deviation of the midline from an adult's hips_half, mm (40 phantoms: 4 mm rms, at most 8.8)
constexpr double middle_by_hip = 7;

double middle_of(const Trunk& trunk) { return 0.5 * (trunk.hip[0]->centre[0] + trunk.hip[1]->centre[0]); }

}  // namespace

void find_one_side(const Anatomy& a, const HeadsInBody& body, RoundHeads& candidates, Trunk& trunk) {
  for (const int side : {left_side, right_side}) {
    const auto n = static_cast<std::size_t>(side), other = 1 - n;
    const double outwards = side_sign(side);
    const auto hip = likeliest_head(a, body, candidates, [&](const FoundSphere& ball) {
      return body.cut_beside(ball.centre[0] - outwards * hips_half, side) &&
             body.below_lungs(ball.centre[2]) && body.below_flank(ball.centre) && body.on_femur(ball, side);
    });
    if (!hip) continue;
    const auto shoulder = find_shoulder_over(*hip, side, a, body, candidates);
    if (!shoulder) continue;
    const double size = (shoulder->centre[2] - hip->centre[2]) / hip_to_shoulder;
    const double middle = hip->centre[0] - outwards * hips_half * size;
    trunk.hip[n] = *hip, trunk.hip[other] = mirror_image(*hip, middle);
    trunk.shoulder[n] = *shoulder, trunk.shoulder[other] = mirror_image(*shoulder, middle);
    trunk.only_side = side;
    trunk.middle_off = middle_by_hip;
    return;
  }
}

void find_one_shoulder(const Anatomy& a, const HeadsInBody& body, RoundHeads& candidates, Trunk& trunk) {
  const double middle = middle_of(trunk);
  for (const int side : {left_side, right_side}) {
    const auto n = static_cast<std::size_t>(side), other = 1 - n;
    const auto shoulder = find_shoulder_over(*trunk.hip[n], side, a, body, candidates);
    if (!shoulder) continue;
    FoundSphere image = mirror_image(*shoulder, middle);
    image.cut = true;
    // otherwise the pair would have been found
    if (a.near_edge(shoulder->centre, shoulder->radius) || !a.near_edge(image.centre, image.radius)) continue;
    trunk.shoulder[n] = *shoulder, trunk.shoulder[other] = image;
    return;
  }
}

void settle_middle(const Anatomy& a, Trunk& trunk) {
  if (!trunk.only_side || trunk.spine.empty()) return;
  constexpr double beside = 35, half = 8, in_view = 0.9;  // mm from the column; fraction of its levels
  double sum = 0, shows = 0, half_shows = 0;
  const auto n = static_cast<std::size_t>(*trunk.only_side), other = 1 - n;
  for (const Vector3d& p : trunk.spine) {
    const Vector3d inwards = p - Vector3d(side_sign(*trunk.only_side) * beside, 0, 0);
    sum += p[0], shows += a.holds(a.scan.seen, inwards);
  }
  const double levels = static_cast<double>(trunk.spine.size());
  if (shows >= in_view * levels) {
    const double middle = sum / levels;
    trunk.hip[other] = mirror_image(*trunk.hip[n], middle);
    trunk.shoulder[other] = mirror_image(*trunk.shoulder[n], middle);
    trunk.middle_off = 0;
  } else {
    for (Vector3d& p : trunk.spine) {
      p[0] = middle_of(trunk);
      half_shows += a.holds(a.scan.seen, p + Vector3d(side_sign(*trunk.only_side) * half, 0, 0));
    }
    trunk.column_in_view = half_shows >= in_view * levels;
  }
}

void mirror_sides(const Trunk& trunk, const Limbs& limbs, Landmarks& marks) {
  if (!trunk.only_side) return;
  constexpr double alike = 5;  // mm, sides of one body
  const double middle = middle_of(trunk);
  const std::string own = side_suffix(*trunk.only_side), other = side_suffix(1 - *trunk.only_side);
  const bool arm = limbs.arm(1 - *trunk.only_side).present;
  for (const std::string stem : {"hip", "asis", "psis", "shoulder"}) {
    marks.erase(stem + other);
    const auto it = marks.find(stem + own);
    // with the midline uncertain by more, the other side's cuts would take from this side
    if (it == marks.end() || trunk.middle_off > 0 || (stem == "shoulder" && !arm)) continue;
    Landmark mark = it->second;
    mark.point[0] = 2 * middle - mark.point[0];
    mark.deviation = std::hypot(mark.deviation, alike);
    mark.source = "mirror image of the other side's";
    marks[stem + other] = mark;
  }
  if (const auto hip = marks.find("hip" + own); hip != marks.end())
    marks["mid_hip"] = {Vector3d(middle, hip->second.point[1], hip->second.point[2]),
                        std::hypot(hip->second.deviation, trunk.middle_off), 0,
                        "middle of the hip centres, one of them mirrored"};
}

void put_in_middle(const Trunk& trunk, Landmarks& marks) {
  if (!trunk.only_side || trunk.middle_off == 0) return;
  const double middle = middle_of(trunk);
  for (const char* name : {"vertex", "cervicale", "suprasternale"})
    if (const auto it = marks.find(name);
        it != marks.end() && std::abs(it->second.point[0] - middle) > 2 * trunk.middle_off)
      marks.erase(it);  // foremost or highest of what is in view, but not in the midline
  for (const char* joint : {"neck", "spine_upper", "spine_lower"})
    if (const auto it = marks.find(joint); it != marks.end()) it->second.point[0] = middle;
  constexpr double unseen = 20;  // mm: error of levels and depths without a spine in view
  for (const char* name :
       {"neck", "spine_upper", "spine_lower", "vertex", "cervicale", "suprasternale", "xiphion", "omphalion"})
    if (const auto it = marks.find(name); it != marks.end()) {
      it->second.deviation = std::hypot(it->second.deviation, trunk.middle_off);
      if (trunk.column_in_view) continue;
      it->second.deviation = std::hypot(it->second.deviation, unseen);
      it->second.source = "proportion: the midline is not in view";
    }
}

void mirror_legs(const Anatomy& a, const Trunk& trunk, const Limbs& limbs, Volume<std::uint8_t>& owner) {
  // the same holds for flesh: the midline must be known to a centimetre to separate the legs
  if (!trunk.only_side || trunk.middle_off > 0 || limbs.leg(1 - *trunk.only_side).present) return;
  const auto& g = a.grid();
  const double outwards = side_sign(*trunk.only_side), middle = middle_of(trunk);
  const auto twin = [&](std::uint8_t label) -> std::uint8_t {
    const std::string name(parts[label].name), own = side_suffix(*trunk.only_side);
    if (!name.ends_with(own)) return label;
    return static_cast<std::uint8_t>(
        part_label(name.substr(0, name.size() - own.size()) + side_suffix(1 - *trunk.only_side)));
  };
  const auto of_leg = [](std::uint8_t label) { return label >= part_label("thigh_left"); };
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        const double x = g.origin[0] + a.step() * static_cast<double>(i);
        auto& label = owner.at(i, j, k);
        if (!label || (x - middle) * outwards > 0) continue;
        const auto image = std::lround((2 * middle - x - g.origin[0]) / a.step());
        const std::uint8_t across = g.holds(image, j, k) ? owner.at(image, j, k) : std::uint8_t{0};
        if (of_leg(across) || (of_leg(label) && across))
          label = twin(across);
        else if (of_leg(label))
          label = twin(label);
      }
}

}  // namespace borelli
