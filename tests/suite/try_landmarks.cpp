#include <random>
#include <stdexcept>

#include "samples/phantom_voxels.hpp"
#include "segmentation/labelling/segment.hpp"
#include "tests/suite/landmark_trials.hpp"
#include "tests/suite/part_masses.hpp"

namespace borelli::suite {

LandmarkTrial try_landmarks(std::uint64_t seed, double slice) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  PhantomOptions options;
  options.variation = seed;
  options.sex = uniform(random) < 0.5 ? Sex::male : Sex::female;
  options.stature_m = 1.25 + 0.75 * uniform(random);
  options.mass_kg = (18 + 10 * uniform(random)) * *options.stature_m * *options.stature_m;
  const auto body = build_phantom(options);
  if (!body) throw std::runtime_error(body.error().message());
  GridOptions grid;
  grid.spacing = {2, 2, slice};
  for (int c = 0; c < 3; ++c) grid.offset[c] = 2 * uniform(random) - 1;
  ScanOptions scan_options;
  scan_options.partial_volume = uniform(random) < 0.5;
  scan_options.noise_hu = 30 * uniform(random), scan_options.seed = seed;
  const Scan scan = voxelise(*body, phantom_grid(*body, grid), scan_options);
  const auto found = segment(scan.grey);
  if (!found) throw std::runtime_error(found.error().message());

  LandmarkTrial out;
  out.stature_m = *options.stature_m;
  for (const Warning& warning : found->warnings) out.warnings.push_back(warning.text);
  for (const auto& [name, exact] : body->landmarks) {
    const auto it = found->landmarks.find(name);
    if (it != found->landmarks.end())
      out.landmarks.push_back(
          {name, it->second.point - exact.point, it->second.deviation, it->second.source});
  }
  const auto mass = part_masses(found->labels, scan.grey);
  for (std::size_t n = 1; n < parts.size(); ++n) {
    const std::string joint(parts[n].joint);
    if (!joint.empty() && !found->landmarks.contains(joint)) out.lost.push_back(joint);
    out.mass_error[n] = mass[n] / body->exact[n].mass - 1;
  }
  return out;
}

std::string stem_of(const std::string& name) {
  for (const char* side : {"_left", "_right"})
    if (name.ends_with(side)) return name.substr(0, name.size() - std::string(side).size());
  return name;
}

}  // namespace borelli::suite
