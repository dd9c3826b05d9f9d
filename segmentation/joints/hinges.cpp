#include "segmentation/joints/hinges.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace borelli {
namespace {

using Eigen::Vector3d;

struct Rays {
  std::vector<Vector3d> from, direction;
};

Rays rays_about(const Vector3d& point, const Vector3d& axis, double reach, int stations, int spokes) {
  Rays rays;
  const Vector3d u = axis.unitOrthogonal(), v = axis.cross(u);
  for (int s = 0; s < stations; ++s)
    for (int n = 0; n < spokes; ++n) {
      const double t = reach * (2.0 * s / (stations - 1) - 1), a = 2 * std::numbers::pi * n / spokes;
      rays.from.push_back(point + t * axis);
      rays.direction.push_back(std::cos(a) * u + std::sin(a) * v);
    }
  return rays;
}

// the radius at which most rays have an edge, within half a bin, and their number
std::pair<double, int> commonest(const std::vector<std::vector<double>>& edges, double least, double most) {
  const double bin = 0.5;
  const auto bins = static_cast<std::size_t>((most - least) / bin) + 1;
  std::vector<int> count(bins, 0);
  for (const auto& ray : edges) {
    std::size_t last = bins;
    for (const double r : ray)
      for (int w = -2; w <= 2; ++w) {
        const auto n = static_cast<std::int64_t>((r - least) / bin) + w;
        if (n < 0 || n >= static_cast<std::int64_t>(bins) || static_cast<std::size_t>(n) == last) continue;
        ++count[static_cast<std::size_t>(n)];
        last = static_cast<std::size_t>(n);
      }
  }
  const auto best = std::max_element(count.begin(), count.end());
  return {least + bin * (static_cast<double>(best - count.begin()) + 0.5), *best};
}

std::vector<std::vector<double>> edges_of(const CloseUp& view, const Rays& rays, double least, double most) {
  std::vector<std::vector<double>> edges;
  for (std::size_t n = 0; n < rays.from.size(); ++n)
    edges.push_back(falls_along(view, rays.from[n], rays.direction[n], least, most));
  return edges;
}

// one Gauss-Newton step on the distances of points from a cylinder; unknowns: two shifts and two rotations of
// the axis, and the radius
void improve(Hinge& hinge, const std::vector<Vector3d>& points) {
  const Vector3d u = hinge.axis.unitOrthogonal(), v = hinge.axis.cross(u);
  Eigen::Matrix<double, 5, 5> normal = 1e-9 * Eigen::Matrix<double, 5, 5>::Identity();
  Eigen::Matrix<double, 5, 1> right = Eigen::Matrix<double, 5, 1>::Zero();
  for (const auto& p : points) {
    const Vector3d d = p - hinge.point;
    const double t = d.dot(hinge.axis), x = d.dot(u), y = d.dot(v), r = std::hypot(x, y);
    if (r < 1e-6) continue;
    Eigen::Matrix<double, 5, 1> row;
    row << -x / r, -y / r, -t * x / r, -t * y / r, -1;
    normal += row * row.transpose();
    right += row * (hinge.radius - r);
  }
  const Eigen::Matrix<double, 5, 1> step = normal.ldlt().solve(right);
  hinge.point += step[0] * u + step[1] * v;
  hinge.axis = (hinge.axis + step[2] * u + step[3] * v).normalized();
  hinge.radius += step[4];
}

// a cylinder refined on the edges near it, with a tightening tolerance
struct Agreed {
  Hinge hinge;
  double facing;  // fraction of the rays towards the joint's surface that agree
};
std::optional<Agreed> refined(const CloseUp& view, Hinge hinge, const Vector3d& facing, double reach,
                              double least, double most) {
  double share = 0;
  const double tight = std::max(1.5, view.blur);
  for (int round = 0; round < 8; ++round) {
    const double tolerance = round < 3 ? 2 * tight : tight;
    const Rays rays = rays_about(hinge.point, hinge.axis, reach, 9, 48);
    std::vector<Vector3d> points;
    double sum = 0;
    int face = 0, agree = 0;  // rays towards the joint's surface; those that agree
    for (std::size_t n = 0; n < rays.from.size(); ++n) {
      const bool faces = rays.direction[n].dot(facing) > 0.5;
      face += faces;
      double nearest = tolerance, at = -1;
      for (const double r :
           falls_along(view, rays.from[n], rays.direction[n], std::max(least, hinge.radius - 2 * tolerance),
                       hinge.radius + 2 * tolerance))
        if (std::abs(r - hinge.radius) < nearest) nearest = std::abs(r - hinge.radius), at = r;
      if (at < 0) continue;
      agree += faces;
      points.push_back(rays.from[n] + at * rays.direction[n]);
      sum += nearest * nearest;
    }
    hinge.score = static_cast<double>(points.size()) / static_cast<double>(rays.from.size());
    share = face > 0 ? static_cast<double>(agree) / face : 1;
    if (hinge.score < 0.25) return std::nullopt;
    hinge.deviation = std::sqrt(sum / static_cast<double>(points.size()));
    if (round < 7) improve(hinge, points);
    if (hinge.radius < least || hinge.radius > most) return std::nullopt;
  }
  return Agreed{hinge, share};
}

}  // namespace

std::optional<Hinge> fit_hinge(const CloseUp& view, const Vector3d& near, const Vector3d& axis,
                               const Vector3d& facing, double reach, double least, double most, double search,
                               bool farthest) {
  // slices nearly as thick as the smallest radius show steps instead of a cylinder
  if (view.coarsest > 0.9 * least) return std::nullopt;

  // coarse search: points where most rays agree on one radius
  struct Start {
    Hinge hinge;
    int count;
  };
  constexpr int stations = 5, spokes = 24;
  const Vector3d along = axis.normalized(), u = along.unitOrthogonal(), v = along.cross(u);
  std::vector<Start> starts;
  for (double a = -search; a <= search; a += 3)
    for (double b = -search; b <= search; b += 3) {
      if (std::hypot(a, b) > search + 0.1) continue;
      const Vector3d point = near + a * u + b * v;
      const auto [radius, count] = commonest(
          edges_of(view, rays_about(point, along, reach, stations, spokes), least, most), least, most);
      if (count >= stations * spokes / 5) starts.push_back({{point, along, radius, 0, 0}, count});
    }
  std::stable_sort(starts.begin(), starts.end(),
                   [](const Start& a, const Start& b) { return a.count > b.count; });

  // takes the start with most rays, unless another cylinder is clearly better
  const std::size_t most_tries = facing.isZero() ? 1 : 6;
  constexpr double apart = 7, clearly = 1.3;
  std::vector<Vector3d> tried;
  std::optional<Hinge> best;
  double most_agree = 0;
  std::vector<std::pair<Hinge, double>> alike;  // with their scores
  for (const Start& start : starts) {
    if (tried.size() == most_tries) break;
    if (std::any_of(tried.begin(), tried.end(),
                    [&](const Vector3d& other) { return (other - start.hinge.point).norm() < apart; }))
      continue;
    tried.push_back(start.hinge.point);
    const auto found = refined(view, start.hinge, facing, reach, least, most);
    if (!found) continue;
    const Hinge& hinge = found->hinge;
    if ((hinge.point - near).norm() > search + 8 || std::abs(hinge.axis.dot(along)) < 0.96) continue;
    if (farthest) {
      alike.emplace_back(hinge, hinge.score * found->facing);
      most_agree = std::max(most_agree, alike.back().second);
      continue;
    }
    const double off = (hinge.point - near - (hinge.point - near).dot(along) * along).norm();
    const double agree = hinge.score * found->facing * std::exp(-0.5 * std::pow(off / search, 2));
    if (agree > clearly * most_agree) most_agree = agree, best = hinge;
  }
  std::erase_if(alike, [&](const auto& place) { return clearly * place.second < most_agree; });
  for (const auto& [hinge, agree] : alike)
    if (!best || (hinge.point - best->point).dot(facing) > 0) best = hinge;
  for (const auto& [hinge, agree] : alike)
    best->other = std::max(best->other, (hinge.point - best->point).norm());
  if (best) best->point += (near - best->point).dot(best->axis) * best->axis;
  return best;
}

}  // namespace borelli
