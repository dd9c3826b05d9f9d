// stairs FOLDER OUT: compares our angles and moments with the capture system's for a walk down a stair
// (stairs_case.hpp). Prints a table in Markdown and draws the moments.
#include <fmt/core.h>

#include <fstream>
#include <iostream>
#include <limits>

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

// Draws one curve for us and one for them, each with the right and then the left joint, since one foot's step
// ends before the other's begins.
void draw(const std::vector<StairsCurve>& moments, const std::string& joint, const std::string& file) {
  borelli::Plot plot;
  plot.title = "Down a stair: moments that extend the " + joint;
  plot.x.label = "time (s)";
  plot.y.label = "moment (N m)";
  borelli::Curve ours{.name = "ours"}, theirs{.name = "Plug-in Gait"};
  for (const char* side : {" right", " left"}) {
    const auto one = std::ranges::find(moments, joint + side, &StairsCurve::name);
    for (auto [curve, values] : {std::pair{&ours, &one->ours}, std::pair{&theirs, &one->theirs}}) {
      curve->x.insert(curve->x.end(), one->times.begin(), one->times.end());
      curve->y.insert(curve->y.end(), values->begin(), values->end());
      curve->x.push_back(one->times.back());
      curve->y.push_back(std::numeric_limits<double>::quiet_NaN());  // breaks the line
    }
  }
  plot.curves = {ours, theirs};
  plot.notes = {
      "Left half: the right leg, during the right foot's first step on a plate. Right half: the left leg, "
      "during the left foot's second step. The file has no ground force for the other steps."};
  std::ofstream(file) << borelli::svg(plot);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::cerr
        << "stairs FOLDER OUT: FOLDER holds Movement_trial.c3d and Static_trial.c3d, OUT gets the plots\n";
    return 2;
  }
  const std::string folder = std::string(argv[1]) + "/";
  const StairsCase placed(folder, false), calibrated(folder, true);
  print_table(placed, calibrated);
  const auto moments = calibrated.moments();
  for (const char* joint : {"hip", "knee"})
    draw(moments, joint, argv[2] + fmt::format("/stairs_{}.svg", joint));
}
