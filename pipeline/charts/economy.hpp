// Finds the smallest model of a scene whose motion stays within a tolerance of the whole model's. Coordinates
// are locked, and so solids merged, one at a time: always the one that adds the least error, as long as the
// requested quantities stay within the tolerance.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "pipeline/charts/motion_quantity.hpp"

namespace borelli {

struct EconomySettings {
  std::vector<std::string> quantities = {};  ///< MotionQuantity's texts; empty: all solids' gravity centres
  double tolerance = 0.01;  ///< lengths over the scene's length (System::length), angles in rad
  int outputs = 200;        ///< least number of evenly spaced times at which motions are compared
  int repeats = 3;          ///< runs per reported time; the median counts
};

/// A model of the scene, and its cost. Time and evaluations are those of one run by dop853 (arkode if dop853
/// fails) at a tenth of the accuracy used for errors.
struct EconomyModel {
  std::string change;      ///< the last locked coordinate, e.g. "coordinate 'wrist'"; empty: the whole model
  double error = 0;        ///< largest error of all quantities against the whole model
  std::string worst = {};  ///< which quantity that is
  int coordinates = 0, bodies = 0, rows = 0;  ///< velocities (also driven), moving bodies, constraint rows
  long evaluations = 0;
  double seconds = 0;  ///< processor time, s; the only number here that differs from run to run
};

/// A change that was refused: its error is too large, or it is impossible.
struct EconomyRefusal {
  std::string change;
  double error = 0;         ///< NaN: see `reason`
  std::string reason = {};  ///< why the change is impossible
};

struct Economy {
  std::string scene;
  double tolerance = 0, accuracy = 0;  ///< `accuracy`: of the computed motions
  std::vector<std::string> quantities;
  int instants = 0;                  ///< number of times at which motions were compared
  bool sparse = false;               ///< the whole model's steps are shorter than the spacing of these times
  std::vector<EconomyModel> models;  ///< the whole model first, then one more change each
  std::vector<EconomyRefusal> refusals;  ///< changes refused at the end
  Scene smallest;
  int runs = 0;          ///< cost of the search: number of motions computed
  long evaluations = 0;  ///< evaluations in all
  double seconds = 0;    ///< processor time of the search, including the timed runs, s
};

/// Motions of the whole model and of each accepted change are computed to a hundredth of the tolerance
/// (SimulationSettings::accuracy chooses method and tolerance, and estimates the error). Each candidate
/// change gets one run. It is tried again only when its earlier error is the smallest of all, and never if
/// that error exceeded ten times the tolerance. A run is aborted at three times the evaluations of the whole
/// model's. When no single change is left, the six with the smallest errors are tried in pairs, since two
/// errors may cancel (a left and a right ankle). Locked coordinates, also driven ones, keep their values in
/// the assembled start. Efforts and constraints that act on locked coordinates only are removed.
///
/// Motions are compared at four times or more per step of the whole model (median step), and at 20000 times
/// at most.
///
/// Errors: the scene does not compile, a quantity does not exist, or the whole model's motion cannot be
/// computed to that accuracy (chaos: shorten the run).
Result<Economy> scene_economy(
    const Scene& scene, const EconomySettings& settings,
    const std::function<void(const std::string&, double)>& progress = [](const std::string&, double) {});

}  // namespace borelli
