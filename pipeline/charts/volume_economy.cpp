#include "pipeline/charts/volume_economy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>

#include "inertia/density.hpp"
#include "pipeline/body/measure.hpp"
#include "segmentation/labelling/segments.hpp"

namespace borelli {
namespace {

// mm: longest edges of tried voxels; coarser ones lose the wrists
constexpr double edges[] = {2, 3, 4, 5, 6, 8};

// of all threads together, so that other processes do not count
double processor_seconds() { return double(std::clock()) / CLOCKS_PER_SEC; }

using Tables = std::vector<InertiaTable>;  // by parts_choices

Result<Tables> tables_of(const GreyVolume& volume, const Segmentation& found, const std::string& curve,
                         int threads) {
  Tables out;
  for (const PartsChoice& choice : parts_choices) {
    MeasureOptions how;
    how.density_curve = curve;
    how.deviations = false;
    how.threads = threads;
    how.segments = choose_segments(choice.segments).value();
    auto table = measure(volume, found.labels, found.landmarks, how, completeness_of(found.part));
    if (!table) return tl::unexpected(table.error());
    out.push_back(std::move(*table));
  }
  return out;
}

class Trials {
 public:
  Trials(const GreyVolume& volume, int threads, const std::function<void(double)>& progress)
      : volume_(volume), threads_(threads), progress_(progress) {}

  Result<VolumeEconomy> run(double tolerance) {
    out_.tolerance = tolerance;
    const std::vector<double> steps = grids_to_try(volume_);
    const auto blocks = coarser_voxels(volume_.grid);
    const bool ct = volume_.quantity == Quantity::hu;
    if (ct) out_.curve = default_density_curve;
    todo_ = double(steps.size() + blocks.size() + 1);
    const double begin = processor_seconds();
    auto found = found_on(volume_, steps.back());
    if (!found) return tl::unexpected(found.error());
    auto tables = tables_of(volume_, *found, "", threads_);
    if (!tables) return tl::unexpected(tables.error());
    reference_ = std::move(*tables);
    out_.warnings = in_sentences(found->warnings);
    const auto& doubts = reference_.front().warnings;
    out_.warnings.insert(out_.warnings.end(), doubts.begin(), doubts.end());
    VolumeTrial whole{.of = VolumeTrial::Of::work_grid, .size = steps.back(), .name = name_of(steps.back())};
    whole.seconds = processor_seconds() - begin;
    keep(whole, reference_);
    whole.of = VolumeTrial::Of::voxels;
    whole.size = volume_.grid.spacing().maxCoeff();
    whole.name = name_of(volume_.grid);
    keep(std::move(whole), reference_);
    done();
    for (auto step = steps.rbegin() + 1; step != steps.rend(); ++step)
      add(VolumeTrial::Of::work_grid, *step, name_of(*step), volume_, *step);
    for (const auto& factors : blocks) {
      const GreyVolume coarse = coarsened(volume_, factors);
      add(VolumeTrial::Of::voxels, coarse.grid.spacing().maxCoeff(), name_of(coarse.grid), coarse,
          steps.back());
    }
    if (ct)
      for (const DensityCurve& curve : density_curves()) add_curve(curve.name, *found);
    return std::move(out_);
  }

 private:
  static std::string name_of(double step) { return fmt::format("{:.3g} mm", step); }
  static std::string name_of(const Grid& grid) {
    const Eigen::Vector3d edge = grid.spacing();
    return fmt::format("{:.3g} x {:.3g} x {:.3g} mm", edge[0], edge[1], edge[2]);
  }

  void done() { progress_(std::min(1., ++done_ / todo_)); }

  Result<Segmentation> found_on(const GreyVolume& volume, double step) const {
    SegmentOptions options;
    options.step = step;
    options.threads = threads_;
    return segment(volume, options);
  }

  void keep(VolumeTrial trial, const Result<Tables>& tables) {
    if (tables)
      for (std::size_t i = 0; i < tables->size(); ++i)
        trial.errors.push_back(entry_errors((*tables)[i], reference_[i]));
    else
      trial.reason = tables.error().message();
    out_.trials.push_back(std::move(trial));
  }

  void add(VolumeTrial::Of of, double size, const std::string& name, const GreyVolume& volume, double step) {
    VolumeTrial trial{.of = of, .size = size, .name = name};
    const double begin = processor_seconds();
    const auto found = found_on(volume, step);
    const auto tables =
        found ? tables_of(volume, *found, "", threads_) : Result<Tables>(tl::unexpected(found.error()));
    trial.seconds = processor_seconds() - begin;
    keep(std::move(trial), tables);
    done();
  }

  void add_curve(const std::string& name, const Segmentation& found) {
    VolumeTrial trial{.of = VolumeTrial::Of::density_curve, .name = name};
    const double begin = processor_seconds();
    const auto tables = tables_of(volume_, found, name, threads_);
    trial.seconds = processor_seconds() - begin;
    keep(std::move(trial), tables);
  }

  const GreyVolume& volume_;
  int threads_;
  const std::function<void(double)>& progress_;
  double done_ = 0, todo_ = 1;
  Tables reference_;
  VolumeEconomy out_;
};

}  // namespace

double VolumeTrial::worst(std::size_t choice) const {
  if (!reason.empty()) return std::numeric_limits<double>::infinity();
  double most = 0;
  for (const EntryErrors& e : errors.at(choice)) most = std::max(most, e.largest());
  return most;
}

const VolumeTrial* VolumeEconomy::next_to_reference() const {
  const VolumeTrial* next = nullptr;
  for (const VolumeTrial& trial : trials)
    if (trial.of == VolumeTrial::Of::work_grid && trial.size > trials.front().size &&
        (!next || trial.size < next->size))
      next = &trial;
  return next;
}

double VolumeEconomy::doubt(std::size_t choice) const {
  const VolumeTrial* next = next_to_reference();
  return next ? next->worst(choice) : 0;
}

const VolumeTrial* VolumeEconomy::pick(VolumeTrial::Of of, std::size_t choice) const {
  const bool known = doubt(choice) <= tolerance;
  double finest = std::numeric_limits<double>::infinity();
  for (const VolumeTrial& trial : trials)
    if (trial.of == of) finest = std::min(finest, trial.size);
  double fails = std::numeric_limits<double>::infinity();
  for (const VolumeTrial& trial : trials)
    if (trial.of == of && (!(trial.worst(choice) <= tolerance) || (!known && trial.size > finest)))
      fails = std::min(fails, trial.size);
  const VolumeTrial* best = nullptr;
  for (const VolumeTrial& trial : trials)
    // of similar costs the coarsest is the smallest; beyond a failing one, success would be luck
    if (trial.of == of && trial.size < fails && (!best || trial.size > best->size)) best = &trial;
  return best;
}

GreyVolume coarsened(const GreyVolume& volume, const std::array<std::int64_t, 3>& factors) {
  GreyVolume out;
  out.quantity = volume.quantity;
  out.grid = volume.grid;
  Eigen::Vector3d middle;
  for (int c = 0; c < 3; ++c) {
    out.grid.size[c] = volume.grid.size[c] / factors[c];
    out.grid.axes.col(c) *= double(factors[c]);
    middle[c] = 0.5 * double(factors[c] - 1);
  }
  out.grid.origin = volume.grid.point(middle);
  out.voxels.resize(out.grid.count());
  const double count = double(factors[0] * factors[1] * factors[2]);
  for (std::int64_t k = 0; k < out.grid.size[2]; ++k)
    for (std::int64_t j = 0; j < out.grid.size[1]; ++j)
      for (std::int64_t i = 0; i < out.grid.size[0]; ++i) {
        std::int64_t sum = 0;
        for (std::int64_t c = 0; c < factors[2]; ++c)
          for (std::int64_t b = 0; b < factors[1]; ++b)
            for (std::int64_t a = 0; a < factors[0]; ++a)
              sum += volume.at(i * factors[0] + a, j * factors[1] + b, k * factors[2] + c);
        out.at(i, j, k) = std::int16_t(std::lround(double(sum) / count));
      }
  return out;
}

std::vector<std::array<std::int64_t, 3>> coarser_voxels(const Grid& grid) {
  const Eigen::Vector3d spacing = grid.spacing();
  std::vector<std::array<std::int64_t, 3>> out;
  std::array<std::int64_t, 3> before{1, 1, 1};
  for (const double edge : edges) {
    std::array<std::int64_t, 3> factors{};
    for (int c = 0; c < 3; ++c) factors[c] = std::max<std::int64_t>(1, std::lround(edge / spacing[c]));
    bool fits = factors != before;
    for (int c = 0; c < 3; ++c) fits = fits && grid.size[c] / factors[c] >= 8;
    if (!fits) continue;
    out.push_back(factors);
    before = factors;
  }
  return out;
}

Result<VolumeEconomy> volume_economy(const GreyVolume& volume, double tolerance, int threads,
                                     const std::function<void(double)>& progress) {
  return Trials(volume, threads, progress).run(tolerance);
}

}  // namespace borelli
