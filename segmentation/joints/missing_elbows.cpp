#include "segmentation/joints/missing_elbows.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "segmentation/vocabulary/parts.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

// The point on the shaft's line at `length` from the humeral head's centre, which lies beside that line. The
// line is the best fit to the centres of those sections that the scan's side does not cut.
std::optional<Vector3d> along_shaft(const Anatomy& a, const Limbs& limbs, Limb limb, const Vector3d& head,
                                    double length, double scale) {
  const double first = 75 * scale, last = 230 * scale, clear = 3, thick = 6;
  struct Section {
    Vector3d sum = Vector3d::Zero();
    double count = 0;
    bool cut = false;
  };
  std::vector<Section> sections(static_cast<std::size_t>((last - first) / thick) + 1);
  const auto& g = a.grid();
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        if (!a.bone.at(i, j, k) || limbs.territory.owner.at(i, j, k) != static_cast<std::uint8_t>(limb))
          continue;
        const Vector3d p = g.point(i, j, k);
        const double r = (p - head).norm();
        if (r < first || r >= last) continue;
        Section& section = sections[static_cast<std::size_t>((r - first) / thick)];
        section.sum += p - head, section.count += 1;
        section.cut = section.cut || a.near_edge(p, clear);
      }
  std::vector<Vector3d> middles;  // from the head's centre
  Vector3d mean = Vector3d::Zero();
  for (const Section& section : sections)
    if (section.count > 0 && !section.cut)
      middles.push_back(section.sum / section.count), mean += middles.back();
  if (middles.size() < 6) return std::nullopt;
  mean /= static_cast<double>(middles.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Vector3d& p : middles) spread += (p - mean) * (p - mean).transpose();
  Vector3d along = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors().col(2);
  if (along.dot(mean) < 0) along = -along;
  const double nearest = mean.dot(along), aside = (mean - nearest * along).norm();
  if (aside > 0.2 * length) return std::nullopt;
  return Vector3d(head + mean + (std::sqrt(length * length - aside * aside) - nearest) * along);
}

// The same for a bone hardly in view, from the path: along the mean direction from the head to the path's
// points clear of the scan's side.
std::optional<Vector3d> along_path(const Anatomy& a, const LimbPath& path, const Vector3d& head,
                                   double length, double scale) {
  const double first = 60 * scale, last = 230 * scale, clear = 8, least = 60 * scale;
  Vector3d sum = Vector3d::Zero();
  double seen = 0;
  for (const Vector3d& p : path.points) {
    const double r = (p - head).norm();
    if (r < first || r > last || a.near_edge(p, clear)) continue;
    sum += p - head, seen += LimbPath::spacing;
  }
  if (seen < least) return std::nullopt;
  return Vector3d(head + length * sum.normalized());
}

// mm^3 of an arm's flesh beyond a plane
double flesh_beyond(const Anatomy& a, const Volume<std::uint8_t>& owner, int label, const Vector3d& point,
                    const Vector3d& normal) {
  const auto& g = a.grid();
  std::int64_t count = 0;
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        if (owner.at(i, j, k) != label || !a.body.at(i, j, k)) continue;
        const Vector3d p = g.point(i, j, k);
        count += (p - point).dot(normal) > 0;
      }
  return static_cast<double>(count) * g.voxel_volume();
}

}  // namespace

void place_missing_elbows(const Anatomy& a, const Limbs& limbs, const Volume<std::uint8_t>& owner,
                          const Trunk& trunk, Landmarks& marks) {
  const double scale = trunk.scale;
  constexpr double piece = 5e3;  // mm^3: less may be the upper arm's own end
  Landmarks placed;
  for (const int side : {left_side, right_side}) {
    const std::string at = side_suffix(side), other = side_suffix(1 - side);
    if (is_absent(trunk.absent, "forearm", at)) continue;
    const Limb limb = side == left_side ? Limb::arm_left : Limb::arm_right;
    const LimbPath& path = limbs.arm(side);
    const auto shoulder = marks.find("shoulder" + at);
    if (!path.present || !path.cut || shoulder == marks.end() || marks.contains("elbow" + at)) continue;
    const Vector3d head = shoulder->second.point;
    const auto far_shoulder = marks.find("shoulder" + other), far_elbow = marks.find("elbow" + other);
    const bool mirrored = far_shoulder != marks.end() && far_elbow != marks.end();
    const double length =
        mirrored ? (far_elbow->second.point - far_shoulder->second.point).norm() : 281.7 * scale;
    auto elbow = along_shaft(a, limbs, limb, head, length, scale);
    if (!elbow) elbow = along_path(a, path, head, length, scale);
    if (!elbow) continue;
    const Vector3d along = (*elbow - head).normalized();
    if (flesh_beyond(a, owner, part_label("upper_arm" + at), *elbow, along) < piece) continue;
    // Lengths differ by about 2 % between left and right, 6 % between bodies of one stature, and 12 % between
    // bodies of one shoulder breadth. The shaft's line is off by about 3 degrees.
    const double differ = mirrored ? 0.02 : marks.contains("hip_left") ? 0.06 : 0.12;
    const double deviation = std::hypot(differ * length, 0.05 * length);
    placed["elbow" + at] = {*elbow, deviation, 0,
                            mirrored ? "proportion: the other arm's length along the humerus"
                                     : "proportion: by the body's size along the humerus"};
  }
  marks.merge(placed);
}

}  // namespace borelli
