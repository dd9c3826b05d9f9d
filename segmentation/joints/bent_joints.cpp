#include "segmentation/joints/bent_joints.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace borelli {
namespace {

using Eigen::Vector3d;

struct Line {
  Vector3d point, direction;  // direction: unit, away from the limb's root
};

// Line through the mean of a limb's bone between two path lengths, along its direction of largest variance.
std::optional<Line> shaft_line(const Anatomy& a, const Limbs& limbs, Limb limb, double from, double to) {
  constexpr double aside = 60;  // mm about the path: a limb's bones there
  const LimbPath& path = limbs.path[static_cast<std::size_t>(limb)];
  const auto& g = a.grid();
  if (from <= 0 || to > path.length()) return std::nullopt;
  Vector3d low = path.points[path.index(from)], high = low;
  for (std::size_t n = path.index(from); n <= path.index(to); ++n) {
    low = low.cwiseMin(path.points[n]);
    high = high.cwiseMax(path.points[n]);
  }
  const Vector3d first = g.index(low - Vector3d::Constant(aside)),
                 last = g.index(high + Vector3d::Constant(aside));
  Vector3d sum = Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  double count = 0;
  for (auto k = std::lround(first[2]); k <= std::lround(last[2]); ++k)
    for (auto j = std::lround(first[1]); j <= std::lround(last[1]); ++j)
      for (auto i = std::lround(first[0]); i <= std::lround(last[0]); ++i) {
        if (!g.holds(i, j, k) || !a.bone.at(i, j, k)) continue;
        if (limbs.territory.owner.at(i, j, k) != static_cast<std::uint8_t>(limb)) continue;
        const double length = limbs.territory.length(i, j, k);
        if (length < from || length > to) continue;
        const Vector3d p = g.point(i, j, k);
        sum += p - low, second += (p - low) * (p - low).transpose(), ++count;
      }
  if (count < 10) return std::nullopt;
  const Vector3d mean = sum / count;
  Vector3d along = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(second / count - mean * mean.transpose())
                       .eigenvectors()
                       .col(2);
  if (along.dot(path.points[path.index(to)] - path.points[path.index(from)]) < 0) along = -along;
  return Line{low + mean, along};
}

}  // namespace

std::optional<BentJoint> bent_joint(const Anatomy& a, const Limbs& limbs, Limb limb, double middle,
                                    double near, double far) {
  const auto above = shaft_line(a, limbs, limb, middle - far, middle - near),
             below = shaft_line(a, limbs, limb, middle + near, middle + far);
  if (!above || !below) return std::nullopt;
  const double cosine = above->direction.dot(below->direction);
  constexpr double bent = 0.707, apart = 25;  // cosine of 45 degrees; mm
  if (cosine > bent || cosine < -0.98) return std::nullopt;
  // nearest points above->point + s * direction, below->point + t * direction
  const Vector3d d = below->point - above->point;
  const double u = d.dot(above->direction), v = d.dot(below->direction), sine2 = 1 - cosine * cosine;
  const double s = (u - cosine * v) / sine2, t = (cosine * u - v) / sine2;
  const Vector3d p = above->point + s * above->direction, q = below->point + t * below->direction;
  if ((p - q).norm() > apart) return std::nullopt;
  return BentJoint{0.5 * (p + q), above->direction.cross(below->direction).normalized()};
}

}  // namespace borelli
