#include "pipeline/body/recut.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "segmentation/vocabulary/cuts.hpp"
#include "segmentation/vocabulary/parts.hpp"
#include "threads/slabs.hpp"

namespace borelli {

using Eigen::Matrix3d, Eigen::Vector3d;

namespace {

// Visits about 400 000 points of the parts, each at random within its voxel's box.
template <class Visit>
void sample_parts(const LabelMap& labels, const GreyVolume& volume, const GreyWeights& weights,
                  const Visit& visit) {
  const Grid& g = labels.grid;
  std::size_t body = 0;
  for (const auto label : labels.voxels) body += label != 0;
  const auto stride = std::max<std::int64_t>(1, std::lround(std::cbrt(static_cast<double>(body) / 4e5)));
  const double share = static_cast<double>(stride * stride * stride), cell = share * g.voxel_volume() * 1e-9;
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
        const double density = weights[static_cast<std::size_t>(volume.at(i, j, k) + 32768)];
        visit(CutSample{p, cell, density * cell, label, label});
      }
}

// `now_of`: the part that a sample belongs to after the change
template <class Now>
std::array<PartGain, 17> gains_of(const std::vector<CutSample>& samples, const Now& now_of) {
  std::vector<std::uint8_t> parts(samples.size());
  in_slabs(std::ssize(samples), 0, [&](std::int64_t first, std::int64_t last) {
    for (auto n = static_cast<std::size_t>(first); n < static_cast<std::size_t>(last); ++n)
      parts[n] = static_cast<std::uint8_t>(now_of(samples[n]));
  });
  std::array<PartGain, 17> gains{};
  for (std::size_t n = 0; n < samples.size(); ++n) {
    const CutSample& s = samples[n];
    const std::uint8_t now = parts[n];
    if (now == s.nominal) continue;
    const Vector3d p = 1e-3 * s.point;
    const auto add = [&](PartGain& gain, double sign) {
      gain.volume += sign * s.volume;
      gain.mass += sign * s.mass;
      gain.first += sign * s.mass * p;
      gain.second += sign * s.mass * p * p.transpose();
    };
    add(gains[now], 1);
    add(gains[s.nominal], -1);
  }
  return gains;
}

// `follows`: how far the flesh moves with the bones' border. Measured as volumes on two phantoms (man and
// woman), segmented again with each disc 15 mm higher and lower: 1.3, 0.27 to 0.38, 0.35 to 0.47 (means of
// both directions). Ribs and iliac wings do not move and overlap the lumbar spine.
struct Disc {
  const char* landmark;
  std::uint8_t above, below;
  double follows;
};
constexpr std::array<Disc, 3> axial_discs{
    {{"neck", part_label("head"), part_label("upper_trunk"), 1.3},
     {"t12_l1", part_label("upper_trunk"), part_label("middle_trunk"), 0.4},
     {"l5_s1", part_label("middle_trunk"), part_label("lower_trunk"), 0.4}}};

}  // namespace

Recut::Recut(const LabelMap& labels, const GreyVolume& volume, const GreyWeights& weights,
             const PartPlanes& nominal, double deviation) {
  const double near = 6 * deviation + 5;
  sample_parts(labels, volume, weights, [&](const CutSample& sample) { samples_.push_back(sample); });
  in_slabs(std::ssize(samples_), 0, [&](std::int64_t first, std::int64_t last) {
    for (auto n = static_cast<std::size_t>(first); n < static_cast<std::size_t>(last); ++n) {
      CutSample& s = samples_[n];
      if (nominal.distance(s.label, s.point) > near)
        s.label = 0;
      else
        s.nominal = static_cast<std::uint8_t>(nominal.part(s.label, s.point));
    }
  });
  std::erase_if(samples_, [](const CutSample& s) { return s.label == 0; });
}

std::array<PartGain, 17> Recut::gains(const PartPlanes& planes) const {
  return gains_of(samples_, [&](const CutSample& s) { return planes.part(s.label, s.point); });
}

MovedDiscs::MovedDiscs(const LabelMap& labels, const GreyVolume& volume, const GreyWeights& weights,
                       const Landmarks& landmarks)
    : labels_(labels), up_(trunk_axes(landmarks).col(2)) {
  for (const Disc& disc : axial_discs)
    if (const auto it = landmarks.find(disc.landmark); it != landmarks.end()) discs_.insert(*it);
  sample_parts(labels, volume, weights, [&](const CutSample& sample) {
    if (sample.label <= part_label("lower_trunk")) samples_.push_back(sample);
  });
}

std::array<PartGain, 17> MovedDiscs::gains(const Landmarks& moved) const {
  const Grid& g = labels_.grid;
  std::array<PartGain, 17> sum{};
  for (const Disc& disc : axial_discs) {
    const auto from = discs_.find(disc.landmark), to = moved.find(disc.landmark);
    if (from == discs_.end() || to == moved.end()) continue;
    const Vector3d by = disc.follows * (to->second.point - from->second.point).dot(up_) * up_;
    const auto gains = gains_of(samples_, [&](const CutSample& s) -> int {
      if (s.label != disc.above && s.label != disc.below) return s.label;
      const Vector3d index = g.index(s.point - by);
      const auto i = std::lround(index[0]), j = std::lround(index[1]), k = std::lround(index[2]);
      const std::uint8_t there = g.holds(i, j, k) ? labels_.at(i, j, k) : std::uint8_t{0};
      return there == disc.above || there == disc.below ? there : s.label;
    });
    for (std::size_t n = 0; n < sum.size(); ++n) {
      sum[n].volume += gains[n].volume, sum[n].mass += gains[n].mass;
      sum[n].first += gains[n].first, sum[n].second += gains[n].second;
    }
  }
  return sum;
}

Inertial with_gain(const Inertial& part, const PartGain& gain) {
  // second moments about the origin, from the tensor: C = tr(I)/2 - I
  const Matrix3d about_centre = 0.5 * part.tensor.trace() * Matrix3d::Identity() - part.tensor;
  const Matrix3d second = about_centre + part.mass * part.centre * part.centre.transpose() + gain.second;
  Inertial now;
  now.mass = part.mass + gain.mass;
  if (!(now.mass > 0.05 * part.mass))
    return part;  // a draw that leaves almost nothing of the part is useless
  now.centre = (part.mass * part.centre + gain.first) / now.mass;
  const Matrix3d C = second - now.mass * now.centre * now.centre.transpose();
  now.tensor = C.trace() * Matrix3d::Identity() - C;
  return now;
}

}  // namespace borelli
