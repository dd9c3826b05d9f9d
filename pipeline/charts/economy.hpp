// The smallest model of a scene whose motion stays within a tolerance of the whole one's: coordinates are
// locked, and so solids merged, one at a time, each time what costs the least error, for as long as the
// quantities asked for stay within the tolerance.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "pipeline/charts/motion_quantity.hpp"

namespace borelli {

struct EconomySettings {
  std::vector<std::string> quantities = {};  ///< MotionQuantity's texts; empty: all solids' gravity centres
  double tolerance = 0.01;  ///< of lengths over the scene's (System::length), of angles in rad
  int outputs = 200;        ///< times that motions are compared at, evenly spread: at least
  int repeats = 3;          ///< of the runs whose times are told; their median counts
};

/// A model of the scene, and what it costs. Its time is that of one run by dop853 (arkode where that does not
/// come through) at a tenth of the accuracy that errors are taken with.
struct EconomyModel {
  std::string change;      ///< what was locked last, e.g. "coordinate 'wrist'"; empty: the whole model
  double error = 0;        ///< of all quantities the largest, against the whole model
  std::string worst = {};  ///< which quantity that is
  int coordinates = 0, bodies = 0, rows = 0;  ///< velocities (driven too), moving bodies, constraints' rows
  long evaluations = 0;
  double seconds = 0;  ///< of processor time; the only number here that differs from run to run
};

/// What stays: locking it would be off by so much, or does not work at all.
struct EconomyRefusal {
  std::string change;
  double error = 0;         ///< NaN: there is a reason
  std::string reason = {};  ///< why it cannot be
};

struct Economy {
  std::string scene;
  double tolerance = 0, accuracy = 0;  ///< the latter: that motions were computed with
  std::vector<std::string> quantities;
  int instants = 0;                      ///< motions were compared at
  bool sparse = false;                   ///< the whole model's steps are shorter than these tell apart
  std::vector<EconomyModel> models;      ///< the whole one first, then one change more each
  std::vector<EconomyRefusal> refusals;  ///< what was left in the end
  Scene smallest;
  int runs = 0;          ///< what the search itself took: motions computed,
  long evaluations = 0;  ///< with so many evaluations,
  double seconds = 0;    ///< and of processor time, s, with the runs that times are told by
};

/// Motions are computed to a hundredth of the tolerance (SimulationSettings::accuracy: method and tolerance
/// are chosen, and the error is shown) of the whole model and of each change that is taken; changes are tried
/// by one run each, and tried again only where what they were off by before is the least of all. A change
/// that is off by more than ten times the tolerance is not tried again, and a run that takes three times the
/// evaluations of the whole model's is given up. Where no single change is left that
/// will do, the six that are off least are tried in pairs, for two may undo each other's error (a left and a
/// right ankle). Locked coordinates, driven ones too, rest where the assembled scene starts; efforts and
/// constraints on locked coordinates alone fall away.
///
/// Motions are compared at four instants at least to a step of the whole model's (their median), and at
/// 20000 at most.
///
/// Fails where the scene does not compile, a quantity is not there, or the whole model's motion cannot be
/// computed so well (chaos: shorten the run).
Result<Economy> scene_economy(
    const Scene& scene, const EconomySettings& settings,
    const std::function<void(const std::string&, double)>& progress = [](const std::string&, double) {});

}  // namespace borelli
