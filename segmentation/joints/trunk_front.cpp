#include "segmentation/joints/trunk_front.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace borelli {
namespace {

using Eigen::Vector3d;

constexpr double hidden = 1e9;           // no visible skin of the trunk, mm
constexpr double shallowest_dent = 2.5;  // of a navel, mm

}  // namespace

TrunkFront::TrunkFront(const Anatomy& a, const Trunk& trunk, const Limbs& limbs, double low, double high)
    : a_(a), trunk_(trunk) {
  constexpr double aside = 130;  // mm from the midline: covers a navel's surroundings and what touches them
  // Assumes an arm's flesh within a stout forearm's thickness of its bones, through flesh only. If the arm
  // lies on the trunk, this includes some of the trunk.
  constexpr double thick = 30;  // mm
  const auto& g = a.grid();
  const auto index = [&](double at, int axis) {
    return std::clamp<std::int64_t>(std::lround((at - g.origin[axis]) / a.step()), 0,
                                    g.size[static_cast<std::size_t>(axis)] - 1);
  };
  const double middle = trunk.middle(0.5 * (low + high));
  first_ = {index(middle - aside, 0), 0, index(low, 2)};
  const std::array<std::int64_t, 3> last{index(middle + aside, 0), g.size[1] - 1, index(high, 2)};
  Grid box = g;
  for (std::size_t c = 0; c < 3; ++c) box.size[c] = last[c] - first_[c] + 1;
  Volume<float> cost{box, std::vector<float>(box.count(), no_path)};
  Volume<std::uint8_t> seeds{box, std::vector<std::uint8_t>(box.count(), 0)};
  for (std::int64_t k = 0; k < box.size[2]; ++k)
    for (std::int64_t j = 0; j < box.size[1]; ++j)
      for (std::int64_t i = 0; i < box.size[0]; ++i) {
        if (!a.body.at(i + first_[0], j, k + first_[2])) continue;
        cost.at(i, j, k) = 1;
        seeds.at(i, j, k) = limbs.arm_at(i + first_[0], j, k + first_[2]);
      }
  arm_ = nearest_seeds({cost, a.threads}, seeds, static_cast<float>(thick * trunk.scale));
}

// Index j of the trunk's foremost voxel on a line from the front; empty if an arm lies on it.
std::optional<std::int64_t> TrunkFront::front(std::int64_t i, std::int64_t k) const {
  const auto& g = a_.grid();
  const std::int64_t x = i - first_[0], z = k - first_[2];
  if (!arm_.grid.holds(x, 0, z)) return std::nullopt;
  bool in_arm = false;
  std::optional<std::int64_t> begin;  // of the piece of body that the line is in
  for (std::int64_t j = 0; j < g.size[1]; ++j) {
    if (!a_.body.at(i, j, k)) {
      if (begin && !in_arm) return begin;
      begin.reset(), in_arm = false;
      continue;
    }
    if (!begin) begin = j;
    in_arm = in_arm || arm_.at(x, j, z);
    // a piece this deep is the trunk
    constexpr double deep = 80;  // mm
    if (a_.step() * static_cast<double>(j - *begin) > deep) return in_arm ? std::nullopt : begin;
  }
  return begin && !in_arm ? begin : std::nullopt;
}

// y of the skin (mm, LPS), interpolated at skin_edge_hu between air and body
double TrunkFront::skin(std::int64_t i, std::int64_t k) const {
  const auto j = front(i, k);
  if (!j) return hidden;
  if (*j == 0) return a_.grid().origin[1];
  const double v0 = a_.scan.hu.at(i, *j - 1, k), v1 = a_.scan.hu.at(i, *j, k);
  const double t = v1 > v0 ? std::clamp((-400 - v0) / (v1 - v0), 0.0, 1.0) : 0.5;
  return a_.grid().origin[1] + a_.step() * (static_cast<double>(*j) - 1 + t);
}

std::optional<Vector3d> TrunkFront::skin_at(double z) const {
  constexpr double reach = 100;  // mm
  const auto& g = a_.grid();
  const double x = trunk_.middle(z);
  const auto middle = std::lround((x - g.origin[0]) / a_.step()),
             k = std::lround((z - g.origin[2]) / a_.step());
  for (std::int64_t n = 0; a_.step() * static_cast<double>(n) < reach; ++n)
    for (const auto i : {middle - n, middle + n})
      if (const auto j = front(i, k))
        return Vector3d(x, g.origin[1] + a_.step() * (static_cast<double>(*j) - 0.5), z);
  return std::nullopt;
}

// Depth of the skin behind the mean of opposite neighbours, mm; slopes and curvature along one line thus
// cancel. Empty if fewer than `least` of the four pairs are visible.
std::optional<double> TrunkFront::dent(std::int64_t i, std::int64_t k, int least) const {
  constexpr double narrow = 12;  // mm: a navel is a narrow pit, folds and the shape of the belly are wider
  const auto ring = std::lround(narrow / a_.step());
  const double here = skin(i, k);
  if (here == hidden) return std::nullopt;
  double depth = hidden;
  int pairs = 0;
  for (const auto& [di, dk] : {std::pair{1, 0}, {0, 1}, {1, 1}, {1, -1}}) {
    const double s1 = skin(i + di * ring, k + dk * ring), s2 = skin(i - di * ring, k - dk * ring);
    if (s1 == hidden || s2 == hidden) continue;
    depth = std::min(depth, here - 0.5 * (s1 + s2));
    ++pairs;
  }
  return pairs < least ? std::nullopt : std::optional(depth);
}

// The dents near the midline between two levels, without those beside a deeper one.
std::vector<TrunkFront::Dent> TrunkFront::dents(double from, double to) const {
  constexpr double aside = 24, apart = 20;  // mm
  const auto& g = a_.grid();
  const auto k0 = std::lround((from - g.origin[2]) / a_.step()),
             k1 = std::lround((to - g.origin[2]) / a_.step()), half = std::lround(aside / a_.step());
  std::vector<Dent> all, out;
  for (auto k = k0; k <= k1; ++k) {
    const double z = g.origin[2] + a_.step() * static_cast<double>(k);
    const auto mid = std::lround((trunk_.middle(z) - g.origin[0]) / a_.step());
    for (auto i = mid - half; i <= mid + half; ++i)
      if (const auto depth = dent(i, k, 4); depth && *depth > shallowest_dent) all.push_back({i, k, *depth});
  }
  std::sort(all.begin(), all.end(), [](const Dent& a, const Dent& b) { return a.depth > b.depth; });
  for (const Dent& dent : all)
    if (std::none_of(out.begin(), out.end(), [&](const Dent& deeper) {
          return std::hypot(dent.i - deeper.i, dent.k - deeper.k) * a_.step() < apart;
        }))
      out.push_back(dent);
  return out;
}

std::optional<Landmark> TrunkFront::navel(double from, double to, double usual, double spread) const {
  const auto& g = a_.grid();
  const auto square = [](double v) { return v * v; };
  const auto level = [&](const Dent& dent) { return g.origin[2] + a_.step() * static_cast<double>(dent.k); };
  // Relative probability that a dent is the navel: by its depth, and by its distances from the midline and the
  // usual level, which are normally distributed. That no dent is the navel has the probability `no_dent`.
  constexpr double growth = 1, deep = 10, from_midline = 10, no_dent = 1;  // mm
  const auto chance = [&](const Dent& dent) {
    const double z = level(dent), x = g.origin[0] + a_.step() * static_cast<double>(dent.i);
    return std::exp((std::min(dent.depth, deep) - shallowest_dent) / growth -
                    0.5 * square((z - usual) / spread) - 0.5 * square((x - trunk_.middle(z)) / from_midline));
  };
  const std::vector<Dent> all = dents(from, to);
  const auto best = std::max_element(all.begin(), all.end(),
                                     [&](const Dent& a, const Dent& b) { return chance(a) < chance(b); });
  if (best == all.end() || chance(*best) < no_dent) return std::nullopt;
  double sum = no_dent, squares = no_dent * (square(spread) + square(usual - level(*best)));
  for (const Dent& dent : all)
    sum += chance(dent), squares += chance(dent) * square(level(dent) - level(*best));
  // centroid of the dent, weighted by depth
  const auto half = std::lround(15 / a_.step());
  Vector3d middle = Vector3d::Zero();
  double weight = 0;
  bool all_shows = true;
  for (auto k = best->k - half; k <= best->k + half; ++k)
    for (auto i = best->i - half; i <= best->i + half; ++i) {
      const auto here = dent(i, k, 2);
      all_shows = all_shows && here;
      const double w = here.value_or(0) - 0.25 * best->depth;
      if (w <= 0) continue;
      middle += w * g.point(Vector3d(static_cast<double>(i), 0, static_cast<double>(k)));
      weight += w;
    }
  middle /= weight;
  middle[1] = skin(best->i, best->k) - 0.75 * best->depth;  // nearly in the skin's plane
  constexpr double own = 3, half_hidden = 8;                // mm
  return Landmark{middle, std::sqrt(square(all_shows ? own : half_hidden) + squares / sum), 0,
                  "skin: the navel's dent"};
}

}  // namespace borelli
