#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

#include "inertia/moments.hpp"
#include "samples/phantom_voxels.hpp"
#include "tests/suite/body_score.hpp"

namespace borelli::suite {
namespace {

struct DrawnPhantom {
  PhantomOptions body;
  GridOptions grid;
  ScanOptions scan;
  std::vector<std::string> kinds{"phantom"};
};

DrawnPhantom draw(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * (double(random() >> 11) * 0x1p-53);
  };
  DrawnPhantom out;
  out.body.variation = seed;
  out.body.sex = uniform(0, 1) < 0.5 ? Sex::male : Sex::female;
  out.body.stature_m = uniform(1.45, 2.05);
  out.body.mass_kg = uniform(19, 32) * *out.body.stature_m * *out.body.stature_m;
  const double plane = uniform(1.6, 3), slice = uniform(2, 8);
  out.grid.spacing = {plane, plane, slice};
  if (slice >= 5) out.kinds.emplace_back("thick slices");
  for (int c = 0; c < 3; ++c) out.grid.offset[c] = uniform(-1, 1);
  out.scan.noise_hu = uniform(5, 60), out.scan.blur_mm = uniform(0.4, 1.2), out.scan.seed = seed;
  out.scan.table = uniform(0, 1) < 0.6, out.scan.blanket = uniform(0, 1) < 0.2;
  if (uniform(0, 1) < 0.25) {
    for (int c = 0; c < 3; ++c) out.grid.rotation_deg[c] = uniform(-12, 12);
    out.kinds.emplace_back("oblique grid");
  }
  return out;
}

}  // namespace

TrueScan drawn_phantom(std::uint64_t seed) {
  DrawnPhantom drawn = draw(seed);
  auto body = build_phantom(drawn.body);
  // a drawn skeleton may be too heavy for the drawn mass
  for (int tries = 0; !body && tries < 8; ++tries) {
    *drawn.body.mass_kg *= 1.07;
    body = build_phantom(drawn.body);
  }
  if (!body) throw std::runtime_error(body.error().message());
  Scan scan = voxelise(*body, phantom_grid(*body, drawn.grid, drawn.scan.table), drawn.scan);
  TrueScan out;
  out.grey = std::move(scan.grey), out.labels = std::move(scan.labels);
  out.landmarks = body->landmarks;
  out.kinds = drawn.kinds;
  out.what = fmt::format("phantom seed {}: voxels {:.1f} x {:.1f} x {:.1f} mm", seed, drawn.grid.spacing.x(),
                         drawn.grid.spacing.y(), drawn.grid.spacing.z());
  for (std::size_t n = 1; n < parts.size(); ++n) {
    PartTruth& truth = out.part[n];
    truth.whole = truth.seen = body->exact[n];
    truth.share = 1, truth.coverage = Coverage::whole;
  }
  return out;
}

}  // namespace borelli::suite
