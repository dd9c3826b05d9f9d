// What became of one run by one method: stable, or how it failed.
#pragma once

#include <string>
#include <vector>

#include "dynamics/system/system.hpp"

namespace borelli {

/// From good to bad, as maps draw them.
enum class Outcome {
  stable,            ///< the certificate trusts the run
  inaccurate,        ///< it does not, but nothing grows: steps too long for the motion, energy off to and fro
  energy_loss,       ///< energy is off and does not come back: the method damps
  energy_growth,     ///< energy is off and goes on growing
  constraint_drift,  ///< a constraint is violated beyond the certificate's limit
  blow_up,           ///< numbers grew beyond bounds; the run did not come to its end
  not_solved,        ///< a step could not be made (no convergence, no solution), with finite numbers
  refused,           ///< method or settings cannot run this scene at all
  unfinished         ///< not let come to the scene's end within the steps it was given, and sound up to there
};

/// "stable", "energy growth" ...
const char* name_of(Outcome outcome);
std::vector<std::string> outcome_names();

/// Whether a smaller step (tolerance) is called for: energy growth, constraint drift, blow-up, not solved.
bool is_unstable(Outcome outcome);

struct Tried {
  Outcome outcome = Outcome::refused;
  std::string reason = {};  ///< the certificate's, or of the error; empty: stable
  double end = 0;           ///< s: the time that the run was to come to
  long steps = 0, evaluations = 0;
  double energy = 0;      ///< largest drift over what was turned over; NaN: not known
  double constraint = 0;  ///< largest residual of a row, m or rad; NaN: not known
};

/// How long runs are.
struct RunLengths {
  long least = 200;   ///< steps of one length, so that a growth shows: the run may go beyond the scene's end
  long most = 10000;  ///< steps of any kind: the run of a shorter step ends before the scene's end
};

/// Runs the system from its start by `how` with step (fixed methods, made exactly) or tolerance `setting`. A
/// run that goes beyond the scene's end and finds no solution there is made anew to the end alone.
Tried try_run(const System& system, SimulationSettings how, double setting, const RunLengths& lengths = {});

/// What a run that came to its end is, by its certificate's numbers (limits are the certificate's own) and
/// the energy balance of its rows, in quarters of the run: growing is a balance that in all of the last
/// quarter lies above the largest of the first by a fifth, while the energy itself rises from the third
/// quarter to the last by more than what is put in (dampers that take more than a method adds keep it
/// stable); lost what in all of the last stays below half of the largest loss.
Outcome judge(const System& system, const Trajectory& trajectory);

}  // namespace borelli
