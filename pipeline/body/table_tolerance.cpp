#include "pipeline/body/table_tolerance.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "segmentation/files/header_text.hpp"

namespace borelli {
namespace {

constexpr double finest_tried = 2;  // mm
// Estimated error of a grid over its difference from the next coarser one. On phantoms of 2.5 mm the error
// against the finest grid was 0.4 to 1.4 times that difference (grids of 4.5 to 3 mm).
constexpr double caution = 2;
// Landmarks jump between grids, and two grids may agree by chance while a third differs. Xiphion and
// omphalion jumped by 2 to 2.5 mm on grids of 6 to 2 mm, limb joints by a fraction of a voxel.
constexpr double trunk_jump = 2.5, limb_jump = 0.25;  // mm; share of the coarsest voxel edge

double length_of(const InertiaRow& row) {
  if (row.frame && row.frame->length() > 0) return row.frame->length();
  return std::cbrt(row.volume);
}

const InertiaRow* row_of(const InertiaTable& table, const std::string& part) {
  const auto it = std::ranges::find(table.rows, part, &InertiaRow::part);
  return it == table.rows.end() || it->completeness == Completeness::absent ? nullptr : &*it;
}

double largest_of(const std::vector<EntryErrors>& errors) {
  double largest = 0;
  for (const EntryErrors& e : errors) largest = std::max(largest, e.largest());
  return largest;
}

std::string percent(double share) { return fmt::format("{:.2g} %", 100 * share); }

}  // namespace

std::vector<EntryErrors> entry_errors(const InertiaTable& table, const InertiaTable& reference) {
  std::vector<EntryErrors> errors;
  for (const InertiaRow& named : reference.rows) {
    EntryErrors e{named.part, 0, 0, 0};
    const InertiaRow *row = row_of(table, named.part), *known = row_of(reference, named.part);
    if (!row && !known) continue;
    if (!row || !known || row->completeness != known->completeness) {
      e.mass = e.centre = e.moments = 1;
    } else {
      const Eigen::Array3d now = row->inertial.principal().moments,
                           then = known->inertial.principal().moments;
      e.mass = std::abs(row->inertial.mass / known->inertial.mass - 1);
      e.centre = (row->inertial.centre - known->inertial.centre).norm() / length_of(*known);
      e.moments = (now / then - 1).abs().maxCoeff();
    }
    errors.push_back(std::move(e));
  }
  return errors;
}

std::vector<double> grids_to_try(const GreyVolume& volume) {
  const double finest = std::clamp(volume.grid.spacing().minCoeff(), finest_tried, 3.0);
  std::vector<double> steps;
  for (const double step : {6.0, 4.5, 3.5, 2.75})
    if (step > 1.1 * finest) steps.push_back(step);
  steps.push_back(finest);
  return steps;
}

std::vector<EntryErrors> errors_of_jumps(const InertiaTable& table, double coarsest_edge) {
  std::vector<EntryErrors> errors;
  for (const InertiaRow& row : table.rows) {
    if (row.completeness == Completeness::absent) continue;
    const bool limb = row.part.ends_with("_left") || row.part.ends_with("_right");
    // a plane that moves by a share of the length moves the same share of the mass; transverse moments grow
    // with the length's cube and change up to three times as much
    const double share = 1e-3 * (limb ? limb_jump * coarsest_edge : trunk_jump) / length_of(row);
    errors.push_back({row.part, share, 0.75 * share, 2.5 * share});
  }
  return errors;
}

GridPick judged(const GridTable& coarser, const GridTable& here, double tolerance, double coarsest_edge) {
  GridPick pick{tolerance, here.step, 0, false, {}};
  if (!here.table) return pick;
  pick.errors = errors_of_jumps(*here.table, coarsest_edge);
  if (!coarser.table) return pick;
  pick.against = coarser.step;
  for (const EntryErrors& differs : entry_errors(*coarser.table, *here.table)) {
    auto e = std::ranges::find(pick.errors, differs.part, &EntryErrors::part);
    if (e == pick.errors.end()) e = pick.errors.insert(e, {differs.part, 0, 0, 0});
    e->mass = std::max(e->mass, caution * differs.mass);
    e->centre = std::max(e->centre, caution * differs.centre);
    e->moments = std::max(e->moments, caution * differs.moments);
  }
  pick.met = largest_of(pick.errors) <= tolerance;
  return pick;
}

Result<Segmentation> segment_within(const GreyVolume& volume, double tolerance, const SegmentOptions& options,
                                    const MeasureOptions& measuring, GridPick& pick) {
  MeasureOptions bare = measuring;
  bare.deviations = false;
  const auto steps = grids_to_try(volume);
  const double edge = volume.grid.spacing().maxCoeff();
  GridTable before;
  for (std::size_t n = 0; n < steps.size(); ++n) {
    SegmentOptions here = options;
    here.step = steps[n];
    if (options.progress)
      here.progress = [&](double share, std::string_view what) {
        options.progress((static_cast<double>(n) + share) / static_cast<double>(steps.size()), what);
      };
    auto found = segment(volume, here);
    if (!found) return found;
    GridTable now{steps[n], {}};
    if (auto table = measure(volume, found->labels, found->landmarks, bare, completeness_of(found->part)))
      now.table = std::move(*table);
    pick = judged(before, now, tolerance, edge);
    if (pick.met || n + 1 == steps.size()) return found;
    // if jumps alone exceed the tolerance, no coarser grid can meet it: continue with the finest
    const bool hopeless = now.table && largest_of(errors_of_jumps(*now.table, edge)) > tolerance;
    if (hopeless) n = steps.size() - 2;
    before = hopeless ? GridTable{} : std::move(now);
  }
  return failure("segmentation", "no grid could be tried");
}

std::string in_words(const GridPick& pick) {
  const bool jumps = largest_of(pick.errors) > pick.tolerance;
  if (pick.against == 0 && !jumps)
    return fmt::format(
        "grid of {:.3g} mm, the finest: coarser grids find no parts to compare with, so it is unknown "
        "whether it reaches {}",
        pick.step, percent(pick.tolerance));
  EntryErrors worst{};
  std::array<std::string, 3> whose;
  const auto take = [](double& most, double value, std::string& part, const std::string& of) {
    if (value >= most) most = value, part = of;
  };
  for (const EntryErrors& e : pick.errors) {
    take(worst.mass, e.mass, whose[0], e.part);
    take(worst.centre, e.centre, whose[1], e.part);
    take(worst.moments, e.moments, whose[2], e.part);
  }
  const std::string off =
      fmt::format("masses {} ({}), gravity centres {} ({}), principal moments {} ({})", percent(worst.mass),
                  whose[0], percent(worst.centre), whose[1], percent(worst.moments), whose[2]);
  if (pick.met)
    return fmt::format("grid of {:.3g} mm for {}: compared with {:.3g} mm, its largest errors are {}",
                       pick.step, percent(pick.tolerance), pick.against, off);
  if (pick.against == 0)
    return fmt::format(
        "finding the parts in this scan does not reach {}: between grids the landmarks may move enough to "
        "change {}; the finest grid, {:.3g} mm, was used",
        percent(pick.tolerance), off, pick.step);
  return fmt::format(
      "finding the parts in this scan does not reach {}: judged by the difference between grids of {:.3g} "
      "and {:.3g} mm, the finer one, which was used, has errors of up to {}",
      percent(pick.tolerance), pick.against, pick.step, off);
}

nlohmann::json to_json(const GridPick& pick) {
  nlohmann::json errors = nlohmann::json::object();
  for (const EntryErrors& e : pick.errors)
    errors[e.part] = {{"mass", e.mass}, {"centre", e.centre}, {"principal_moments", e.moments}};
  return {{"tolerance", pick.tolerance}, {"work_grid_mm", pick.step},
          {"against_mm", pick.against},  {"met", pick.met},
          {"estimated_errors", errors},  {"in_words", in_words(pick)}};
}

std::string beyond_the_voxels(const InertiaTable& table, double tolerance) {
  constexpr std::array<std::string_view, 3> causes{"noise", "partial_volume", "voxel_size"};
  double worst = 0;
  std::string where;
  int count = 0;
  for (const InertiaRow& row : table.rows) {
    if (row.completeness == Completeness::absent) continue;
    const Eigen::Vector3d moments = row.inertial.principal().moments;
    const auto scale_of = [&](const std::string& entry) {
      if (entry == "mass_kg") return row.inertial.mass;
      if (entry.starts_with("centre_") && entry.ends_with("_m")) return length_of(row);
      for (int n = 0; n < 3; ++n)
        if (entry == fmt::format("principal_I{}_kgm2", n + 1)) return moments[n];
      return 0.0;
    };
    for (const EntryDeviation& deviation : row.deviations) {
      const double scale = scale_of(deviation.entry);
      if (scale == 0) continue;
      double variance = 0;
      for (std::size_t n = 0; n < std::min(table.causes.size(), deviation.by_cause.size()); ++n)
        if (std::ranges::find(causes, table.causes[n]) != causes.end())
          variance += deviation.by_cause[n] * deviation.by_cause[n];
      const double share = std::sqrt(variance) / scale;
      count += share > tolerance;
      if (share > worst) worst = share, where = row.part + " " + deviation.entry;
    }
  }
  if (count == 0) return "";
  return fmt::format(
      "{} is below what this scan's voxels allow: their size, noise and mixed values alone give {} of the "
      "table's entries a larger standard deviation, {} for {}",
      percent(tolerance), count, percent(worst), where);
}

Result<double> parse_tolerance(std::string text, double low, double high) {
  std::string_view number = trimmed(text);
  const bool in_percent = number.ends_with('%');
  if (in_percent) number = trimmed(number.substr(0, number.size() - 1));
  double value = 0;
  const auto read = std::from_chars(number.data(), number.data() + number.size(), value);
  if (in_percent) value /= 100;
  if (read.ec != std::errc() || read.ptr != number.data() + number.size() || !(value >= low && value <= high))
    return bad_use("tolerance " + text, fmt::format("is not between {:g} and {:g} %; write it as 1% or 0.01",
                                                    100 * low, 100 * high));
  return value;
}

}  // namespace borelli
