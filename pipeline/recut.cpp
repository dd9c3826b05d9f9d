#include "pipeline/recut.hpp"

#include <algorithm>
#include <cmath>
#include <random>

namespace borelli {

using Eigen::Matrix3d, Eigen::Vector3d;

Recut::Recut(const LabelMap& labels, const GreyVolume& volume, const GreyWeights& weights,
             const PartPlanes& nominal, double deviation) {
  const Grid& g = labels.grid;
  std::size_t body = 0;
  for (const auto label : labels.voxels) body += label != 0;
  const auto stride = std::max<std::int64_t>(1, std::lround(std::cbrt(static_cast<double>(body) / 4e5)));
  const double share = static_cast<double>(stride * stride * stride), cell = share * g.voxel_volume() * 1e-9;
  const double near = 6 * deviation + 5;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> within(-0.5, 0.5);
  std::uniform_int_distribution<std::int64_t> step(0, stride - 1);
  for (std::int64_t k0 = 0; k0 < g.size[2]; k0 += stride)
    for (std::int64_t j0 = 0; j0 < g.size[1]; j0 += stride)
      for (std::int64_t i0 = 0; i0 < g.size[0]; i0 += stride) {
        const std::int64_t i = i0 + step(random), j = j0 + step(random), k = k0 + step(random);
        if (!g.holds(i, j, k)) continue;
        const std::uint8_t label = labels.at(i, j, k);
        if (label == 0 || label > 16) continue;
        const Vector3d p =
            g.point(Vector3d(static_cast<double>(i) + within(random), static_cast<double>(j) + within(random),
                             static_cast<double>(k) + within(random)));
        if (nominal.distance(label, p) > near) continue;
        const double density = weights[static_cast<std::size_t>(volume.at(i, j, k) + 32768)];
        samples_.push_back(
            {p, cell, density * cell, label, static_cast<std::uint8_t>(nominal.part(label, p))});
      }
}

std::array<PartGain, 17> Recut::gains(const PartPlanes& planes) const {
  std::array<PartGain, 17> gains{};
  for (const Sample& s : samples_) {
    const int now = planes.part(s.label, s.point);
    if (now == s.nominal) continue;
    const Vector3d p = 1e-3 * s.point;
    const auto add = [&](PartGain& gain, double sign) {
      gain.volume += sign * s.volume;
      gain.mass += sign * s.mass;
      gain.first += sign * s.mass * p;
      gain.second += sign * s.mass * p * p.transpose();
    };
    add(gains[static_cast<std::size_t>(now)], 1);
    add(gains[s.nominal], -1);
  }
  return gains;
}

Inertial with_gain(const Inertial& part, const PartGain& gain) {
  // second moments about the origin, from the tensor: C = tr(I)/2 - I
  const Matrix3d about_centre = 0.5 * part.tensor.trace() * Matrix3d::Identity() - part.tensor;
  const Matrix3d second = about_centre + part.mass * part.centre * part.centre.transpose() + gain.second;
  Inertial now;
  now.mass = part.mass + gain.mass;
  if (!(now.mass > 0.05 * part.mass)) return part;  // a draw that leaves nothing of it tells nothing
  now.centre = (part.mass * part.centre + gain.first) / now.mass;
  const Matrix3d C = second - now.mass * now.centre * now.centre.transpose();
  now.tensor = C.trace() * Matrix3d::Identity() - C;
  return now;
}

}  // namespace borelli
