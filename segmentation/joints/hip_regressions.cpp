#include "segmentation/joints/hip_regressions.hpp"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <string>
#include <string_view>

#include "segmentation/joints/limb_lengths.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

struct Named {
  HipRegression regression;
  const char* name;
};
// the regression with the most inputs comes first
constexpr std::array<Named, 4> all{{{HipRegression::harrington, "Harrington 2007"},
                                    {HipRegression::hara, "Hara 2016"},
                                    {HipRegression::harrington_width, "Harrington 2007 by pelvis width"},
                                    {HipRegression::bell, "Bell 1989"}}};

bool is_regression(const Landmark& landmark) { return landmark.source.starts_with("regression"); }

// error of a regressed centre against the imaged head, mm (Mantovani 2016)
constexpr double seen_mean = 12.3, seen_deviation = 5.9;

struct Pelvis {
  PelvisSize size;
  Vector3d origin;
  Eigen::Matrix3d axes;  // X forward, Y up, Z right
  bool tilt_seen = false;
};

Pelvis pelvis_of(const Landmarks& marks, const Vector3d& left, const Vector3d& right) {
  Pelvis pelvis;
  pelvis.size.width = (left - right).norm();
  pelvis.origin = 0.5 * (left + right);
  const Vector3d z = (right - left).normalized();
  Vector3d x;
  const auto back_left = marks.find("psis_left"), back_right = marks.find("psis_right");
  if (back_left != marks.end() && back_right != marks.end()) {
    const Vector3d back = 0.5 * (back_left->second.point + back_right->second.point);
    x = pelvis.origin - back;
    pelvis.size.depth = x.norm();
    pelvis.tilt_seen = true;
  } else {
    const auto neck = marks.find("neck");
    // the ASIS lie in front of the line from neck to hips, so that line gives only the sideways lean
    Vector3d up = neck == marks.end() ? Vector3d::UnitZ() : Vector3d(neck->second.point - pelvis.origin);
    up[1] = 0;
    x = up.cross(z);
  }
  x = (x - x.dot(z) * z).normalized();
  pelvis.axes << x, z.cross(x), z;
  double legs = 0;
  int count = 0;
  for (const auto& [spine, ankle] :
       {std::pair{left, marks.find("medial_malleolus_left")}, {right, marks.find("medial_malleolus_right")}})
    if (ankle != marks.end()) legs += (ankle->second.point - spine).norm(), ++count;
  if (count > 0) pelvis.size.leg = legs / count;
  return pelvis;
}

}  // namespace

std::optional<Vector3d> hip_centre(HipRegression regression, const PelvisSize& pelvis) {
  const double width = pelvis.width;
  switch (regression) {
    case HipRegression::harrington:
      if (!pelvis.depth || !pelvis.leg) return std::nullopt;
      return Vector3d(-0.24 * *pelvis.depth - 9.9, -0.16 * width - 0.04 * *pelvis.leg - 7.1,
                      0.28 * *pelvis.depth + 0.16 * width + 7.9);
    case HipRegression::harrington_width:
      return Vector3d(-0.138 * width - 10.4, -0.305 * width - 10.9, 0.33 * width + 7.3);
    case HipRegression::hara:
      if (!pelvis.leg) return std::nullopt;
      return Vector3d(11.0 - 0.063 * *pelvis.leg, -9.0 - 0.078 * *pelvis.leg, 8.0 + 0.086 * *pelvis.leg);
    case HipRegression::bell:
      return Vector3d(-0.19 * width, -0.19 * width, 0.36 * width);
  }
  return std::nullopt;
}

void place_unseen_hips(Landmarks& marks, const std::array<bool, 2>& no_leg) {
  const auto left = marks.find("asis_left"), right = marks.find("asis_right");
  if (left == marks.end() || right == marks.end()) return;
  const Pelvis pelvis = pelvis_of(marks, left->second.point, right->second.point);
  const Named* chosen = nullptr;
  Vector3d place = Vector3d::Zero();
  double spread = 0;  // squared, summed over coordinates
  for (const Named& one : all) {
    const auto centre = hip_centre(one.regression, pelvis.size);
    if (!centre) continue;
    if (!chosen) chosen = &one, place = *centre;
    spread = std::max(spread, (*centre - place).squaredNorm());
  }
  constexpr double tilt = 10 * M_PI / 180;
  double squares = seen_mean * seen_mean + seen_deviation * seen_deviation + spread;
  if (!pelvis.tilt_seen) squares += std::pow(tilt * place.head<2>().norm(), 2);
  double points = 0;
  for (const auto& mark : {left, right}) points += 0.5 * std::pow(mark->second.deviation, 2);
  const double deviation = std::sqrt(squares / 3 + points);

  bool placed = false;
  std::array<Vector3d, 2> centre;
  for (const auto& [name, side] : {std::pair{"hip_left", -1.0}, {"hip_right", 1.0}}) {
    const std::size_t n = side < 0 ? 0 : 1;
    const Vector3d own(place[0], place[1], side * place[2]);
    centre[n] = pelvis.origin + pelvis.axes * own;
    if (const auto it = marks.find(name); it != marks.end() && !is_regression(it->second)) {
      centre[n] = it->second.point;
      continue;
    }
    if (!no_leg[n]) marks[name] = {centre[n], deviation, 0, std::string("regression: ") + chosen->name};
    placed = true;
  }
  if (!placed) return;
  const auto middle = marks.find("mid_hip");
  if (middle != marks.end() && !is_regression(middle->second)) return;
  marks["mid_hip"] = {0.5 * (centre[0] + centre[1]), deviation, 0,
                      std::string("regression: ") + chosen->name};
}

double misfit_of_hips(const Landmarks& marks) {
  // a pair of landmarks whose source starts with `source` and is not doubted
  const auto measured = [&](const std::string& name, std::string_view source) {
    std::array<const Landmark*, 2> pair{};
    for (const std::size_t n : {0, 1}) {
      const auto it = marks.find(name + (n == 0 ? "_left" : "_right"));
      if (it != marks.end() && it->second.source.starts_with(source) && !is_doubted(it->second))
        pair[n] = &it->second;
    }
    return pair;
  };
  const auto hips = measured("hip", "bone: sphere"), spines = measured("asis", "bone: foremost point");
  if (!hips[0] || !hips[1] || !spines[0] || !spines[1]) return 0;
  const auto apart = [](const auto& pair) { return (pair[0]->point - pair[1]->point).norm(); };
  const double usual = 2 * (*hip_centre(HipRegression::harrington_width, {.width = apart(spines)}))[2],
               off = apart(hips) - usual;
  // along the line between the hips: the errors of two regressed centres, and two thirds (2 x 0.33) of those
  // of the ASIS
  const double squares = 2 * (seen_mean * seen_mean + seen_deviation * seen_deviation) / 3 +
                         4.0 / 9 * (std::pow(spines[0]->deviation, 2) + std::pow(spines[1]->deviation, 2));
  constexpr double by_chance = 3;
  return std::abs(off) > by_chance * std::sqrt(squares) ? off : 0;
}

void doubt_misfit_hips(Landmarks& marks) {
  const double off = misfit_of_hips(marks);
  if (off == 0) return;
  for (const char* side : {"_left", "_right"}) {
    raise_deviation("hip", side, 0.5 * std::abs(off), marks);
    marks.at(std::string("hip") + side).source += unlike_body;
  }
  raise_deviation("mid_hip", "", 0.5 * std::abs(off), marks);
}

}  // namespace borelli
