#include "pipeline/body/class_fit.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "segmentation/grid/work_grid.hpp"
#include "threads/slabs.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

enum Kind : std::size_t { bone, lung, flesh, kinds };
constexpr std::array<double, kinds> weights{1, 1, 0.5};
constexpr std::size_t most = 20000;  // sampled voxels of each kind
constexpr std::size_t least = 500;   // fewest voxels of bone or lung for a judgement
constexpr double in_view = 0.3;      // least share of a kind's voxels inside the scan

std::size_t kind_of(const ClassRule& rule) {
  if (rule.parts == 0) return kinds;
  switch (rule.tissue) {
    case ClassTissue::bone:
      return bone;
    case ClassTissue::lung:
      return lung;
    case ClassTissue::soft:
    case ClassTissue::fat:
      return flesh;
    default:
      return kinds;
  }
}

// HU; partial volume and marrow lie below 120, lungs in expiration below -350
bool shows(std::size_t kind, double hu) {
  return kind == bone ? hu > 120 : kind == lung ? hu < -350 : hu > -200;
}

struct Samples {
  std::array<std::vector<std::array<std::int32_t, 3>>, kinds> at;  // voxels of the label map
  std::array<std::size_t, kinds> of{};                             // number of voxels
};

// Unbiased sample of each kind's voxels (reservoir sampling, Vitter 1985), the same at every call.
Samples draw(const ClassLabels& classes) {
  Samples out;
  std::mt19937 random(1);
  const Grid& g = classes.labels.grid;
  std::size_t o = 0;
  for (std::int32_t k = 0; k < g.size[2]; ++k)
    for (std::int32_t j = 0; j < g.size[1]; ++j)
      for (std::int32_t i = 0; i < g.size[0]; ++i, ++o) {
        const auto label = classes.labels.voxels[o];
        const std::size_t kind = label ? kind_of(classes.rule(label)) : kinds;
        if (kind == kinds) continue;
        auto& drawn = out.at[kind];
        const std::size_t n = out.of[kind]++;
        if (drawn.size() < most)
          drawn.push_back({i, j, k});
        else if (const std::size_t m = random() % (n + 1); m < most)
          drawn[m] = {i, j, k};
      }
  return out;
}

class Agreement {
 public:
  Agreement(const GreyVolume& volume, const ClassLabels& classes)
      : volume_(volume), grid_(classes.labels.grid), samples_(draw(classes)) {}

  bool enough() const {
    return std::max(samples_.of[bone], samples_.of[lung]) >= least &&
           std::max(seen(bone), seen(lung)) >= in_view;
  }

  // Agreement after reversing an axis of the label map (-1: none) and shifting it, mm.
  double at(int axis, const Vector3d& shift) const {
    double sum = 0, weight = 0;
    for (std::size_t kind = 0; kind < kinds; ++kind) {
      if (samples_.of[kind] < least) continue;
      const auto [inside, shown] = count(kind, axis, shift);
      weight += weights[kind];
      // a shift that moves most voxels out of the scan is no evidence
      if (static_cast<double>(inside) >= in_view * static_cast<double>(samples_.at[kind].size()))
        sum += weights[kind] * static_cast<double>(shown) / static_cast<double>(inside);
    }
    return weight > 0 ? sum / weight : 0;
  }

 private:
  struct Count {
    std::size_t inside = 0, shown = 0;
  };

  double seen(std::size_t kind) const {
    const auto all = samples_.at[kind].size();
    return samples_.of[kind] < least
               ? 0
               : static_cast<double>(count(kind, -1, Vector3d::Zero()).inside) / static_cast<double>(all);
  }

  Count count(std::size_t kind, int axis, const Vector3d& shift) const {
    const Eigen::Matrix3d turn = volume_.grid.axes.inverse() * grid_.axes;
    const Vector3d start = volume_.grid.index(grid_.origin + shift);
    Count out;
    for (auto voxel : samples_.at[kind]) {
      if (axis >= 0) {
        const auto a = static_cast<std::size_t>(axis);
        voxel[a] = static_cast<std::int32_t>(grid_.size[a]) - 1 - voxel[a];
      }
      const Vector3d p = start + turn * Vector3d(voxel[0], voxel[1], voxel[2]);
      const auto i = std::lround(p[0]), j = std::lround(p[1]), k = std::lround(p[2]);
      if (!volume_.grid.holds(i, j, k)) continue;
      ++out.inside;
      out.shown += shows(kind, hu_of(volume_.voxels[volume_.grid.offset(i, j, k)], volume_.quantity));
    }
    return out;
  }

  const GreyVolume& volume_;
  const Grid& grid_;
  Samples samples_;
};

struct Best {
  double agreement = -1;
  Vector3d shift = Vector3d::Zero();
};

// Tries shifts of up to 24 mm along each axis, 8 mm apart, then 4 mm about the best; ties go to the smallest
// shift.
Best search(const Agreement& agreement, int axis, int threads) {
  Best best{agreement.at(axis, Vector3d::Zero()), Vector3d::Zero()};
  for (const auto& [step, reach] : {std::pair{8.0, 3}, {4.0, 1}}) {
    const int across = 2 * reach + 1;
    const Vector3d from = best.shift;
    std::vector<Best> tried(static_cast<std::size_t>(across * across * across));
    in_slabs(std::ssize(tried), threads, [&](std::int64_t first, std::int64_t last) {
      for (auto n = static_cast<int>(first); n < last; ++n) {
        const Vector3d by(n % across - reach, n / across % across - reach, n / across / across - reach);
        auto& one = tried[static_cast<std::size_t>(n)];
        one.shift = from + step * by;
        one.agreement = agreement.at(axis, one.shift);
      }
    });
    for (const Best& one : tried)
      if (one.agreement > best.agreement + 1e-9) best = one;
  }
  return best;
}

// Limits chosen on 24 of 48 pairs from the ICRP bodies (tests/pipeline/write_pairs.py, seeds 1 to 48). A
// shift by 12 mm lowers the agreement of genuine pairs by at least 0.13, of other bodies' by at most 0.02. No
// genuine pair agrees better when reversed or shifted by more than 10 mm; shifted maps gain at least 0.24,
// reversed ones 0.18.
constexpr double better = 0.05, far = 10, sharper = 0.08, off = 12;

}  // namespace

bool ClassFit::fits() const {
  if (!judged) return true;
  const double here = shift.norm() <= far ? std::max(agreement, moved) : agreement;
  return agreement - beside >= sharper && moved - here <= better && reversed - here <= better;
}

ClassFit class_fit(const GreyVolume& volume, const ClassLabels& classes, int threads) {
  ClassFit fit;
  if (volume.quantity == Quantity::mr) return fit;
  const Agreement agreement(volume, classes);
  fit.judged = agreement.enough();
  if (!fit.judged) return fit;
  fit.agreement = agreement.at(-1, Vector3d::Zero());
  for (int c = 0; c < 3; ++c)
    for (const double by : {off, -off}) fit.beside += agreement.at(-1, by * Vector3d::Unit(c)) / 6;
  const Best moved = search(agreement, -1, threads);
  fit.moved = moved.agreement, fit.shift = moved.shift;
  for (int axis = 0; axis < 3; ++axis)
    if (const Best best = search(agreement, axis, threads); best.agreement > fit.reversed)
      fit.reversed = best.agreement, fit.axis = axis;
  return fit;
}

std::string in_words(const ClassFit& fit) {
  if (fit.fits()) return "";
  std::string cause = "no nearby position fits better, so they belong to another scan or body";
  if (std::max(fit.moved, fit.reversed) > fit.agreement + better)
    cause = fit.reversed > fit.moved
                ? fmt::format(
                      "with the label map's axis {} reversed it would be {:.0f} %; check whether it is "
                      "mirrored or upside down",
                      "ijk"[fit.axis], 100 * fit.reversed)
                : fmt::format(
                      "moved by {:.0f}, {:.0f}, {:.0f} mm to the left, back and up it would be {:.0f} %; "
                      "check that its origin and spacing are the scan's",
                      fit.shift[0], fit.shift[1], fit.shift[2], 100 * fit.moved);
  return fmt::format(
      "the labels do not fit the scan: the scan confirms {:.0f} % of their bone, lung and flesh; {}",
      100 * fit.agreement, cause);
}

}  // namespace borelli
