#include "segmentation/joints/vertebrae.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace borelli {
namespace {

using Eigen::Vector3d;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Approximate centre of the vertebral body at a level. Voxels are weighted by the cubed depth within bone, so
// that the thinner arch behind weighs little, and by their distance from the spine, so that ilium and ribs
// do.
Vector3d near_vertebral_body(const Anatomy& a, const Trunk& trunk, double z) {
  const auto& g = a.grid();
  const Vector3d spine = trunk.spine_at(z);
  Vector3d centre = spine;
  constexpr double reach = 24, half = 12, width = 8, off_spine = 16;  // mm
  for (int round = 0; round < 20; ++round) {
    const Vector3d low = g.index(centre - Vector3d(reach, reach, half)),
                   high = g.index(centre + Vector3d(reach, reach, half));
    Vector3d sum = Vector3d::Zero();
    double weight = 0;
    for (auto k = std::lround(low[2]); k <= std::lround(high[2]); ++k)
      for (auto j = std::lround(low[1]); j <= std::lround(high[1]); ++j)
        for (auto i = std::lround(low[0]); i <= std::lround(high[0]); ++i) {
          if (!g.holds(i, j, k) || a.within_bone.at(i, j, k) <= 0) continue;
          const Vector3d p = g.point(i, j, k);
          const double away = (p - centre).head<2>().squaredNorm() / (width * width) +
                              (p - spine).head<2>().squaredNorm() / (off_spine * off_spine);
          const double w = std::pow(a.within_bone.at(i, j, k), 3) * std::exp(-0.5 * away);
          sum += w * p;
          weight += w;
        }
    if (weight <= 0) break;
    const Vector3d next(sum[0] / weight, sum[1] / weight, z);
    const double moved = (next - centre).norm();
    centre = next;
    if (moved < 0.05) break;
  }
  return centre;
}

// Half the depth of a small vertebral body behind the foremost bone about a place; no arch lies that far
// forward.
Vector3d behind_front_face(const CloseUp& view, const Vector3d& near, double scale) {
  constexpr double bone = 200;
  std::vector<double> front;
  for (double x = -6; x <= 6; x += 3)
    for (const double z : {-14.0, -11.0, -8.0, -5.0, 5.0, 8.0, 11.0, 14.0}) {
      const Vector3d from = near + Vector3d(x, 0, z);
      const auto falls = falls_along(view, from, -Vector3d::UnitY(), 0, 40 * scale);
      for (auto r = falls.rbegin(); r != falls.rend(); ++r)
        if (view.at(from - Vector3d(0, *r - 1.5, 0)) > bone) {
          front.push_back(*r);
          break;
        }
    }
  if (front.size() < 10) return near;
  return near - Vector3d(0, median(front) - 8 * scale, 0);
}

}  // namespace

Vector3d vertebral_body(const Anatomy& a, const Trunk& trunk, double z, bool neck) {
  Vector3d middle = near_vertebral_body(a, trunk, z);
  const CloseUp view = close_up(*a.source, middle, 60);
  if (neck) middle = behind_front_face(view, middle, trunk.scale);
  for (int round = 0; round < 2; ++round) {
    Vector3d sum = Vector3d::Zero();
    int sides = 0;
    for (const double sign : {-1.0, 1.0}) {
      std::vector<double> x, y;
      for (double dz = 4; dz <= 16; dz += 1.5) {
        const Vector3d p = middle + Vector3d(0, 0, sign * dz);
        const auto face = [&](const Vector3d& direction) {
          const auto falls = falls_along(view, p, direction, 1, 40);
          return falls.empty() ? 0 : falls.front();
        };
        const double front = face(-Vector3d::UnitY()), back = face(Vector3d::UnitY()),
                     left = face(Vector3d::UnitX()), right = face(-Vector3d::UnitX());
        if (front > 0 && back > 0) y.push_back(0.5 * (back - front));
        if (left > 0 && right > 0) x.push_back(0.5 * (left - right));
      }
      if (x.size() < 3 || y.size() < 3) continue;
      sum += Vector3d(median(x), median(y), 0);
      ++sides;
    }
    if (sides < 2) break;
    middle += sum / sides;
  }
  return middle;
}

namespace {

// Area of bone beside the spine in the slice at a level, by side, mm^2: ribs and their necks lie there, and
// no vertebra reaches it.
std::array<double, 2> bone_beside(const Anatomy& a, const Trunk& trunk, double z) {
  const auto& g = a.grid();
  const auto k = std::lround((z - g.origin[2]) / a.step());
  const Vector3d column = trunk.spine_at(z);
  const double s = trunk.scale;
  std::array<double, 2> area{0, 0};
  for (std::int64_t j = 0; j < g.size[1]; ++j)
    for (std::int64_t i = 0; i < g.size[0]; ++i) {
      if (!g.holds(i, j, k) || !a.bone.at(i, j, k)) continue;
      const Vector3d d = g.point(i, j, k) - column;
      if (std::abs(d[0]) > 28 * s && std::abs(d[0]) < 52 * s && d[1] > -15 * s && d[1] < 40 * s)
        area[static_cast<std::size_t>(d[0] > 0 ? left_side : right_side)] += a.step() * a.step();
    }
  return area;
}

}  // namespace

std::optional<double> first_rib(const Anatomy& a, const Trunk& trunk, double near) {
  const double rib = trunk.only_side ? 75 : 150;  // mm^2: the rib necks in view
  constexpr double share = 0.2;                   // of the largest below: transverse processes have less
  constexpr double no_more = 36, seen = 24;       // height without a rib above the first one, and in view, mm
  constexpr double level = 8, hardly = 30;  // mm, mm^2: contrast in a vein, or an arm, lies on one side alone
  const double s = trunk.scale;
  struct Slice {
    double z;
    std::array<double, 2> beside;
  };
  std::vector<Slice> slices;
  for (double z = near - 110 * s; z < near + 75 * s; z += a.step())
    if (trunk.spine_holds(z)) slices.push_back({z, bone_beside(a, trunk, z)});
  const auto paired = [&](double z) {
    std::array<double, 2> most{0, 0};
    for (const Slice& other : slices)
      if (std::abs(other.z - z) <= level * s)
        for (std::size_t n = 0; n < 2; ++n) most[n] = std::max(most[n], other.beside[n]);
    return trunk.only_side || std::min(most[0], most[1]) > hardly * s * s;
  };
  std::optional<double> top;
  double before = 0, most = 0;  // bone in the slice below; the largest so far
  for (const auto& [z, beside] : slices) {
    const double here = paired(z) ? (beside[0] + beside[1]) / (rib * s * s) : 0;
    most = std::max(most, here);
    const double limit = std::max(1.0, share * most);
    // interpolates where the area falls below the limit
    if (here >= limit)
      top = z;
    else if (before >= limit)
      top = z - a.step() * (limit - here) / (before - here);
    else if (top && z - *top > no_more * s)
      break;
    before = here;
  }
  // a chest cut by the scan's top shows no first rib
  if (top && !trunk.spine_holds(*top + seen * s)) return std::nullopt;
  return top;
}

std::optional<double> disc_near(const Anatomy& a, const Trunk& trunk, double level, double spread) {
  const double s = trunk.scale;
  // fewer than three slices per vertebra show chance dips
  constexpr double vertebra = 18;
  if (a.source->grid.spacing().maxCoeff() > vertebra * s / 3) return std::nullopt;
  const double reach = 0.5 * vertebra * s;  // farther off, the next disc is nearer
  const Eigen::Matrix3d to_index = a.source->grid.axes.inverse();
  const Vector3d lower = vertebral_body(a, trunk, level - reach, true),
                 upper = vertebral_body(a, trunk, level + reach, true);
  // mean CT number across the centre of the bodies
  const auto at = [&](double z) {
    const Vector3d centre = lower + (z - lower[2]) / (upper[2] - lower[2]) * (upper - lower);
    double sum = 0;
    int count = 0;
    for (double x = -6; x <= 6; x += 2)
      for (double y = -6; y <= 6; y += 2) {
        double value = 0;
        if (!sample(*a.source, to_index * (centre + Vector3d(x, y, 0) - a.source->grid.origin), value))
          continue;
        sum += hu_of(value, a.source->quantity);
        ++count;
      }
    return count ? sum / count : 0;
  };
  const double body = 0.65 * vertebra * s;  // the vertebral bodies next to a disc peak within this distance
  const double from = level - reach - body;
  std::vector<double> profile;
  for (double z = from; z <= level + reach + body; z += 1) profile.push_back(at(z));
  const auto beside = std::lround(body), count = static_cast<std::int64_t>(profile.size());
  const auto value = [&](std::int64_t n) { return profile[static_cast<std::size_t>(n)]; };
  // a stretch this long contains a disc, and other discs are nearly as soft; spongiosa between endplates is
  // not
  const double softest = *std::min_element(profile.begin(), profile.end());
  const double soft = softest + 0.4 * (median(profile) - softest);
  std::optional<double> best;
  double most = 0;
  for (auto n = beside; n < count - beside; ++n) {
    if (value(n) > soft || value(n) > value(n - 1) || value(n) > value(n + 1)) continue;
    // a disc is softer than the bodies on both sides
    const auto here = profile.begin() + n;
    const double peak =
        std::min(*std::max_element(here - beside, here), *std::max_element(here, here + beside + 1));
    if (peak - value(n) < std::max(60.0, 0.25 * peak)) continue;
    // centre of the stretch below half the height of the peaks, with interpolated ends
    const double half = 0.5 * (value(n) + peak);
    const auto end = [&](std::int64_t step) {
      auto q = n;
      while (value(q) < half) q += step;
      const double t = (half - value(q - step)) / (value(q) - value(q - step));
      return static_cast<double>(q) - static_cast<double>(step) * (1 - t);
    };
    const double z = from + 0.5 * (end(-1) + end(1));
    // favours deep dips near the expected level
    const double score = (peak - value(n)) / peak * std::exp(-0.5 * std::pow((z - level) / spread, 2));
    if (score > most) most = score, best = z;
  }
  return best;
}

std::optional<double> disc_between_slices(const Anatomy& a, const Trunk& trunk, double level) {
  // mm, from disc to disc: posterior height of the body (Panjabi et al. 1991) plus a disc of 5 mm
  constexpr double seventh = 17.8, first = 19.1;
  constexpr double sure = 5;  // mm, standard deviation of either neighbour about its expected level
  const Grid& scan = a.source->grid;
  const double s = trunk.scale;
  const auto above = disc_near(a, trunk, level + seventh * s, sure),
             below = disc_near(a, trunk, level - first * s, sure);
  if (!above && !below) return std::nullopt;
  double z = 0;
  if (above && below) {
    const double span = (*above - *below) / (s * (seventh + first));
    if (span < 0.8 || span > 1.25) return std::nullopt;
    z = *below + first / (seventh + first) * (*above - *below);
  } else {
    z = 0.5 * (level + (above ? *above - seventh * s : *below + first * s));
  }
  // the axis along which slices are stacked, and the middle between two of them
  Eigen::Index across = 0;
  scan.spacing().maxCoeff(&across);
  const double per_z = scan.axes.inverse()(across, 2);
  if (std::abs(per_z) * scan.spacing()[across] < 0.9) return std::nullopt;  // slices not across the spine
  const double at = scan.index(vertebral_body(a, trunk, z, true))[across];
  return z + (std::floor(at) + 0.5 - at) / per_z;
}

std::optional<Vector3d> spinous_tip(const Anatomy& a, const Vector3d& disc, double scale) {
  const CloseUp view = close_up(*a.source, disc + Vector3d(0, 40 * scale, 0), 60 * scale);
  std::vector<Vector3d> ends;
  for (double z = -10; z <= 10; z += 1)
    for (double x = -8; x <= 8; x += 1) {
      const Vector3d from = disc + scale * Vector3d(x, 0, z);
      const auto falls = falls_along(view, from, Vector3d::UnitY(), 18 * scale, 75 * scale);
      if (!falls.empty()) ends.push_back(from + Vector3d(0, falls.back(), 0));
    }
  if (ends.size() < 6) return std::nullopt;
  const auto last = std::max_element(ends.begin(), ends.end(),
                                     [](const Vector3d& p, const Vector3d& q) { return p[1] < q[1]; });
  Vector3d sum = Vector3d::Zero();
  int count = 0;
  for (const auto& p : ends)
    if (p[1] > (*last)[1] - 2.5) sum += p, ++count;
  Vector3d tip = sum / count;
  tip[1] = (*last)[1];
  return tip;
}

}  // namespace borelli
