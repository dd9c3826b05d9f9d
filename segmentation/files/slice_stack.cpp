#include "segmentation/files/slice_stack.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <string_view>

namespace borelli {
namespace {

using Eigen::Vector3d;

// Scanners place slices no better than this, however many decimals they write (mm).
constexpr double rounding = 0.06;

std::string place(double along) { return fmt::format("{:.4g} mm", along); }

// Rounding error of positions as text: half of the last decimal. The finest decimal of all slices counts,
// since writers drop trailing zeros.
Vector3d text_rounding(const std::vector<DicomSlice>& slices) {
  Vector3d finest = slices.front().position_decimal;
  for (const auto& slice : slices) finest = finest.cwiseMin(slice.position_decimal);
  return finest / 2;
}

// y = offset + slope x, by least squares
struct LineFit {
  double slope = 0, offset = 0;
};
LineFit fitted_line(const std::vector<double>& x, const std::vector<double>& y) {
  const auto mean = [](const std::vector<double>& v) {
    return std::accumulate(v.begin(), v.end(), 0.0) / static_cast<double>(v.size());
  };
  const double mean_x = mean(x), mean_y = mean(y);
  double square = 0, product = 0;
  for (std::size_t n = 0; n < x.size(); ++n)
    square += (x[n] - mean_x) * (x[n] - mean_x), product += (x[n] - mean_x) * (y[n] - mean_y);
  const double slope = product / square;
  return {slope, mean_y - slope * mean_x};
}

// Distance (in y) of the furthest point from the best line with a slope near `slope`; ternary search, since
// the distance is convex in the slope.
double least_distance(const std::vector<double>& x, const std::vector<double>& y, double slope) {
  const auto distance = [&](double s) {
    double least = y[0] - s * x[0], most = least;
    for (std::size_t n = 1; n < x.size(); ++n)
      least = std::min(least, y[n] - s * x[n]), most = std::max(most, y[n] - s * x[n]);
    return (most - least) / 2;
  };
  const double reach = 4 * distance(slope) / (x.back() - x.front());
  double low = slope - reach, high = slope + reach;
  for (int n = 0; n < 40; ++n) {
    const double a = low + (high - low) / 3, b = high - (high - low) / 3;
    (distance(a) < distance(b) ? high : low) = distance(a) < distance(b) ? b : a;
  }
  return distance((low + high) / 2);
}

// The even spacing that fits sorted places best.
struct Evenness {
  std::vector<double> index;  // of each slice, in steps
  double step = 0;
  bool even = false;  // every slice lies at index * step
};
Evenness evenness(const std::vector<double>& along, double text) {
  // Coarse decimals are allowed somewhat above a fifth of the step, so that 2.5 mm written to 1 mm passes:
  // from a quarter on, they could hide a missing slice.
  const auto is_even = [&](const std::vector<double>& index, double step) {
    const double allowed = std::max({rounding, 0.05 * step, std::min(1.001 * text, 0.22 * step)});
    return least_distance(index, along, step) <= allowed;
  };
  Evenness e;
  // first without missing slices: to coarse decimals smaller steps with gaps fit as well
  e.index.resize(along.size());
  std::iota(e.index.begin(), e.index.end(), 0.0);
  e.step = fitted_line(e.index, along).slope;
  e.even = is_even(e.index, e.step);
  if (e.even) return e;
  e.index.clear();
  e.step = along.back();
  for (std::size_t n = 1; n < along.size(); ++n) e.step = std::min(e.step, along[n] - along[n - 1]);
  for (int round = 0; round < 4; ++round) {
    std::vector<double> index{0};
    for (std::size_t n = 1; n < along.size(); ++n)
      index.push_back(index.back() + std::max(1.0, std::round((along[n] - along[n - 1]) / e.step)));
    if (index == e.index) break;
    e.index = std::move(index);
    e.step = fitted_line(e.index, along).slope;
  }
  e.even = is_even(e.index, e.step);
  return e;
}

std::vector<double> places_along(const std::vector<DicomSlice>& slices) {
  const Vector3d normal = slices.front().normal(), first = *slices.front().position;
  std::vector<double> along;
  for (const auto& slice : slices) along.push_back(normal.dot(*slice.position - first));
  return along;
}

double text_along(const std::vector<DicomSlice>& slices) {
  return slices.front().normal().cwiseAbs().dot(text_rounding(slices));
}

// Largest distance of a slice position from the line through the first and last, and the largest allowed
// (mm).
std::pair<double, double> aside_of_line(const std::vector<DicomSlice>& slices,
                                        const std::vector<double>& along) {
  const Vector3d first = *slices.front().position,
                 direction = (*slices.back().position - first) / along.back();
  double worst = 0;
  for (std::size_t n = 0; n < slices.size(); ++n)
    worst = std::max(worst, (*slices[n].position - first - along[n] * direction).norm());
  return {worst, std::max(rounding, 0.1 * slices.front().column_spacing) + 2 * text_rounding(slices).norm()};
}

// Compares the slice spacing of the positions with other fields and notes contradictions. Slices may overlap
// or leave gaps, but no scanner makes them thicker than 8 times, or thinner than a fifteenth of, their
// spacing. Errors: SpacingBetweenSlices and SliceLocation agree on another spacing than the positions'.
Result<void> compare_spacings(const std::string& where, const SliceStack& stack,
                              std::vector<std::string>& notes) {
  const Vector3d step = stack.grid.axes.col(2);
  const auto& slices = stack.slices;
  const DicomSlice &first = slices.front(), &last = slices.back();
  const double across = std::abs(first.normal().dot(step)), along = step.norm();
  const auto contradicts = [&](double said) {
    const double allowed = 0.05 + 0.02 * across;  // some programs round to a tenth
    // SliceLocation of oblique slices may be along an axis of the body
    return std::abs(said - across) > allowed && std::abs(said - along) > allowed &&
           std::abs(said - step.cwiseAbs().maxCoeff()) > allowed;
  };
  const auto alike = [&](double DicomSlice::*field) {
    return first.*field > 0 && std::ranges::all_of(slices, [&](const DicomSlice& s) {
             return std::abs(s.*field - first.*field) <= 0.01 * first.*field;
           });
  };
  std::string others;
  const auto add = [&](std::string_view name, double said) {
    others += fmt::format("{}{} {}", others.empty() ? "" : ", ", name, place(said));
  };
  const bool has_between = alike(&DicomSlice::spacing_between) && contradicts(first.spacing_between);
  if (has_between) add("SpacingBetweenSlices gives", first.spacing_between);
  if (first.location && last.location && *first.location != *last.location) {
    const double steps = (*last.position - *first.position).norm() / along;
    const double said = std::abs(*last.location - *first.location) / steps;
    if (contradicts(said)) add("SliceLocation gives", said);
    if (contradicts(said) && has_between && std::abs(said - first.spacing_between) < 0.05 + 0.02 * said)
      return failure(
          where, fmt::format("gives contradictory slice spacings, and masses depend on them: its positions "
                             "give {}, but {}; correct the wrong ones",
                             place(across), others));
  }
  if (alike(&DicomSlice::thickness) &&
      (first.thickness > std::max(8 * across, 1.0) || first.thickness < across / 15))
    add("SliceThickness gives", first.thickness);
  if (!others.empty())
    notes.push_back(
        fmt::format("the slices' positions give a spacing of {}, which was used, but {}; if that is right, "
                    "volumes and masses are wrong by the ratio of the two",
                    place(across), others));
  const double width = std::max(first.column_spacing * first.columns, first.row_spacing * first.rows);
  if (first.modality == "CT" && first.image_type.starts_with("ORIGINAL") &&
      first.reconstruction_diameter > 0 && std::abs(first.reconstruction_diameter - width) > 0.03 * width)
    notes.push_back(
        fmt::format("PixelSpacing gives a picture width of {}, which was used; ReconstructionDiameter gives "
                    "{}; if the latter is right, volumes and masses are wrong by the square of the ratio",
                    place(width), place(first.reconstruction_diameter)));
  return {};
}

void say_tilt(const Grid& grid, std::vector<std::string>& notes) {
  const Vector3d step = grid.axes.col(2), normal = grid.axes.col(0).cross(grid.axes.col(1)).normalized();
  const double tilt =
      std::acos(std::min(1.0, std::abs(step.normalized().dot(normal)))) * 180 / std::numbers::pi;
  if (tilt > 0.05)
    notes.push_back(
        fmt::format("the slices are tilted by {:.3g} degrees against their stacking direction (gantry tilt); "
                    "the grid is sheared",
                    tilt));
}

// Sets the sources of an even grid's slices. `places`: where the given slices lie, in grid steps.
void fill_in(const std::vector<double>& places, SliceStack& stack) {
  std::size_t below = 0;
  for (std::int64_t k = 0; k < stack.grid.size[2]; ++k) {
    const double at = std::min(static_cast<double>(k), places.back());
    while (below + 2 < places.size() && places[below + 1] <= at) ++below;
    stack.sources.push_back(static_cast<double>(below) +
                            (at - places[below]) / (places[below + 1] - places[below]));
  }
}

// Lays an even grid along the line of the slices and notes missing or uneven ones.
Result<void> lay_grid(const std::string& where, const std::vector<double>& along, SliceStack& stack) {
  std::vector<double> gaps;
  for (std::size_t n = 1; n < along.size(); ++n) gaps.push_back(along[n] - along[n - 1]);
  const Evenness e = evenness(along, text_along(stack.slices));
  const double least = std::ranges::min(gaps), total = along.back();
  auto sorted = gaps;
  std::ranges::nth_element(sorted, sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2));
  const double count = e.even ? e.index.back() : std::round(total / sorted[sorted.size() / 2]);
  const double step = e.even ? e.step : total / count;
  const std::size_t widest = static_cast<std::size_t>(std::ranges::max_element(gaps) - gaps.begin());
  if (gaps[widest] > 4.5 * step && gaps[widest] > 10) {
    return failure(where, fmt::format("has a gap of {} between the slices at {} and {} from the first one, "
                                      "too large to interpolate; add the missing slices",
                                      place(gaps[widest]), place(along[widest]), place(along[widest + 1])));
  }
  if (count > 4 * static_cast<double>(along.size()))
    return failure(where, fmt::format("has slices from {} to {} apart; no even spacing fits them",
                                      place(least), place(gaps[widest])));

  stack.grid.size[2] = static_cast<std::int64_t>(count) + 1;
  stack.grid.origin = *stack.slices.front().position;
  stack.grid.axes.col(2) = (*stack.slices.back().position - stack.grid.origin) / count;
  std::vector<double> places = e.index;
  if (!e.even)
    for (std::size_t n = 0; n < along.size(); ++n) places[n] = along[n] / step;
  else
    for (Eigen::Index c = 0; c < 3; ++c) {
      std::vector<double> coordinate;
      for (const auto& slice : stack.slices) coordinate.push_back((*slice.position)[c]);
      const LineFit fit = fitted_line(e.index, coordinate);
      stack.grid.axes(c, 2) = fit.slope, stack.grid.origin[c] = fit.offset;
    }
  if (e.even && e.index.back() == static_cast<double>(along.size() - 1)) return {};
  fill_in(places, stack);
  if (e.even)
    stack.notes.push_back(fmt::format(
        "{} slices are missing (the first behind slice {}) and were interpolated",
        stack.grid.size[2] - static_cast<std::int64_t>(along.size()),
        std::ranges::find_if(gaps, [&](double gap) { return gap > 1.5 * step; }) - gaps.begin() + 1));
  else
    stack.notes.push_back(
        fmt::format("the slices are unevenly spaced, {} to {} apart; they were interpolated to {:.4g} mm",
                    place(least), place(gaps[widest]), step));
  return {};
}

}  // namespace

void sort_along(std::vector<DicomSlice>& slices) {
  const Vector3d normal = slices.front().normal();
  std::ranges::stable_sort(slices, {}, [&](const DicomSlice& s) { return normal.dot(*s.position); });
}

std::optional<std::int64_t> missing_slices(const std::vector<DicomSlice>& slices) {
  if (slices.size() < 2) return 0;
  auto sorted = slices;
  sort_along(sorted);
  const auto along = places_along(sorted);
  if (std::ranges::adjacent_find(along, [](double a, double b) { return b - a < same_place; }) != along.end())
    return std::nullopt;
  const Evenness e = evenness(along, text_along(sorted));
  if (!e.even || e.index.back() > 1e9) return std::nullopt;
  return static_cast<std::int64_t>(e.index.back()) + 1 - std::ssize(slices);
}

bool in_one_line(const std::vector<DicomSlice>& slices) {
  auto sorted = slices;
  sort_along(sorted);
  const auto along = places_along(sorted);
  if (!(along.back() > 0)) return false;
  const auto [aside, allowed] = aside_of_line(sorted, along);
  return aside <= allowed;
}

Result<SliceStack> stack_slices(const std::string& where, std::vector<DicomSlice> slices) {
  if (slices.size() < 2)
    return failure(where, "contains only one slice of a series; a volume needs at least two");
  SliceStack stack;
  sort_along(slices);
  stack.slices = std::move(slices);
  const auto along = places_along(stack.slices);
  for (std::size_t n = 1; n < along.size(); ++n) {
    if (along[n] - along[n - 1] >= same_place) continue;
    const DicomSlice &one = stack.slices[n - 1], &other = stack.slices[n];
    const std::string what =
        fmt::format("contains two different slices at one position ({} and {})", one.path, other.path);
    if (one.location && other.location && std::abs(*one.location - *other.location) > same_place)
      return failure(
          where,
          what + fmt::format(
                     ", though their SliceLocation is {} and {}; the positions in their headers are damaged",
                     place(*one.location), place(*other.location)));
    return failure(where, what + "; give a folder with one volume");
  }
  if (const auto [aside, allowed] = aside_of_line(stack.slices, along); aside > allowed)
    return failure(where, fmt::format("has slices that do not lie along one line (one is {:.2g} mm off), so "
                                      "they form no volume; give one series",
                                      aside));
  const DicomSlice& first = stack.slices.front();
  stack.grid.size = {first.columns, first.rows, 0};
  stack.grid.axes.col(0) = first.column_spacing * first.along_row;
  stack.grid.axes.col(1) = first.row_spacing * first.along_column;
  if (const auto laid = lay_grid(where, along, stack); !laid) return tl::unexpected(laid.error());
  say_tilt(stack.grid, stack.notes);
  if (auto fine = compare_spacings(where, stack, stack.notes); !fine) return tl::unexpected(fine.error());
  return stack;
}

}  // namespace borelli
