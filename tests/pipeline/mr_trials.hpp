// Trials of tables from MR scans: drawn bodies of known densities, with tissues of spin-echo brightness under
// a coil's field; the table is compared with the exact one.
#pragma once

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "inertia/skin.hpp"
#include "pipeline/body/mr_scan.hpp"
#include "samples/phantom_voxels.hpp"
#include "tests/pipeline/deviation_trials.hpp"

namespace borelli::test {

struct MrTrial {
  Phantom body;
  GreyVolume mr;
  LabelMap labels;
};

/// Draws by the seed: body, densities (a published curve), marrow bright like fat or nearly as dark as
/// cortex, brightness of each tissue within a tenth, field, noise, voxels.
inline MrTrial draw_mr(std::uint32_t seed, double finest, double coarsest) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::normal_distribution<double> normal;
  const auto& curves = density_curves();
  PhantomOptions options;
  options.sex = seed % 2 ? Sex::female : Sex::male;
  options.variation = seed;
  options.density_curve =
      curves[static_cast<std::size_t>(uniform(random) * static_cast<double>(curves.size()))].name;
  options.mass_kg = 55 + 40 * uniform(random);
  MrTrial trial{build_phantom(options).value(), {}, {}};
  const bool bright_marrow = uniform(random) < 0.7;
  std::map<std::string, double, std::less<>> signal;
  for (const auto& [tissue, value] : std::map<std::string, double>{{"air", 0},
                                                                   {"lung", 20},
                                                                   {"fat", 900},
                                                                   {"brain", 420},
                                                                   {"blood", 300},
                                                                   {"muscle", 330},
                                                                   {"liver", 400},
                                                                   {"cartilage", 380},
                                                                   {"spongiosa", bright_marrow ? 800 : 60},
                                                                   {"cortex", 30}})
    signal[tissue] = value * (1 + 0.1 * (uniform(random) - 0.5));
  constexpr int air = -1000;  // outside all solids
  Phantom drawn = trial.body;
  for (PhantomSolid& solid : drawn.solids) {
    const auto it = signal.find(solid.tissue.name);
    solid.tissue.hu = air + static_cast<int>(it == signal.end() ? 330 : it->second);
  }
  GridOptions grid;
  for (int c = 0; c < 3; ++c) grid.spacing[c] = finest + (coarsest - finest) * uniform(random);
  ScanOptions scan_options;
  scan_options.partial_volume = uniform(random) < 0.7;
  scan_options.blur_mm = scan_options.partial_volume ? 0.5 * uniform(random) : 0;
  Scan scan = voxelise(drawn, phantom_grid(drawn, grid), scan_options);
  const double noise = 5 + 15 * uniform(random), a = 0.4 * (2 * uniform(random) - 1),
               b = 0.3 * (2 * uniform(random) - 1);
  const Grid& g = scan.grey.grid;
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        const auto at = [&](std::int64_t n, std::size_t c) {
          return 2 * static_cast<double>(n) / static_cast<double>(g.size[c]) - 1;
        };
        auto& v = scan.grey.at(i, j, k);
        const double bright = (v - air) * (1 + a * at(k, 2) * at(i, 0) + b * at(j, 1));
        v = static_cast<std::int16_t>(
            std::lround(std::hypot(bright + noise * normal(random), noise * normal(random))));
      }
  scan.grey.quantity = Quantity::mr;
  trial.mr = std::move(scan.grey), trial.labels = std::move(scan.labels);
  return trial;
}

/// Runs one trial and adds its results per entry, over all parts and the whole. Labels alternate between the
/// body's own and those limited to the body found in the MR.
inline void try_mr(std::uint32_t seed, double finest, double coarsest,
                   std::map<std::string, TrialCount>& counts, std::map<std::string, TrialCount>& by_part) {
  MrTrial trial = draw_mr(seed, finest, coarsest);
  const auto reading = read_mr(trial.mr);
  if (!reading) throw std::runtime_error(reading.error().message());
  if (seed / 2 % 2) {
    LabelMap grown = grow_skin(trial.labels);
    for (std::size_t o = 0; o < grown.voxels.size(); ++o)
      if (reading->density.voxels[o] == 0) grown.voxels[o] = 0;
    trial.labels.voxels = std::move(grown.voxels);
  }
  MeasureOptions options;
  const GreyVolume density = densities_by_parts(*reading, trial.labels, options);
  const auto table = measure(density, trial.labels, trial.body.landmarks, options);
  if (!table) throw std::runtime_error(table.error().message());
  const InertiaTable right =
      make_table({}, rows_of_parts(trial.body.exact, trial.body.volume, trial.body.landmarks));
  for (std::size_t n = 0; n <= right.rows.size(); ++n) {
    const bool whole = n == right.rows.size();
    const InertiaRow &row = whole ? table->whole : table->rows[n],
                     &exact = whole ? right.whole : right.rows[n];
    const auto found = entries_of(*table, row), known = entries_of(right, exact);
    for (const EntryDeviation& deviation : row.deviations)
      for (std::size_t e = 0; e < known.size(); ++e) {
        // lengths come from the landmarks, which are exact here; the whole's share is exact too
        if (known[e].name != deviation.entry || !std::isfinite(known[e].value) ||
            deviation.entry == "length_m" || (whole && deviation.entry == "mass_pct"))
          continue;
        counts[deviation.entry].add(found[e].value - known[e].value, deviation.total);
        if (deviation.entry == "mass_kg")
          by_part[row.part].add(found[e].value - known[e].value, deviation.total);
      }
  }
}

}  // namespace borelli::test
