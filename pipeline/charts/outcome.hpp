// The outcome of one run by one method: stable, or how it failed.
#pragma once

#include <string>
#include <vector>

#include "dynamics/system/system.hpp"

namespace borelli {

/// From good to bad, in the order of the maps.
enum class Outcome {
  stable,            ///< the certificate trusts the run
  inaccurate,        ///< not trusted, but nothing grows: steps too long for the motion, energy oscillates
  energy_loss,       ///< the energy is too low and does not recover: the method damps
  energy_growth,     ///< the energy error keeps growing
  constraint_drift,  ///< a constraint is violated beyond the certificate's limit
  blow_up,           ///< numbers grew beyond bounds; the run did not finish
  not_solved,        ///< a step failed (no convergence, no solution) while all numbers were finite
  refused,           ///< the method or settings cannot run this scene at all
  unfinished         ///< sound so far, but ended by the step limit before the scene's end
};

/// "stable", "energy growth" ...
const char* name_of(Outcome outcome);
std::vector<std::string> outcome_names();

/// Whether the outcome calls for a smaller step (tolerance): energy growth, constraint drift, blow-up, not
/// solved.
bool is_unstable(Outcome outcome);

struct Tried {
  Outcome outcome = Outcome::refused;
  std::string reason = {};  ///< the certificate's or the error's reason; empty: stable
  double end = 0;           ///< s: the intended end time
  long steps = 0, evaluations = 0;
  double energy = 0;      ///< largest energy drift over the turnover; NaN: not known
  double constraint = 0;  ///< largest residual of a row, m or rad; NaN: not known
};

/// Bounds on the number of steps of a run.
struct RunLengths {
  long least = 200;   ///< fixed steps, so that growth shows: the run may go beyond the scene's end
  long most = 10000;  ///< steps of any kind: a run with shorter steps ends before the scene's end
};

/// Runs the system from its start by `how`. `setting` is the step (fixed methods, made exactly) or the
/// tolerance. A run that goes beyond the scene's end and finds no solution there is repeated up to the
/// scene's end.
Tried try_run(const System& system, SimulationSettings how, double setting, const RunLengths& lengths = {});

/// Outcome of a run that finished, from its certificate's numbers and limits and from the energy balance of
/// its rows, in quarters of the run. Energy growth: in the whole last quarter the balance exceeds the largest
/// value of the first by a fifth, and the energy itself rises from the third quarter to the last by more than
/// the work put in. (Dampers that remove more than the method adds keep the run stable.) Energy loss: in the
/// whole last quarter the balance stays below half of the largest loss.
Outcome judge(const System& system, const Trajectory& trajectory);

}  // namespace borelli
