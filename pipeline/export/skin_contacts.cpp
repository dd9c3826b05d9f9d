#include "pipeline/export/skin_contacts.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace borelli {
namespace {

/// The part, of two, whose joint connects them; none: -1.
int joint_between(const std::vector<SkinPart>& parts, std::size_t a, std::size_t b) {
  if (parts[a].parent == static_cast<int>(b)) return static_cast<int>(a);
  if (parts[b].parent == static_cast<int>(a)) return static_cast<int>(b);
  return -1;
}

/// One of each pair of opposite steps to the 26 neighbours.
std::vector<std::array<std::int64_t, 3>> forward_steps() {
  std::vector<std::array<std::int64_t, 3>> steps;
  for (int s = 14; s < 27; ++s) steps.push_back({s % 3 - 1, s / 3 % 3 - 1, s / 9 - 1});
  return steps;
}

/// Whether a part that flesh joins to both a and b lies within 10 mm of a voxel. Where three cuts meet, as
/// those of neck and shoulders do, their outer parts share a strip of border.
bool third_joins(const Volume<std::uint8_t>& body, const std::vector<SkinPart>& parts, std::size_t a,
                 std::size_t b, const std::array<std::int64_t, 3>& at) {
  const Grid& g = body.grid;
  const Eigen::Vector3d spacing = g.spacing();
  std::array<std::int64_t, 3> first{}, last{};
  for (std::size_t c = 0; c < 3; ++c) {
    const auto reach = static_cast<std::int64_t>(10 / spacing[static_cast<int>(c)]);
    first[c] = std::max<std::int64_t>(0, at[c] - reach);
    last[c] = std::min(g.size[c] - 1, at[c] + reach);
  }
  for (std::int64_t k = first[2]; k <= last[2]; ++k)
    for (std::int64_t j = first[1]; j <= last[1]; ++j)
      for (std::int64_t i = first[0]; i <= last[0]; ++i) {
        const std::uint8_t value = body.at(i, j, k);
        if (value == 0 || value - 1U == a || value - 1U == b) continue;
        const Eigen::Vector3d p = 1e-3 * g.point(i, j, k);
        if (flesh_joins(parts, value - 1U, a, p) && flesh_joins(parts, value - 1U, b, p)) return true;
      }
  return false;
}

}  // namespace

bool flesh_joins(const std::vector<SkinPart>& parts, std::size_t a, std::size_t b,
                 const Eigen::Vector3d& p_W) {
  const int joint = joint_between(parts, a, b);
  if (joint < 0) return false;
  const SkinPart& part = parts[static_cast<std::size_t>(joint)];
  if (!part.has_joint) return true;
  const Eigen::Vector3d from = p_W - part.centre;
  return part.axis.dot(from) <= 2 * part.half_thickness && from.norm() <= 4 * part.half_thickness;
}

void open_contacts(Volume<std::uint8_t>& body, const std::vector<SkinPart>& parts) {
  const Grid& g = body.grid;
  std::array<std::size_t, 256> voxels{};
  for (const std::uint8_t part : body.voxels) ++voxels[part];
  const auto steps = forward_steps();
  std::vector<std::size_t> closed;
  std::size_t at = 0;
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i, ++at) {
        const std::uint8_t here = body.voxels[at];
        if (here == 0) continue;
        for (const auto& s : steps) {
          if (!g.holds(i + s[0], j + s[1], k + s[2])) continue;
          const std::size_t beside = g.offset(i + s[0], j + s[1], k + s[2]);
          const std::uint8_t there = body.voxels[beside];
          if (there == here || there == 0) continue;
          const Eigen::Vector3d between = (Eigen::Vector3d(double(i), double(j), double(k)) +
                                           0.5 * Eigen::Vector3d(double(s[0]), double(s[1]), double(s[2])));
          if (!flesh_joins(parts, here - 1U, there - 1U, 1e-3 * g.point(between)) &&
              !third_joins(body, parts, here - 1U, there - 1U, {i, j, k}))
            closed.push_back(std::pair(voxels[here], here) > std::pair(voxels[there], there) ? at : beside);
        }
      }
  for (const std::size_t voxel : closed) body.voxels[voxel] = 0;
}

}  // namespace borelli
