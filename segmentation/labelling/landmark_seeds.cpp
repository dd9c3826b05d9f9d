#include "segmentation/labelling/landmark_seeds.hpp"

#include <cmath>
#include <string>
#include <vector>

#include "segmentation/vocabulary/part_planes.hpp"
#include "segmentation/vocabulary/parts.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

struct Drawing {
  const Anatomy& a;
  const Landmarks& marks;
  Volume<std::uint8_t> seeds;

  // a tube around the line between two landmarks, without its first and last tenth, where the joints are
  void line(const std::string& from, const std::string& to, int label, double first = 0.1,
            double last = 0.9) {
    const auto p = marks.find(from), q = marks.find(to);
    if (p == marks.end() || q == marks.end()) return;
    const Vector3d along = q->second.point - p->second.point;
    const auto steps = static_cast<int>(std::ceil(along.norm() / (0.5 * a.step()))) + 1;
    for (int n = 0; n <= steps; ++n) {
      const double s = first + (last - first) * n / steps;
      put(p->second.point + s * along, label);
    }
  }

  void put(const Vector3d& point, int label) {
    const Vector3d index = a.grid().index(point);
    const auto i = std::lround(index[0]), j = std::lround(index[1]), k = std::lround(index[2]);
    for (std::int64_t c = k - 1; c <= k + 1; ++c)
      for (std::int64_t b = j - 1; b <= j + 1; ++b)
        for (std::int64_t d = i - 1; d <= i + 1; ++d)
          if (a.grid().holds(d, b, c) && a.body.at(d, b, c) && !seeds.at(d, b, c))
            seeds.at(d, b, c) = static_cast<std::uint8_t>(label);
  }
};

}  // namespace

Volume<std::uint8_t> seeds_by_landmarks(const Anatomy& a, const Landmarks& marks) {
  const auto& g = a.grid();
  Drawing draw{a, marks, {g, std::vector<std::uint8_t>(g.count(), 0)}};
  const auto label = [](const std::string& name) { return part_label(name); };
  for (const int side : {left_side, right_side}) {
    const std::string at = side_suffix(side);
    draw.line("hip" + at, "knee" + at, label("thigh" + at));
    draw.line("knee" + at, "ankle" + at, label("shank" + at));
    draw.line("heel" + at, "toe_tip" + at, label("foot" + at));
    draw.line("ankle" + at, "toe_tip" + at, label("foot" + at), 0.3);
    draw.line("shoulder" + at, "elbow" + at, label("upper_arm" + at));
    draw.line("elbow" + at, "wrist" + at, label("forearm" + at));
    draw.line("wrist" + at, "dactylion_3" + at, label("hand" + at));
    draw.line("wrist" + at, "metacarpale_3" + at, label("hand" + at));
    draw.line("neck", "shoulder" + at, label("upper_trunk"), 0, 0.7);
    draw.line("mid_hip", "hip" + at, label("lower_trunk"), 0, 0.6);
  }
  draw.line("hip_left", "hip_right", label("lower_trunk"), 0.2, 0.8);
  draw.line("shoulder_left", "shoulder_right", label("upper_trunk"), 0.2, 0.8);
  draw.line("mid_hip", "neck", label("lower_trunk"), 0, 0.95);
  draw.line("neck", "vertex", label("head"));
  // the spine's line crosses the trunk's parts: their planes divide it
  const PartPlanes planes(marks);
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        auto& seed = draw.seeds.at(i, j, k);
        if (seed == label("lower_trunk") || seed == label("upper_trunk"))
          seed = static_cast<std::uint8_t>(planes.part(seed, g.point(i, j, k)));
      }
  return std::move(draw.seeds);
}

}  // namespace borelli
