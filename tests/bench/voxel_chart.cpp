// The chart of error against voxel size, and of time: voxel_chart [FOLDER] [SIZE ...] draws the phantom with
// voxels of 1 to 8 mm (or the given sizes) and measures it by its true labels and by labels found in its grey
// values. Writes error.svg, time.svg, cost.svg (the main curves of both) and voxel_chart.csv.
//
// Errors are against the phantom's exact table: relative for masses and principal moments, and the distance
// over the cube root of the part's volume for gravity centres. A part that is not found has an error of 1, so
// that failures stay in the chart.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <vector>

#include "pipeline/body/measure.hpp"
#include "pipeline/charts/plot.hpp"
#include "samples/phantom_voxels.hpp"
#include "segmentation/labelling/segment.hpp"
#include "segmentation/volume/held_memory.hpp"

namespace borelli {
namespace {

constexpr double failed = 1;

struct Errors {
  double rms = 0, worst = 0;
};

// over all parts, of mass, gravity centre and principal moments
std::array<Errors, 3> errors_of(const InertiaTable& table, const Phantom& phantom) {
  std::array<Errors, 3> all;
  double count = 0;
  for (std::size_t label = 1; label < parts.size(); ++label) {
    const Inertial& exact = phantom.exact[label];
    const auto row = std::ranges::find(table.rows, parts[label].name, &InertiaRow::part);
    std::array<double, 3> off{failed, failed, failed};
    if (row != table.rows.end() && row->inertial.mass > 0) {
      const Eigen::Vector3d moments = row->inertial.principal().moments, known = exact.principal().moments;
      off = {std::abs(row->inertial.mass / exact.mass - 1),
             (row->inertial.centre - exact.centre).norm() / std::cbrt(phantom.volume[label]),
             ((moments - known).array() / known.array()).abs().maxCoeff()};
    }
    for (std::size_t n = 0; n < 3; ++n) {
      all[n].rms += off[n] * off[n];
      all[n].worst = std::max(all[n].worst, off[n]);
    }
    ++count;
  }
  for (Errors& e : all) e.rms = std::sqrt(e.rms / count);
  return all;
}

// processor time of all threads, which other work on the machine hardly changes
double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

struct Sample {
  double size = 0;  // mm
  std::int64_t voxels = 0;
  std::array<Errors, 3> drawn, found;
  double segment_seconds = 0, table_seconds = 0;
};

Sample sample_at(const Phantom& phantom, double size) {
  GridOptions grid;
  grid.spacing.setConstant(size);
  grid.rotation_deg << 3, -2, 4;  // so that no cut is parallel to the voxels
  ScanOptions scanner;
  scanner.noise_hu = 10;
  const Scan scan = voxelise(phantom, phantom_grid(phantom, grid), scanner);
  Sample sample{size, static_cast<std::int64_t>(scan.grey.voxels.size()), {}, {}};
  double begin = processor_seconds();
  sample.drawn = errors_of(measure(scan.grey, scan.labels, phantom.landmarks).value(), phantom);
  sample.table_seconds = processor_seconds() - begin;
  begin = processor_seconds();
  const auto found = segment(scan.grey);
  sample.segment_seconds = processor_seconds() - begin;
  for (Errors& e : sample.found) e = {failed, failed};
  if (found)
    if (const auto table = measure(scan.grey, found->labels, found->landmarks))
      sample.found = errors_of(*table, phantom);
  return sample;
}

void write(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
  fmt::print("{}\n", path.string());
}

// One drawing with the given ones stacked vertically.
std::string stacked(const std::vector<Plot>& plots) {
  std::string inner;
  int height = 0;
  for (const Plot& plot : plots) {
    std::string one = svg(plot);
    const std::string sign = "height='";
    const int own = std::atoi(one.c_str() + one.find(sign) + sign.size());
    inner += one.insert(one.find(' '), fmt::format(" y='{}'", height));
    height += own;
  }
  return fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' width='720' height='{0}' viewBox='0 0 720 {0}'>\n{1}</svg>\n",
      height, inner);
}

// The main curves: error above, time below, over voxel size. (Segmentation takes about the same time for any
// voxel size, so error against time would be a vertical line.)
std::string cost_of(const std::vector<Sample>& samples) {
  const Axis sizes{.label = "voxel edge (mm)",
                   .low = samples.front().size - 0.5,
                   .high = samples.back().size + 0.5,
                   .whole_numbers = true};
  Plot error{.title = "A scan's inertia table: what larger voxels cost",
             .x = sizes,
             .y = {"error against the exact table (%)", true},
             .curves = {}};
  Plot time{.title = "... and what they save", .x = sizes, .y = {"processor time (s)", true}, .curves = {}};
  const auto curve = [&](Plot& plot, const std::string& name, const auto& value_of, const char* unit) {
    Curve line{.name = name, .marks = true};
    for (const Sample& sample : samples) {
      const double value = value_of(sample);
      line.x.push_back(sample.size), line.y.push_back(value);
      line.tips.push_back(fmt::format("{}\nvoxels of {:g} mm: {:.2g} {}", name, sample.size, value, unit));
    }
    plot.curves.push_back(std::move(line));
  };
  for (const auto& [n, name] : {std::pair(0, "mass"), std::pair(2, "principal moments")})
    curve(
        error, fmt::format("{}, parts given", name), [n](const Sample& s) { return 100 * s.drawn[n].rms; },
        "%");
  for (const auto& [n, name] : {std::pair(0, "mass"), std::pair(2, "principal moments")})
    curve(
        error, fmt::format("{}, parts found", name), [n](const Sample& s) { return 100 * s.found[n].rms; },
        "%");
  error.notes = {
      "Root mean square over the sixteen parts of the phantom, drawn with 10 HU of noise on a turned grid; a "
      "part not found counts as 100 %. Gravity centres are off about as much as masses are (error.svg)."};
  curve(
      time, "table", [](const Sample& s) { return s.table_seconds; }, "s");
  curve(
      time, "table and finding the parts",
      [](const Sample& s) { return s.segment_seconds + s.table_seconds; }, "s");
  time.notes = {"Parts are found on a grid of 3 mm, whatever the voxels are."};
  return stacked({error, time});
}

void draw(const std::filesystem::path& folder, const std::vector<Sample>& samples) {
  constexpr std::array names{"mass", "gravity centre", "principal moments"};
  Plot error{"Error against voxel size",
             {"voxel edge (mm)", true},
             {"error, relative to the exact table", true},
             {},
             {}};
  Plot time{"Time against voxel size", {"voxel edge (mm)", true}, {"processor time (s)", true}, {}, {}};
  for (Plot* plot : {&error, &time})
    plot->x.low = 0.9 * samples.front().size, plot->x.high = 1.1 * samples.back().size;
  const auto curve = [&](Plot& plot, const std::string& name, const auto& value_of) {
    Curve line{name};
    line.marks = true;
    for (const Sample& sample : samples) line.x.push_back(sample.size), line.y.push_back(value_of(sample));
    plot.curves.push_back(std::move(line));
  };
  for (std::size_t n = 0; n < names.size(); ++n) {
    curve(error, fmt::format("{}, labels as drawn", names[n]),
          [n](const Sample& s) { return s.drawn[n].rms; });
    curve(error, fmt::format("{}, labels as found", names[n]),
          [n](const Sample& s) { return s.found[n].rms; });
  }
  curve(error, "worst of all, labels as found", [](const Sample& s) {
    return std::max({s.found[0].worst, s.found[1].worst, s.found[2].worst});
  });
  error.notes = {
      "Root mean square over the sixteen parts of the phantom, drawn with 10 HU of noise on a turned grid.",
      "A centre's error is in parts of the cube root of the part's volume. A part not found counts as 1."};
  curve(time, "segment (its own grid: 3 mm)", [](const Sample& s) { return s.segment_seconds; });
  curve(time, "table with deviations", [](const Sample& s) { return s.table_seconds; });
  write(folder / "cost.svg", cost_of(samples));
  write(folder / "error.svg", svg(error));
  write(folder / "time.svg", svg(time));
  std::string table =
      "voxel_mm,voxels,drawn_mass,drawn_centre,drawn_moments,found_mass,found_centre,found_moments,found_"
      "worst,"
      "segment_s,table_s\n";
  for (const Sample& s : samples)
    table += fmt::format(
        "{},{},{:.3g},{:.3g},{:.3g},{:.3g},{:.3g},{:.3g},{:.3g},{:.2f},{:.2f}\n", s.size, s.voxels,
        s.drawn[0].rms, s.drawn[1].rms, s.drawn[2].rms, s.found[0].rms, s.found[1].rms, s.found[2].rms,
        std::max({s.found[0].worst, s.found[1].worst, s.found[2].worst}), s.segment_seconds, s.table_seconds);
  write(folder / "voxel_chart.csv", table);
}

}  // namespace
}  // namespace borelli

int main(int argc, char** argv) {
  borelli::hold_freed_memory();
  using namespace borelli;
  const std::filesystem::path folder = argc > 1 ? argv[1] : "voxel_chart";
  std::vector<double> sizes;
  for (int n = 2; n < argc; ++n) sizes.push_back(std::atof(argv[n]));
  if (sizes.empty()) sizes = {1, 1.5, 2, 3, 4, 5, 6, 7, 8};
  std::ranges::sort(sizes);
  std::filesystem::create_directories(folder);
  const Phantom phantom = build_phantom({}).value();
  std::vector<Sample> samples;
  for (const double size : sizes) {
    samples.push_back(sample_at(phantom, size));
    const Sample& s = samples.back();
    fmt::print("{} mm: mass {:.2e} as drawn, {:.2e} as found; segment {:.1f} s, table {:.1f} s\n", size,
               s.drawn[0].rms, s.found[0].rms, s.segment_seconds, s.table_seconds);
    std::fflush(stdout);
  }
  draw(folder, samples);
}
