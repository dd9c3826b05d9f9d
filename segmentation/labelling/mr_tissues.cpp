#include "segmentation/labelling/mr_tissues.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "process/memory.hpp"
#include "segmentation/body/bias_field.hpp"
#include "segmentation/grid/morphology.hpp"
#include "segmentation/grid/noise.hpp"
#include "segmentation/labelling/class_parts.hpp"
#include "segmentation/vocabulary/parts.hpp"
#include "threads/slabs.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

// a coarse grid along the scan's axes; each of its voxels covers a block of n scan voxels
struct Blocks {
  std::array<std::int64_t, 3> n{1, 1, 1};
  Grid grid;
};

Blocks blocks_of(const Grid& g, double spacing) {
  Blocks b;
  b.grid = g;
  for (std::size_t c = 0; c < 3; ++c) {
    const double own = g.spacing()[static_cast<int>(c)];
    b.n[c] = std::clamp<std::int64_t>(std::lround(spacing / own), 1, g.size[c]);
    b.grid.size[c] = (g.size[c] + b.n[c] - 1) / b.n[c];
    const auto n = static_cast<double>(b.n[c]);
    b.grid.origin += 0.5 * (n - 1) * g.axes.col(static_cast<int>(c));
    b.grid.axes.col(static_cast<int>(c)) *= n;
  }
  return b;
}

Volume<float> means(const GreyVolume& volume, const Blocks& b, int threads) {
  const Grid &g = volume.grid, &c = b.grid;
  Volume<float> out{c, std::vector<float>(c.count())};
  in_slabs(c.size[2], threads, [&](std::int64_t k0, std::int64_t k1) {
    for (std::int64_t k = k0; k < k1; ++k)
      for (std::int64_t j = 0; j < c.size[1]; ++j)
        for (std::int64_t i = 0; i < c.size[0]; ++i) {
          double sum = 0, count = 0;
          for (std::int64_t z = k * b.n[2]; z < std::min(g.size[2], (k + 1) * b.n[2]); ++z)
            for (std::int64_t y = j * b.n[1]; y < std::min(g.size[1], (j + 1) * b.n[1]); ++y)
              for (std::int64_t x = i * b.n[0]; x < std::min(g.size[0], (i + 1) * b.n[0]); ++x)
                sum += std::max<int>(0, volume.at(x, y, z)), ++count;
          out.at(i, j, k) = static_cast<float>(sum / count);
        }
  });
  return out;
}

// The threshold between two classes (Otsu 1979, IEEE Trans SMC 9:62), on logarithms, because fat may be
// thirty times as bright as noise; and the mean values on its two sides.
struct Parting {
  double at = 0, below = 0, above = 0;
};

Parting part_in_two(const std::vector<float>& values) {
  constexpr std::size_t bins = 256;
  const double top = std::log1p(*std::ranges::max_element(values));
  std::array<double, bins> count{}, sum{};
  for (const float v : values) {
    const auto bin = std::min(bins - 1, static_cast<std::size_t>(std::log1p(v) / top * bins));
    ++count[bin], sum[bin] += v;
  }
  double all = 0, moment = 0;
  for (std::size_t n = 0; n < bins; ++n) all += count[n], moment += count[n] * static_cast<double>(n);
  double low = 0, low_moment = 0, best = -1;
  std::size_t split = 0;
  for (std::size_t n = 0; n + 1 < bins; ++n) {
    low += count[n], low_moment += count[n] * static_cast<double>(n);
    if (low == 0 || low == all) continue;
    const double apart = low_moment / low - (moment - low_moment) / (all - low);
    if (const double between = low * (all - low) * apart * apart; between > best) best = between, split = n;
  }
  Parting out;
  out.at = std::expm1(top * static_cast<double>(split + 1) / bins);
  double n0 = 0, n1 = 0;
  for (std::size_t n = 0; n < bins; ++n)
    if (n <= split)
      n0 += count[n], out.below += sum[n];
    else
      n1 += count[n], out.above += sum[n];
  out.below /= std::max(1.0, n0), out.above /= std::max(1.0, n1);
  return out;
}

// everything that the outside does not reach: the body with its dark regions
Mask filled(const Mask& mask) {
  Mask open = complement(mask), seed = open;
  const auto& g = mask.grid;
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        // a section of the body at the first or last slice is not an opening
        const bool border = i == 0 || j == 0 || i + 1 == g.size[0] || j + 1 == g.size[1];
        if (!border) seed.at(i, j, k) = 0;
      }
  return complement(reached(seed, open));
}

// the largest bright region, and others at least a tenth as large (two legs), with the dark regions inside
Mask body_of(const Volume<float>& mr, double threshold) {
  Mask bright{mr.grid, std::vector<std::uint8_t>(mr.voxels.size())};
  for (std::size_t o = 0; o < mr.voxels.size(); ++o) bright.voxels[o] = mr.voxels[o] > threshold;
  const Regions regions = connected_regions(bright, 6);
  for (std::size_t o = 0; o < bright.voxels.size(); ++o)
    if (const auto number = regions.number.voxels[o])
      bright.voxels[o] =
          10 * regions.list[static_cast<std::size_t>(number - 1)].voxels >= regions.list[0].voxels;
  return filled(bright);
}

// Three brightness classes: k-means with medians as centres, because a broad rim between fat and muscle
// hardly moves a median. The dark centre is fixed at no signal, because a body may have few dark voxels.
struct Classes {
  std::array<double, 3> centre{};

  std::size_t of(double v) const {
    return v < 0.5 * centre[1] ? 0 : v < 0.5 * (centre[1] + centre[2]) ? 1 : 2;
  }
};

Classes classes_of(std::vector<float> values) {
  std::ranges::sort(values);
  // the median of the values between two limits
  const auto median = [&](double from, double to, double otherwise) {
    const auto first = std::ranges::lower_bound(values, static_cast<float>(from)),
               last = std::ranges::lower_bound(values, static_cast<float>(to));
    return first < last ? static_cast<double>(*(first + (last - first) / 2)) : otherwise;
  };
  const auto quantile = [&](double share) {
    return static_cast<double>(
        values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))]);
  };
  Classes c{{0, quantile(0.4), quantile(0.95)}};
  for (int round = 0; round < 100; ++round) {
    const Classes before = c;
    const double dark = 0.5 * c.centre[1], fat = 0.5 * (c.centre[1] + c.centre[2]);
    c.centre[1] = median(dark, fat, c.centre[1]);
    c.centre[2] = median(fat, 1e30, c.centre[2]);
    if (c.centre == before.centre) break;
  }
  c.centre[0] = median(-1, 0.5 * c.centre[1], 0);
  return c;
}

// trilinear interpolation of a coarse volume at a point, clamped at its edges
float value_at(const Volume<float>& volume, const Vector3d& point) {
  const auto& g = volume.grid;
  const Vector3d index = g.index(point);
  std::array<std::int64_t, 3> low{}, high{};
  Vector3d t;
  for (int c = 0; c < 3; ++c) {
    const auto last = g.size[static_cast<std::size_t>(c)] - 1;
    const double at = std::clamp(index[c], 0.0, static_cast<double>(last));
    low[static_cast<std::size_t>(c)] = static_cast<std::int64_t>(at);
    high[static_cast<std::size_t>(c)] = std::min(last, low[static_cast<std::size_t>(c)] + 1);
    t[c] = at - std::floor(at);
  }
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const bool a = corner & 1, b = corner & 2, c = corner & 4;
    sum += (a ? t[0] : 1 - t[0]) * (b ? t[1] : 1 - t[1]) * (c ? t[2] : 1 - t[2]) *
           static_cast<double>(volume.at(a ? high[0] : low[0], b ? high[1] : low[1], c ? high[2] : low[2]));
  }
  return static_cast<float>(sum);
}

// Isotropic grid along the patient's axes that covers `g`, for distances. A grid of voxel blocks along the
// scan's axes is not exactly isotropic.
Grid isotropic(const Grid& g, double step) {
  Vector3d low = Vector3d::Constant(1e30), high = -low;
  for (int corner = 0; corner < 8; ++corner) {
    Vector3d index;
    for (int c = 0; c < 3; ++c)
      index[c] = corner >> c & 1 ? static_cast<double>(g.size[static_cast<std::size_t>(c)]) - 0.5 : -0.5;
    low = low.cwiseMin(g.point(index)), high = high.cwiseMax(g.point(index));
  }
  Grid out;
  out.axes = step * Eigen::Matrix3d::Identity();
  out.origin = low;
  for (std::size_t c = 0; c < 3; ++c)
    out.size[c] = static_cast<std::int64_t>((high - low)[static_cast<int>(c)] / step) + 2;
  return out;
}

template <class Visit>
void for_each_voxel(const Grid& g, int threads, const Visit& visit) {
  in_slabs(g.size[2], threads, [&](std::int64_t k0, std::int64_t k1) {
    for (std::int64_t k = k0; k < k1; ++k)
      for (std::int64_t j = 0; j < g.size[1]; ++j)
        for (std::int64_t i = 0; i < g.size[0]; ++i) visit(g.offset(i, j, k), g.point(i, j, k));
  });
}

// dark regions more than 20 mm thick: opening by a ball, then the rim that the opening loses
Mask thick_dark(const Volume<float>& mr, const Volume<float>& field, const Mask& body, const Classes& m,
                int threads) {
  constexpr double step = 4, half = 10;
  const Grid g = isotropic(mr.grid, step);
  Mask dark{g, std::vector<std::uint8_t>(g.count(), 0)};
  for_each_voxel(g, threads, [&](std::size_t o, const Vector3d& p) {
    const Vector3d at = mr.grid.index(p);
    const auto i = std::lround(at[0]), j = std::lround(at[1]), k = std::lround(at[2]);
    if (!mr.grid.holds(i, j, k) || !body.at(i, j, k)) return;
    dark.voxels[o] = m.of(static_cast<double>(mr.at(i, j, k) / value_at(field, p))) == 0;
  });
  const Mask core = eroded(dark, half);
  Mask rim = dilated(core, half + step);
  for (std::size_t o = 0; o < rim.voxels.size(); ++o) rim.voxels[o] = rim.voxels[o] && dark.voxels[o];
  return rim;
}

// The brightness of a voxel at the skin that is half body. Skin over fat is darker than fat: there the
// reference is midway between lean tissue and fat.
double skin_edge(const GreyVolume& volume, std::size_t offset, double field, const Classes& m) {
  const Grid& g = volume.grid;
  const auto at = static_cast<std::int64_t>(offset);
  const std::array<std::int64_t, 3> index{at % g.size[0], at / g.size[0] % g.size[1],
                                          at / (g.size[0] * g.size[1])};
  const std::array<std::int64_t, 3> stride{1, g.size[0], g.size[0] * g.size[1]};
  bool beside_fat = false;
  for (std::size_t c = 0; c < 3; ++c)
    for (const std::int64_t by : {-1, 1}) {
      if (index[c] + by < 0 || index[c] + by >= g.size[c]) continue;
      beside_fat =
          beside_fat || m.of(volume.voxels[static_cast<std::size_t>(at + by * stride[c])] / field) == 2;
    }
  return 0.5 * (beside_fat ? 0.5 * (m.centre[1] + m.centre[2]) : m.centre[1]);
}

bool holds(const Mask& mask, const Vector3d& point) {
  const Vector3d at = mask.grid.index(point);
  const auto i = std::lround(at[0]), j = std::lround(at[1]), k = std::lround(at[2]);
  return mask.grid.holds(i, j, k) && mask.at(i, j, k);
}

// uncertainty of the classes' densities, with the effect of noise: the share of voxels it moves to another
// class
std::vector<MrDensity> sure_of(const Classes& m, double noise) {
  const auto beyond = [&](double distance) {
    return noise > 0 ? 0.5 * std::erfc(distance / (noise * std::sqrt(2.0))) : 0;
  };
  const double dark = 0.5 * m.centre[1], fat = 0.5 * (m.centre[1] + m.centre[2]);
  const auto& weighs = mr_tissue_density;
  std::vector<MrDensity> all(mr_density_deviations.begin(), mr_density_deviations.end());
  for (MrDensity& one : all) {
    if (one.density == weighs[1]) one.noise = beyond(dark - m.centre[0]) * (weighs[2] - weighs[1]);
    if (one.density == weighs[2])
      one.noise = beyond(m.centre[1] - dark) * (weighs[1] - weighs[2]) +
                  beyond(fat - m.centre[1]) * (weighs[3] - weighs[2]);
    if (one.density == weighs[3]) one.noise = beyond(m.centre[2] - fat) * (weighs[2] - weighs[3]);
  }
  return all;
}

// The body on voxels of about 3 mm.
struct RoughBody {
  Volume<float> mr;
  Parting parting;
  bool background = true;  // false: nothing is much darker than the rest, so the scan shows only flesh
  Mask mask;
};

Result<RoughBody> find_body(const GreyVolume& volume, int threads) {
  RoughBody out;
  out.mr = means(volume, blocks_of(volume.grid, 3), threads);
  out.parting = part_in_two(out.mr.voxels);
  out.background = out.parting.below < 0.25 * out.parting.above;
  out.mask = out.background ? body_of(out.mr, out.parting.at)
                            : Mask{out.mr.grid, std::vector<std::uint8_t>(out.mr.voxels.size(), 1)};
  std::size_t count = 0;
  for (const auto v : out.mask.voxels) count += v;
  if (static_cast<double>(count) * out.mr.grid.voxel_volume() < 1e5)
    return failure("MR",
                   "the volume contains no body: nothing in it is brighter than its surroundings over a few "
                   "centimetres");
  return out;
}

// the bias field, on a grid coarse enough for N4 to take seconds
Result<Volume<float>> field_over(const GreyVolume& volume, const RoughBody& body, int threads) {
  const Grid& g = volume.grid;
  const double coarse = std::max(3.0, std::cbrt(static_cast<double>(g.count()) * g.voxel_volume() / 40000));
  const Volume<float> shrunken = means(volume, blocks_of(g, coarse), threads);
  Mask mask{shrunken.grid, std::vector<std::uint8_t>(shrunken.grid.count())};
  for_each_voxel(shrunken.grid, threads, [&](std::size_t o, const Vector3d& p) {
    mask.voxels[o] = holds(body.mask, p) &&
                     (!body.background || static_cast<double>(shrunken.voxels[o]) > body.parting.at);
  });
  return bias_field(shrunken, mask);
}

// the body's brightness without bias, from an even sample of the scan's own voxels, fewer than four million
std::vector<float> sampled_brightness(const GreyVolume& volume, const RoughBody& body,
                                      const Volume<float>& field) {
  const Grid& g = volume.grid;
  std::vector<float> sampled;
  const std::size_t stride = std::max<std::size_t>(1, g.count() / 2000000);
  for (std::size_t o = 0; o < g.count(); o += stride) {
    const auto i = static_cast<std::int64_t>(o) % g.size[0],
               j = static_cast<std::int64_t>(o) / g.size[0] % g.size[1],
               k = static_cast<std::int64_t>(o) / (g.size[0] * g.size[1]);
    const Vector3d p = g.point(i, j, k);
    if (holds(body.mask, p))
      sampled.push_back(static_cast<float>(std::max<int>(0, volume.voxels[o])) / value_at(field, p));
  }
  return sampled;
}

// What tells the tissue of a voxel.
struct TissueSigns {
  const GreyVolume& volume;
  RoughBody body;
  Volume<float> field;
  Classes brightness;
  Mask gas;
};

// Whether the body's mask, whose grid is coarse, does not cover all six neighbours of a point.
bool near_outside(const Mask& body, const Vector3d& p) {
  for (int c = 0; c < 3; ++c)
    for (const double side : {-1.0, 1.0}) {
      const Vector3d near = p + side * body.grid.axes.col(c);
      const Vector3d at = body.grid.index(near);
      const auto i = std::lround(at[0]), j = std::lround(at[1]), k = std::lround(at[2]);
      if (body.grid.holds(i, j, k) && !body.at(i, j, k)) return true;
    }
  return false;
}

// The tissue of the voxel at `offset`, centred at p. `rule`: the rule of its class, null if it has none.
MrTissue tissue_at(const TissueSigns& signs, const ClassRule* rule, std::size_t offset, const Vector3d& p) {
  if (rule ? rule->parts == 0 : !holds(signs.body.mask, p)) return MrTissue::outside;
  const auto here = static_cast<double>(value_at(signs.field, p));
  const double bright = std::max<int>(0, signs.volume.voxels[offset]) / here;
  // at the skin a voxel of the coarse mask may hold air
  if (!rule && signs.body.background && bright < skin_edge(signs.volume, offset, here, signs.brightness) &&
      near_outside(signs.body.mask, p))
    return MrTissue::outside;
  const auto tissue = static_cast<MrTissue>(1 + signs.brightness.of(bright));
  return tissue == MrTissue::dark && holds(signs.gas, p) ? MrTissue::gas : tissue;
}

// Writes density and tissue of each voxel in the body.
void put_tissues(const TissueSigns& signs, const ClassLabels* classes, int threads, MrReading& out) {
  const Grid& g = signs.volume.grid;
  out.density = {{g, std::vector<std::int16_t>(g.count(), 0)}, Quantity::density_kgm3};
  out.tissues = {{g, std::vector<std::uint8_t>(g.count(), 0)}, {}};
  for (const Part& part : parts) out.tissues.names.emplace_back(part.name);
  for (std::size_t n = 1; n < mr_tissue_names.size(); ++n) out.tissues.names.emplace_back(mr_tissue_names[n]);
  const LabelMap told = classes ? labels_on(classes->labels, g, threads) : LabelMap{};
  for_each_voxel(g, threads, [&](std::size_t o, const Vector3d& p) {
    const ClassRule* rule = classes && told.voxels[o] ? &classes->rule(told.voxels[o]) : nullptr;
    MrTissue tissue = tissue_at(signs, rule, o, p);
    if (tissue == MrTissue::outside) return;
    int density = mr_tissue_density[static_cast<std::size_t>(tissue)];
    if (rule && rule->tissue == ClassTissue::bone) density = tissue == MrTissue::dark ? 1920 : 1180;
    if (rule && rule->tissue == ClassTissue::lung) density = mr_tissue_density[4], tissue = MrTissue::gas;
    if (rule && rule->tissue == ClassTissue::air) density = 1, tissue = MrTissue::gas;
    out.density.voxels[o] = static_cast<std::int16_t>(density);
    out.tissues.voxels[o] = static_cast<std::uint8_t>(parts.size() - 1 + static_cast<std::size_t>(tissue));
  });
}

// What this reading assumes, with the litres in question.
std::vector<std::string> assumptions(const MrReading& reading, bool background, const Classes& m,
                                     bool classes_given) {
  std::vector<std::string> out;
  if (!background)
    out.push_back("no air was found around the body; everything in the scan was taken as body");
  out.push_back(
      fmt::format("MR has no CT numbers; tissues were classified by brightness after bias field correction "
                  "(fat {:.0f}, lean {:.0f}, dark {:.0f} on average), with fat as the brightest; this is "
                  "wrong where fat is suppressed or fluid is brighter",
                  m.centre[2], m.centre[1], m.centre[0]));
  const double dark = reading.litres[1], thick = reading.litres[4];
  if (dark > 0)
    out.push_back(
        fmt::format("{:.2f} litres of the body are dark: cortical bone, tendon or air, which MR cannot tell "
                    "apart; they weigh {:.2f} kg here, {:.2f} kg as tendon, {:.2f} kg as cortical bone",
                    dark, 1.5 * dark, 1.1 * dark, 1.92 * dark));
  if (thick > 0)
    out.push_back(
        fmt::format("{:.2f} litres are dark and more than 20 mm thick; they count as lung (382 kg/m^3), and "
                    "as dark tissue outside the upper and middle trunk",
                    thick));
  if (!classes_given) out.push_back("bone marrow is bright and counts as fat, so the bones weigh too little");
  return out;
}

}  // namespace

GreyVolume uniform_body(const MrReading& reading) {
  GreyVolume body = reading.density;
  for (auto& v : body.voxels) v = v > 0 ? std::int16_t{1050} : std::int16_t{0};
  return body;
}

Result<MrReading> read_mr(const GreyVolume& volume, const ClassLabels* classes, int threads) {
  if (volume.quantity != Quantity::mr)
    return failure("MR", "this volume does not contain magnetic resonance signal");
  const Grid& g = volume.grid;
  const auto greatest = volume.voxels.empty() ? 0 : *std::ranges::max_element(volume.voxels);
  if (greatest <= 0) return failure("MR", "the volume contains no signal");

  // bytes: density, tissues and labels on this grid, and means on coarser ones
  if (auto fits = admit_memory("MR", "finding its tissues", 6.0 * static_cast<double>(g.count())); !fits)
    return tl::unexpected(fits.error());

  auto body = find_body(volume, threads);
  if (!body) return tl::unexpected(body.error());
  auto field = field_over(volume, *body, threads);
  if (!field) return tl::unexpected(field.error());
  std::vector<float> sampled = sampled_brightness(volume, *body, *field);
  if (sampled.empty()) return failure("MR", "the volume contains no body");
  const Classes m = classes_of(std::move(sampled));
  Mask gas = thick_dark(body->mr, *field, body->mask, m, threads);
  const TissueSigns signs{volume, std::move(*body), std::move(*field), m, std::move(gas)};

  MrReading out;
  put_tissues(signs, classes, threads, out);
  out.noise = estimate_noise(volume, out.tissues);
  out.how_sure = sure_of(m, out.noise);
  for (std::size_t n = 0; n < 3; ++n) out.brightness[n + 1] = m.centre[n];
  for (const auto label : out.tissues.voxels)
    if (label) out.litres[label - (parts.size() - 1)] += g.voxel_volume() * 1e-6;
  out.warnings = assumptions(out, signs.body.background, m, classes != nullptr);
  return out;
}

}  // namespace borelli
