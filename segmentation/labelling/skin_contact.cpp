#include "segmentation/labelling/skin_contact.hpp"

namespace borelli {
namespace {

constexpr bool is_arm(int label) {
  return label >= part_label("upper_arm_left") && label <= part_label("hand_right");
}

// Whether a joint connects two parts. (Hand and upper arm are not neighbours.)
bool neighbours(int a, int b) {
  const auto& first = parts[static_cast<std::size_t>(a)];
  const auto& second = parts[static_cast<std::size_t>(b)];
  return first.parent == second.name || second.parent == first.name;
}

}  // namespace

std::array<double, parts.size()> contact_areas(const Anatomy& a, const Volume<std::uint8_t>& owner,
                                               const PartPlanes& planes) {
  std::array<double, parts.size()> area{};
  const auto& g = a.grid();
  const double face = a.step() * a.step();
  const auto part_at = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    return planes.part(owner.at(i, j, k), g.point(Eigen::Vector3d(double(i), double(j), double(k))));
  };
  for (std::int64_t k = 0; k + 1 < g.size[2]; ++k)
    for (std::int64_t j = 0; j + 1 < g.size[1]; ++j)
      for (std::int64_t i = 0; i + 1 < g.size[0]; ++i) {
        const int mine = owner.at(i, j, k);
        if (mine == 0 || !a.body.at(i, j, k)) continue;
        const std::array<std::array<std::int64_t, 3>, 3> next{{{i + 1, j, k}, {i, j + 1, k}, {i, j, k + 1}}};
        for (const auto& n : next) {
          const int other = owner.at(n[0], n[1], n[2]);
          // few voxels reach the planes' test: only flesh of an arm beside flesh of another part
          if (other == mine || other == 0 || (!is_arm(mine) && !is_arm(other)) ||
              !a.body.at(n[0], n[1], n[2]))
            continue;
          const int p = part_at(i, j, k), q = part_at(n[0], n[1], n[2]);
          if (p == q) continue;
          if (neighbours(p, q)) {
            const Cut* shoulder = nullptr;
            for (const Cut& cut : planes.cuts())
              if (cut.joint.starts_with("shoulder") && (cut.distal == p || cut.distal == q)) shoulder = &cut;
            const bool trunk = !is_arm(p) || !is_arm(q);
            if (!trunk || !shoulder ||
                (g.point(Eigen::Vector3d(double(i), double(j), double(k))) - shoulder->point).norm() <=
                    1.5 * shoulder->reach)
              continue;
          }
          for (const int part : {p, q})
            if (is_arm(part)) area[static_cast<std::size_t>(part)] += face;
        }
      }
  return area;
}

}  // namespace borelli
