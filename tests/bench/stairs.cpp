// Down a stair: our angles and moments beside the capture system's (stairs_case.hpp). Prints a table in Markdown and
// draws the moments. stairs FOLDER OUT.svg
#include <fmt/core.h>

#include <fstream>
#include <iostream>

#include "pipeline/charts/plot.hpp"
#include "tests/pipeline/motion/stairs_case.hpp"

namespace {

using borelli::test::StairsCase;
using borelli::test::StairsCurve;

void print_table(const StairsCase& placed, const StairsCase& calibrated) {
  fmt::print("Marker errors: {:.1f} mm as the standing trial places them, {:.1f} mm as the motion does.\n\n",
             1e3 * placed.marker_error, 1e3 * calibrated.marker_error);
  fmt::print(
      "| joint | range, deg | RMS by the trial, deg | RMS by the motion, deg | moment: RMS, N m | largest, N "
      "m | "
      "correlation |\n| --- | --- | --- | --- | --- | --- | --- |\n");
  const auto before = placed.flexions(), after = calibrated.flexions(), moments = calibrated.moments();
  for (std::size_t j = 0; j < after.size(); ++j) {
    const auto [low, high] = std::ranges::minmax(after[j].theirs);
    double largest = 0;
    for (const double moment : moments[j].theirs) largest = std::max(largest, std::abs(moment));
    fmt::print("| {} | {:.0f} to {:.0f} | {:.2f} | {:.2f} | {:.1f} | {:.0f} | {:.2f} |\n", after[j].name, low,
               high, before[j].rms(), after[j].rms(), moments[j].rms(), largest, moments[j].correlation());
  }
}

void draw(const std::vector<StairsCurve>& curves, const std::string& title, const std::string& axis,
          const std::string& file) {
  borelli::Plot plot;
  plot.title = title;
  plot.x.label = "time (s)";
  plot.y.label = axis;
  for (const StairsCurve& curve : curves) {
    plot.curves.push_back({.name = curve.name + ", ours", .x = curve.times, .y = curve.ours});
    plot.curves.push_back({.name = curve.name + ", Plug-in Gait", .x = curve.times, .y = curve.theirs});
  }
  plot.notes = {
      "While the file counts the ground force: the right foot's first step on a plate, the left one's "
      "second."};
  std::ofstream(file) << borelli::svg(plot);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::cerr << "stairs FOLDER OUT.svg: FOLDER holds Movement_trial.c3d and Static_trial.c3d\n";
    return 2;
  }
  const std::string folder = std::string(argv[1]) + "/";
  const StairsCase placed(folder, false), calibrated(folder, true);
  print_table(placed, calibrated);
  draw(calibrated.moments(), "Down a stair: moments that extend hips and knees", "moment (N m)", argv[2]);
}
