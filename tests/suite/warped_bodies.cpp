#include "tests/suite/warped_bodies.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <unordered_map>

#include "inertia/moments.hpp"
#include "samples/phantom_builder.hpp"
#include "samples/scanner_effects.hpp"
#include "segmentation/vocabulary/part_planes.hpp"
#include "tests/suite/body_raster.hpp"
#include "tests/suite/warped_scan.hpp"
#include "tests/suite/warped_tissue.hpp"
#include "threads/slabs.hpp"

namespace borelli::suite {
namespace {

using Eigen::Vector3d, Eigen::Vector3f;

std::vector<Vector3f> moved_corners(const LabelledBody& body, const BodyMap& map) {
  const BodyLattice& lattice = body.lattice;
  std::vector<Vector3f> out(lattice.rest.size());
  in_slabs(std::ssize(out), 0, [&](std::int64_t first, std::int64_t last) {
    for (auto c = static_cast<std::size_t>(first); c < static_cast<std::size_t>(last); ++c)
      out[c] = map(lattice.rest[c].cast<double>(), lattice.share[c], lattice.lift[c]).cast<float>();
  });
  return out;
}

// Corners of the remaining tissue.
std::vector<Vector3f> corners_there(const LabelledBody& body, const WarpedTissue& tissue,
                                    const std::vector<Vector3f>& corner) {
  std::vector<std::uint8_t> there(corner.size());
  for (std::size_t n = 0; n < tissue.gone.size(); ++n)
    if (!tissue.gone[n])
      for (const std::uint32_t c : body.lattice.corners[n]) there[c] = 1;
  std::vector<Vector3f> out;
  for (std::size_t c = 0; c < corner.size(); ++c)
    if (there[c]) out.push_back(corner[c]);
  return out;
}

// The part at each voxel of a raster, 0 outside and for objects.
LabelMap part_labels(const LabelledBody& body, const WarpedTissue& tissue, const BodyRaster& raster,
                     const PartPlanes& planes) {
  LabelMap out;
  out.grid = raster.grid;
  for (const Part& part : parts) out.names.emplace_back(part.name);
  out.voxels.resize(raster.source.size());
  each_slice(out.grid.size[2], 0, [&](std::int64_t k) {
    for (std::int64_t j = 0; j < out.grid.size[1]; ++j)
      for (std::int64_t i = 0; i < out.grid.size[0]; ++i) {
        const std::size_t o = out.grid.offset(i, j, k);
        const std::uint32_t n = raster.source[o];
        if (n == 0 || tissue.thing[n - 1]) continue;
        out.voxels[o] = static_cast<std::uint8_t>(planes.part(body.owner[n - 1], out.grid.point(i, j, k)));
      }
  });
  return out;
}

std::array<Inertial, parts.size()> inertials(const LabelMap& labels, const BodyRaster& raster,
                                             const WarpedTissue& tissue) {
  Volume<std::int16_t> density{raster.grid, std::vector<std::int16_t>(raster.source.size())};
  for (std::size_t o = 0; o < density.voxels.size(); ++o)
    if (raster.source[o]) density.voxels[o] = tissue.density[raster.source[o] - 1];
  const auto moments = *label_moments(
      labels, density, *density_weights(Quantity::density_kgm3, *density_curve(default_density_curve)));
  std::array<Inertial, parts.size()> out{};
  for (std::size_t n = 1; n < out.size(); ++n)
    out[n] = to_inertial(moments[n], raster.grid, Sampling::points);
  return out;
}

using Samples = std::array<int, 3>;

// How many points of the body a voxel's value averages along each axis of the grid.
Samples samples_in(const Vector3d& spacing) {
  constexpr double apart = 1.7;  // mm, about the breadth of the bodies' own voxels
  Samples out;
  for (int c = 0; c < 3; ++c)
    out[std::size_t(c)] = std::max(1, static_cast<int>(std::lround(spacing[c] / apart)));
  return out;
}

// The grid of these points.
Grid finer(Grid grid, const Samples& samples) {
  for (int c = 0; c < 3; ++c) {
    const int n = samples[std::size_t(c)];
    grid.axes.col(c) /= n;
    grid.origin -= 0.5 * (n - 1) * grid.axes.col(c);
    grid.size[std::size_t(c)] *= n;
  }
  return grid;
}

void clear_outside_view(LabelMap& labels, double diameter) {
  if (diameter <= 0) return;
  const Grid& g = labels.grid;
  const Vector3d middle(0.5 * double(g.size[0] - 1), 0.5 * double(g.size[1] - 1), 0);
  for (std::int64_t j = 0; j < g.size[1]; ++j)
    for (std::int64_t i = 0; i < g.size[0]; ++i)
      if ((g.axes * (Vector3d(double(i), double(j), 0) - middle)).norm() > 0.5 * diameter)
        for (std::int64_t k = 0; k < g.size[2]; ++k) labels.at(i, j, k) = 0;
}

void quantise(GreyVolume& grey, double low, double high) {
  for (auto& value : grey.voxels) {
    const double step = std::round(255 * (std::clamp<double>(value, low, high) - low) / (high - low));
    value = static_cast<std::int16_t>(std::lround(low + step * (high - low) / 255));
  }
}

// What the samples of a voxel say.
struct Exposure {
  double hu = 0;  // sum
  bool metal = false;
  std::array<int, parts.size()> in_part{}, of_bone{};

  void add(int value, int part, int bone) {
    hu += value;
    metal = metal || value == tissue::metal.hu;
    ++in_part[std::size_t(part)], ++of_bone[std::size_t(bone)];
  }
  static std::uint8_t most(const std::array<int, parts.size()>& count) {
    return static_cast<std::uint8_t>(std::max_element(count.begin(), count.end()) - count.begin());
  }
};

// Voxels as means of their samples, then the scanner's effects. Labels are those of most samples.
void expose(const LabelledBody& body, const WarpedTissue& tissue, const BodyRaster& raster,
            const LabelMap& fine, const Samples& samples, const Surroundings& around, const Scanner& scanner,
            const Grid& grid, TrueScan& out) {
  Scan scan;
  scan.grey.grid = scan.labels.grid = out.bones.grid = grid;
  scan.grey.voxels.assign(grid.count(), -1000);
  scan.labels.voxels.assign(grid.count(), 0), out.bones.voxels.assign(grid.count(), 0);
  scan.labels.names = out.bones.names = fine.names;
  std::vector<float> value(grid.count());
  const auto sample = [&](std::int64_t i, std::int64_t j, std::int64_t k, Exposure& into) {
    const std::size_t f = raster.grid.offset(i, j, k);
    const std::uint32_t n = raster.source[f];
    const int part = fine.voxels[f];
    into.add(n ? tissue.hu[n - 1] : around.hu(raster.grid.point(i, j, k)), part,
             n && tissue.bone[n - 1] && part ? body.owner[n - 1] : 0);
  };
  each_slice(grid.size[2], 0, [&](std::int64_t k) {
    for (std::int64_t j = 0; j < grid.size[1]; ++j)
      for (std::int64_t i = 0; i < grid.size[0]; ++i) {
        Exposure all;
        for (int c = 0; c < samples[2]; ++c)
          for (int b = 0; b < samples[1]; ++b)
            for (int a = 0; a < samples[0]; ++a)
              sample(i * samples[0] + a, j * samples[1] + b, k * samples[2] + c, all);
        const std::size_t o = grid.offset(i, j, k);
        value[o] = float(all.hu / (samples[0] * samples[1] * samples[2]));
        if (all.metal) scan.grey.voxels[o] = std::int16_t(tissue::metal.hu);
        scan.labels.voxels[o] = Exposure::most(all.in_part);
        out.bones.voxels[o] = Exposure::most(all.of_bone);
      }
  });
  add_scanner_effects(std::move(value), scanner.effects, scan);
  if (scanner.eight_bits) quantise(scan.grey, scanner.window_low, scanner.window_high);
  clear_outside_view(out.bones, scanner.effects.field_of_view);
  out.grey = std::move(scan.grey), out.labels = std::move(scan.labels);
}

void judge(const std::array<Inertial, parts.size()>& whole, const std::array<Inertial, parts.size()>& seen,
           const Warp& warp, TrueScan& out) {
  for (std::size_t n = 1; n < parts.size(); ++n) {
    PartTruth& truth = out.part[n];
    truth.whole = whole[n], truth.seen = seen[n];
    // a lost part's remainder at its joint's plane does not count
    const bool lost =
        warp.loss && hangs_on(int(n), warp.loss->part) && (int(n) != warp.loss->part || warp.loss->from == 0);
    truth.share = whole[n].mass > 0.02 && !(lost && whole[n].mass < 0.3)
                      ? std::min(1.0, seen[n].mass / whole[n].mass)
                      : 0;
    truth.stump = warp.loss && int(n) == warp.loss->part && warp.loss->from > 0;
    if (lost) truth.stump = truth.share > 0;
    truth.coverage = truth.share >= 0.98    ? Coverage::whole
                     : truth.share <= 0.002 ? Coverage::absent
                                            : Coverage::cut;
  }
}

// Removes landmarks of lost bones.
void lose_landmarks(const Loss& loss, Landmarks& landmarks) {
  const Part& lost = parts[static_cast<std::size_t>(loss.part)];
  const std::string side = lost.name.ends_with("_left") ? "_left" : "_right";
  const std::string joint(lost.joint);
  if (loss.from == 0) landmarks.erase(joint);
  const std::vector<std::string> leg{"knee_medial",      "knee_lateral", "knee", "lateral_malleolus",
                                     "medial_malleolus", "ankle",        "heel", "toe_tip"};
  const std::vector<std::string> arm{"elbow_medial", "elbow_lateral", "elbow",
                                     "wrist",        "metacarpale_3", "dactylion_3"};
  const bool of_leg = lost.name.starts_with("thigh") || lost.name.starts_with("shank");
  const bool upper = lost.name.starts_with("thigh") || lost.name.starts_with("upper_arm");
  const std::vector<std::string>& names = of_leg ? leg : arm;
  for (std::size_t n = upper ? 0 : 3; n < names.size(); ++n) landmarks.erase(names[n] + side);
}

// Excess of tissue of different limbs in 14 mm cells over the cells' volume, mm^3.
template <class Place>
double crowding(const LabelledBody& body, const Place& place) {
  const Grid& g = body.grid;
  const auto limb = [](std::string_view part) {
    const bool arm = part.starts_with("upper_arm") || part.starts_with("forearm") || part.starts_with("hand"),
               leg = part.starts_with("thigh") || part.starts_with("shank") || part.starts_with("foot");
    return (arm ? 1U : leg ? 3U : 0U) + (arm || leg ? unsigned(part.ends_with("_right")) : 0U);
  };
  std::unordered_map<std::int64_t, std::array<int, 5>> cells;
  for (std::size_t n = 0; n < body.voxel.size(); ++n) {
    const std::int64_t o = body.voxel[n];
    if (o % g.size[0] % 3 || o / g.size[0] % g.size[1] % 3 || o / (g.size[0] * g.size[1]) % 2) continue;
    const Vector3d p = place(n) / 14;
    const auto cell = (std::int64_t(std::floor(p.x())) * 4096 + std::int64_t(std::floor(p.y()))) * 4096 +
                      std::int64_t(std::floor(p.z()));
    ++cells[cell][limb(parts[body.owner[n]].name)];
  }
  // the amount that fits into a cell
  const double most = 14 * 14 * 14 / (18 * g.voxel_volume());
  double sum = 0;
  for (const auto& [cell, count] : cells) {
    const int all = count[0] + count[1] + count[2] + count[3] + count[4];
    const int largest = *std::max_element(count.begin(), count.end());
    if (all > largest) sum += std::max(0.0, std::min<double>(all - largest, all - most));
  }
  return sum * 18 * g.voxel_volume();
}

}  // namespace

Landmarks moved_landmarks(const LabelledBody& body, const BodyMap& map) {
  constexpr std::array skin{"vertex", "omphalion", "dactylion_3", "heel", "toe_tip"};
  Landmarks out = body.landmarks;
  for (auto& [name, landmark] : out) {
    const bool on_skin = std::ranges::any_of(skin, [&](const char* stem) { return name.starts_with(stem); });
    double least = 1e18;
    std::size_t nearest = 0;
    for (std::size_t n = 0; n < body.voxel.size(); ++n) {
      if (!on_skin && !body.bone[n]) continue;
      const double d = (body.centre(n) - landmark.point).squaredNorm();
      if (d < least) least = d, nearest = n;
    }
    landmark.point = map(landmark.point, body.lattice.voxel_share[nearest],
                         on_skin ? body.lattice.voxel_lift[nearest] : 0);
  }
  out["mid_hip"].point = 0.5 * (out["hip_left"].point + out["hip_right"].point);
  return out;
}

Warp fitting_warp(const LabelledBody& body, std::uint64_t seed) {
  Warp best;
  double least = 1e18;
  const double at_rest = crowding(body, [&](std::size_t n) { return body.centre(n); });
  for (int attempt = 0; attempt < 6; ++attempt) {
    Warp warp = drawn_warp(seed, attempt);
    const BodyMap map(body.landmarks, warp.motion);
    const auto moved = [&](std::size_t n) {
      return map(body.centre(n), body.lattice.voxel_share[n], body.lattice.voxel_lift[n]);
    };
    const double overlap = crowding(body, moved) - at_rest;
    if (overlap < least) least = overlap, best = warp;
    if (least < 250e3) break;
  }
  return best;
}

WarpedBody warped_body(const LabelledBody& body, const Warp& warp) {
  const BodyMap map(body.landmarks, warp.motion);
  const WarpedTissue tissue = warped_tissue(body, warp);
  const std::vector<Vector3f> corner = moved_corners(body, map);
  const std::vector<Vector3f> there = corners_there(body, tissue, corner);
  TrueScan out;
  out.landmarks = moved_landmarks(body, map);
  const PartPlanes planes(out.landmarks);
  const Grid grid = scan_grid(warp.scanner, out.landmarks, there);
  const Samples samples = samples_in(warp.scanner.spacing);
  std::array<Inertial, parts.size()> seen, whole;
  {
    const BodyRaster raster = rasterise(body, corner, tissue.gone, finer(grid, samples));
    LabelMap labels = part_labels(body, tissue, raster, planes);
    clear_outside_view(labels, warp.scanner.effects.field_of_view);
    seen = inertials(labels, raster, tissue);
    out.overlap = raster.overlap;
    const Surroundings around(warp.scanner.effects, there, out.landmarks.at("xiphion").point.z());
    expose(body, tissue, raster, labels, samples, around, warp.scanner, grid, out);
  }
  if (warp.scanner.view == View::whole && warp.scanner.effects.field_of_view <= 0) {
    whole = seen;
  } else {
    const BodyRaster raster = rasterise(body, corner, tissue.gone, cube_grid(there, 3));
    whole = inertials(part_labels(body, tissue, raster, planes), raster, tissue);
    out.overlap = raster.overlap;
  }
  judge(whole, seen, warp, out);
  if (warp.loss) lose_landmarks(*warp.loss, out.landmarks);
  out.kinds = warp.kinds;
  out.what = fmt::format("{} seed {}: {}; voxels {:.1f} x {:.1f} x {:.1f} mm, noise {:.0f} HU", body.name,
                         warp.seed, fmt::join(warp.kinds, ", "), warp.scanner.spacing.x(),
                         warp.scanner.spacing.y(), warp.scanner.spacing.z(), warp.scanner.effects.noise_hu);
  return out;
}

}  // namespace borelli::suite
