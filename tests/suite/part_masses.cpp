#include "tests/suite/part_masses.hpp"

#include "inertia/density.hpp"
#include "inertia/skin.hpp"

namespace borelli::suite {

std::array<double, parts.size()> part_masses(const LabelMap& labels, const GreyVolume& grey) {
  const auto curve = density_curve(default_density_curve);
  const auto weights = density_weights(Quantity::hu, *curve);
  auto moments = *label_moments(labels, grey, *weights);
  if (sampling_by(*mixed_share(labels, grey, *weights)) == Sampling::averages) {
    auto skin = grow_skin(labels);
    for (std::size_t o = 0; o < skin.voxels.size(); ++o)
      if (labels.voxels[o]) skin.voxels[o] = 0;
    const auto straight = density_weights(Quantity::hu, *curve, BelowAir::straight);
    const auto more = *label_moments(skin, grey, *straight);
    for (std::size_t n = 0; n < more.size(); ++n) moments[n] += more[n];
  }
  std::array<double, parts.size()> out{};
  for (std::size_t n = 1; n < parts.size(); ++n) out[n] = moments[n].weight * grey.grid.voxel_volume() * 1e-9;
  return out;
}

}  // namespace borelli::suite
