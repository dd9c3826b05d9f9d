#include "segmentation/slice_stack.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>
#include <set>

namespace borelli {
namespace {

using Eigen::Vector3d;

// Positions are decimals that scanners round to as little as 0.1 mm: half of that, and some for the sum of
// several.
constexpr double rounding = 0.06;  // mm

std::string place(double along) { return fmt::format("{:.4g} mm", along); }

struct Line {
  std::vector<double> along;  // mm along the normal, from 0
  Vector3d first, direction;  // direction: displacement per mm along the normal
};

Result<Line> line_through(const std::string& where, const std::vector<DicomSlice>& slices) {
  const Vector3d normal = slices.front().normal();
  Line line;
  line.first = *slices.front().position;
  for (const auto& slice : slices) line.along.push_back(normal.dot(*slice.position - line.first));
  line.direction = (*slices.back().position - line.first) / line.along.back();
  double worst = 0;
  for (std::size_t n = 0; n < slices.size(); ++n)
    worst = std::max(worst, (*slices[n].position - line.first - line.along[n] * line.direction).norm());
  if (worst > std::max(rounding, 0.1 * slices.front().column_spacing)) {
    return failure(
        where,
        fmt::format("has slices that are not in one line (one is {:.2g} mm aside); a volume cannot be built "
                    "from them",
                    worst));
  }
  return line;
}

void drop_copies(std::vector<DicomSlice>& slices, std::vector<std::string>& notes) {
  std::set<std::string> seen;
  const auto copy = [&](const DicomSlice& s) {
    return !s.instance_uid.empty() && !seen.insert(s.instance_uid).second;
  };
  const auto copies = std::erase_if(slices, copy);
  if (copies)
    notes.push_back(fmt::format("{} slices are there twice (same instance) and were taken once", copies));
}

void say_tilt(const Grid& grid, std::vector<std::string>& notes) {
  const Vector3d step = grid.axes.col(2), normal = grid.axes.col(0).cross(grid.axes.col(1)).normalized();
  const double tilt =
      std::acos(std::min(1.0, std::abs(step.normalized().dot(normal)))) * 180 / std::numbers::pi;
  if (tilt > 0.05)
    notes.push_back(fmt::format(
        "the slices are tilted by {:.3g} degrees against their sequence (gantry tilt); the grid is sheared",
        tilt));
}

// Even spacing where there is none: the grid's slices among those that are there
Result<void> even_out(const std::string& where, const std::vector<double>& along, SliceStack& stack,
                      double& step) {
  std::vector<double> gaps;
  for (std::size_t n = 1; n < along.size(); ++n) gaps.push_back(along[n] - along[n - 1]);
  const double least = std::ranges::min(gaps), total = along.back();
  // gaps that are whole multiples of the least one: slices are missing; else the spacing changes
  const bool missing = std::ranges::all_of(gaps, [&](double gap) {
    const double times = std::round(gap / least);
    return std::abs(gap - times * least) <= std::max(rounding, 0.05 * least) * times;
  });
  auto sorted = gaps;
  std::ranges::nth_element(sorted, sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2));
  const double common = missing ? least : sorted[sorted.size() / 2];
  const double count = std::round(total / common);
  step = total / count;
  const std::size_t widest = static_cast<std::size_t>(std::ranges::max_element(gaps) - gaps.begin());
  if (gaps[widest] > 4.5 * step && gaps[widest] > 10) {
    return failure(where, fmt::format("misses {} of body between two slices that are {} and {} from the "
                                      "first; it is too much to fill in",
                                      place(gaps[widest]), place(along[widest]), place(along[widest + 1])));
  }
  if (count > 4 * static_cast<double>(along.size()))
    return failure(where, fmt::format("has slices from {} to {} apart; no even spacing fits them",
                                      place(least), place(gaps[widest])));

  stack.grid.size[2] = static_cast<std::int64_t>(count) + 1;
  std::size_t below = 0;
  for (std::int64_t k = 0; k < stack.grid.size[2]; ++k) {
    const double at = std::min(static_cast<double>(k) * step, total);
    while (below + 2 < along.size() && along[below + 1] <= at) ++below;
    stack.sources.push_back(static_cast<double>(below) + (at - along[below]) / gaps[below]);
  }
  if (missing) {
    stack.notes.push_back(fmt::format(
        "{} slices are missing (the first behind slice {}) and were interpolated",
        stack.grid.size[2] - static_cast<std::int64_t>(along.size()),
        std::ranges::find_if(gaps, [&](double gap) { return gap > 1.5 * least; }) - gaps.begin() + 1));
  } else {
    stack.notes.push_back(
        fmt::format("the slices are unevenly spaced, {} to {} apart; they were interpolated to {:.4g} mm",
                    place(least), place(gaps[widest]), step));
  }
  return {};
}

}  // namespace

Result<SliceStack> stack_slices(const std::string& where, std::vector<DicomSlice> slices) {
  SliceStack stack;
  drop_copies(slices, stack.notes);
  if (slices.size() < 2)
    return failure(where, "holds only one slice of a series; a volume needs at least two");
  const Vector3d normal = slices.front().normal();
  std::ranges::stable_sort(slices, {}, [&](const DicomSlice& s) { return normal.dot(*s.position); });
  for (std::size_t n = 1; n < slices.size(); ++n) {
    if (normal.dot(*slices[n].position - *slices[n - 1].position) < 1e-3) {
      return failure(
          where, fmt::format(
                     "has two different slices at one position ({} and {}); give it a folder with one volume",
                     slices[n - 1].path, slices[n].path));
    }
  }
  const auto line = line_through(where, slices);
  if (!line) return tl::unexpected(line.error());

  const double steps = static_cast<double>(slices.size() - 1);
  double step = line->along.back() / steps, off = 0;
  for (std::size_t n = 0; n < slices.size(); ++n)
    off = std::max(off, std::abs(line->along[n] - static_cast<double>(n) * step));
  const DicomSlice& first = slices.front();
  stack.grid.size = {first.columns, first.rows, static_cast<std::int64_t>(slices.size())};
  if (off > std::max(rounding, 0.05 * step)) {
    if (const auto evened = even_out(where, line->along, stack, step); !evened)
      return tl::unexpected(evened.error());
  }
  stack.grid.axes << first.column_spacing * first.along_row, first.row_spacing * first.along_column,
      step * line->direction;
  stack.grid.origin = line->first;
  say_tilt(stack.grid, stack.notes);
  stack.slices = std::move(slices);
  return stack;
}

}  // namespace borelli
