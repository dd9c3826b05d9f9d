// A scene in closed form, quick settings and made-up runs for tests of the chart of cost against error.
#pragma once

#include <utility>

#include "pipeline/charts/work_precision.hpp"

namespace borelli::work_precision_test {

// 1 kg on a spring of 4 N/m without gravity, released 1 m from rest: x = cos 2t.
inline Scene oscillator() {
  Scene scene;
  scene.name = "oscillator";
  scene.gravity.setZero();
  Solid mass;
  mass.name = "mass";
  mass.switches = {{.kind = Translation{Eigen::Vector3d::UnitX()},
                    .coordinate = "x",
                    .motion = {},
                    .q = {1},
                    .v = {0},
                    .ranges = {}}};
  mass.inertials = {{1, {0.5, 0, 0}, Eigen::Matrix3d::Identity()}};
  scene.solids = {mass};
  scene.efforts = {{"spring", CoordinateSpring{{"x"}, 4, 0, 0}}};
  scene.simulation.end_time = 5;
  return scene;
}

/// Settings with these methods, each run once, with at most `budget` seconds per run.
inline WorkPrecisionSettings measured_once(std::vector<std::string> methods,
                                           double budget = WorkPrecisionSettings{}.budget) {
  WorkPrecisionSettings out;
  out.methods = std::move(methods);
  out.equations = {Equations::recursive};
  out.repeats = 1;
  out.budget = budget;
  return out;
}

/// A run by the first method, without a scene.
inline WorkPrecisionPoint made(double seconds, double error, bool trusted = true) {
  WorkPrecisionPoint p{.variant = 0, .setting = 1e-3, .finished = true, .trusted = trusted};
  p.seconds = seconds;
  p.evaluations = long(1e6 * seconds);
  p.errors = {error, 0.5 * error, error, 0, 0};
  return p;
}

}  // namespace borelli::work_precision_test
