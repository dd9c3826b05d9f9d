// Trials of the deviations in deviations.hpp. A phantom with a known exact table is scanned with another
// density curve than the program's, on a grid, with noise and with landmarks drawn anew each time.
#pragma once

#include <cmath>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "inertia/entries.hpp"
#include "pipeline/body/measure.hpp"
#include "pipeline/body/segment_rows.hpp"
#include "samples/phantom_voxels.hpp"
#include "segmentation/vocabulary/part_planes.hpp"

namespace borelli::test {

struct TrialCount {
  int cases = 0, within = 0;  // of two standard deviations
  double squares = 0;         // of the errors in standard deviations
  void add(double error, double sd) {
    ++cases, within += std::abs(error) <= 2 * sd;
    squares += sd > 0 ? error * error / (sd * sd) : 0;
  }
  double share() const { return static_cast<double>(within) / cases; }
};

// The CT number at which a curve has a density.
inline int hu_at(const DensityCurve& curve, double density) {
  int best = -1000;
  for (int hu = -1000; hu <= 3000; ++hu)
    if (std::abs(curve.at(hu) - density) < std::abs(curve.at(best) - density)) best = hu;
  return best;
}

// Deviation of our segmentation's landmarks, mm, as stated for scans of 2 to 3 mm.
inline double deviation_of(const std::string& name) {
  if (name.starts_with("hip") || name.starts_with("shoulder")) return 2;
  if (name.starts_with("asis")) return 6;
  if (name == "neck" || name.starts_with("spine") || name.starts_with("metacarpale")) return 5;
  return 4;
}

/// Runs one trial and adds its results per entry, over all parts.
inline void try_deviations(const Phantom& exact, std::uint32_t seed, double finest, double coarsest,
                           std::map<std::string, TrialCount>& counts) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::normal_distribution<double> normal;
  Phantom body = exact;
  const auto& curves = density_curves();
  const DensityCurve& truth =
      curves[static_cast<std::size_t>(uniform(random) * static_cast<double>(curves.size()))];
  for (PhantomSolid& solid : body.solids) solid.tissue.hu = hu_at(truth, solid.density_kgm3);
  GridOptions grid;
  for (int c = 0; c < 3; ++c) {
    grid.spacing[c] = finest + (coarsest - finest) * uniform(random);
    grid.offset[c] = uniform(random);
  }
  grid.rotation_deg = Eigen::Vector3d(10 * normal(random), 10 * normal(random), 10 * normal(random)) *
                      (uniform(random) < 0.5 ? 0 : 1);  // half of them along the body
  ScanOptions scan_options;
  scan_options.partial_volume = uniform(random) < 0.7;
  scan_options.blur_mm = scan_options.partial_volume ? 0.5 + uniform(random) : 0;
  scan_options.noise_hu = 30 * uniform(random), scan_options.seed = seed;
  Scan scan = voxelise(body, phantom_grid(body, grid), scan_options);

  Landmarks drawn = exact.landmarks;
  for (auto& [name, landmark] : drawn) {
    landmark.deviation = deviation_of(name);
    if (name != "mid_hip")
      for (int c = 0; c < 3; ++c) landmark.point[c] += landmark.deviation * normal(random);
  }
  drawn["mid_hip"].point = 0.5 * (drawn["hip_left"].point + drawn["hip_right"].point);
  const PartPlanes planes(drawn);
  const Grid& g = scan.labels.grid;
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i)
        if (auto& label = scan.labels.at(i, j, k))
          label = static_cast<std::uint8_t>(planes.part(label, g.point(i, j, k)));

  const auto table = measure(scan.grey, scan.labels, drawn);
  if (!table) throw std::runtime_error(table.error().message());
  const InertiaTable right = make_table({}, rows_of_parts(exact.exact, exact.volume, exact.landmarks));
  for (std::size_t n = 0; n < right.rows.size(); ++n) {
    const auto found = entries_of(*table, table->rows[n]), known = entries_of(right, right.rows[n]);
    for (const EntryDeviation& deviation : table->rows[n].deviations)
      for (std::size_t e = 0; e < known.size(); ++e)
        if (known[e].name == deviation.entry && std::isfinite(known[e].value))
          counts[deviation.entry].add(found[e].value - known[e].value, deviation.total);
  }
}

}  // namespace borelli::test
