#include "segmentation/labelling/seen_border.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "segmentation/grid/work_grid.hpp"

namespace borelli {

using Eigen::Vector3d;

void ScanProfile::add(const Vector3d& from, const Vector3d& to, std::vector<double>& samples) const {
  constexpr double aside = 3;
  const double length = (to - from).norm();
  if (length < 1e-6) return;
  const Vector3d along = (to - from) / length, u = along.unitOrthogonal(), v = along.cross(u);
  for (double s = 0; s < length; s += step) {
    const Vector3d p = from + s * along;
    double sum = 0, count = 0;
    for (const Vector3d& q : {p, Vector3d(p + aside * u), Vector3d(p - aside * u), Vector3d(p + aside * v),
                              Vector3d(p - aside * v)})
      if (double value = 0; sample(scan_, to_index_ * (q - scan_.grid.origin), value))
        sum += hu_of(value, scan_.quantity), ++count;
    samples.push_back(count > 0 ? sum / count : 0);
  }
}

std::optional<double> seen_border(const ScanProfile& profile, const Vector3d& from, const Vector3d& over,
                                  const Vector3d& to, double expected) {
  // Skin close to muscle counts as lean, with the fat between. `into`: how far the search enters such lean
  // tissue, mm. `within`: how far inside it a sheet's middle may lie, mm.
  constexpr double into = 8, within = 3.5;
  constexpr double beside_skin = 3;         // mm: `over` itself may lie at free skin
  constexpr double air = -250, skins = 60;  // HU; HU above the fat beside
  const double first = (over - from).norm();
  std::vector<double> samples;
  if (first < 1e-6 || (to - over).norm() < 1e-6) return std::nullopt;
  profile.add(from - into * (over - from).normalized(), over, samples);
  const std::size_t middle = samples.size();
  profile.add(over, to + into * (to - over).normalized(), samples);
  const auto at = [&](std::size_t n) { return ScanProfile::step * static_cast<double>(n) - into; };
  std::optional<double> best;
  double emptiest = air;
  for (std::size_t n = 0; n < samples.size(); ++n)
    if (samples[n] < emptiest && (samples[middle] > air || std::abs(at(n) - first) > beside_skin))
      emptiest = samples[n], best = at(n);
  if (best) return best;
  std::vector<double> beyond(samples.size());  // least value from here on
  for (std::size_t n = samples.size(); n-- > 0;)
    beyond[n] = n + 1 < samples.size() ? std::min(samples[n], beyond[n + 1]) : samples[n];
  double before = samples.front();
  const double last = first + (to - over).norm() + within;
  for (std::size_t n = 1; n + 1 < samples.size(); ++n) {
    before = std::min(before, samples[n]);
    if (at(n) < -within || at(n) > last) continue;
    if (samples[n] < samples[n - 1] || samples[n] < samples[n + 1] ||
        samples[n] - std::max(before, beyond[n]) < skins)
      continue;
    if (!best || std::abs(at(n) - expected) < std::abs(*best - expected)) best = at(n);
  }
  return best;
}

}  // namespace borelli
