// What a simulation says about its own worth. Part of every trajectory.
#pragma once

#include <limits>
#include <string>
#include <vector>

namespace borelli {

struct Certificate;

/// One line on what a trusted certificate vouches for: conservation always, the state only where an accuracy
/// was asked for.
std::string vouches_for(const Certificate& certificate);

/// A quantity that the scene conserves (a component of momentum), and how well the run kept it.
struct Conserved {
  std::string name;  ///< what and of which solids, e.g. "angular momentum about the axis of 's1'"
  double drift = 0;  ///< largest change since the start, in the quantity's units
  double scale = 0;  ///< what the drift is measured against
  double time = 0;   ///< s, when it was largest

  template <class Keeper>
  void keep(Keeper& k) {
    k(name, drift, scale, time);
  }
};

/// The worst residual of one constraint over the run.
struct ConstraintResidual {
  std::string constraint;
  double position = 0;  ///< |h|, the row's unit
  double velocity = 0;  ///< |dh/dt|
  double position_time = 0, velocity_time = 0;
  /// |L a + E|: of rows that are dependent at a singular position, and what Baumgarte restores
  double acceleration = 0, acceleration_time = 0;

  template <class Keeper>
  void keep(Keeper& k) {
    k(constraint, position, velocity, position_time, velocity_time, acceleration, acceleration_time);
  }
};

/// Something that happened at a moment of the run.
struct LoggedEvent {
  double time = 0;  ///< s
  /// "range_left", "range_entered"; "stop_reached", "stop_left" (a limit spring's bound), "stop_slack",
  /// "stop_taut" (beyond it: what it holds retreats too fast to be pushed, and no more); "half_turn" (of a
  /// torsion spring); "impact", "contact_closed", "contact_opened", "stick", "slip"; "rank_fell",
  /// "rank_regained" (a singular position of the constraints); or the word of a user's own EventSource
  std::string kind;
  std::string name;        ///< what it happened to, e.g. "coordinate 'knee' above 2.4"
  double impulse = 0;      ///< N s or N m s: of an impact, along its normal
  double energy_lost = 0;  ///< J: of an impact

  template <class Keeper>
  void keep(Keeper& k) {
    k(time, kind, name, impulse, energy_lost);
  }
};

struct Certificate {
  bool trusted = false;
  std::string reason;                                             ///< why not; empty when trusted
  double reason_time = std::numeric_limits<double>::quiet_NaN();  ///< s, when that was first so

  std::string method;     ///< the integrator's name
  std::string equations;  ///< which were solved: "recursive" or "lagrange"

  /// Energy balance: kinetic + potential - work done on the system, against its start. The work is that of
  /// forces and torques, dampers, driven coordinates, moving constraints, Baumgarte and projection.
  double energy_drift = 0;       ///< largest, J
  double energy_drift_time = 0;  ///< s
  double energy_turnover = 0;   ///< J: what passed between kinetic, potential and work; the drift's yardstick
  double energy_threshold = 0;  ///< the largest drift / turnover that is trusted

  double work_efforts = 0;      ///< J at the end: forces, torques, dampers
  double work_drives = 0;       ///< J at the end: driven coordinates
  double work_constraints = 0;  ///< J at the end: constraints that move in time
  double work_baumgarte = 0;    ///< J at the end: restoring accelerations
  double work_projection = 0;   ///< J at the end: projections; their sizes are summed in the next
  double work_projection_size = 0;
  double work_events =
      0;  ///< J at the end: changes of velocity at events; their sizes are summed in the next
  double work_events_size = 0;

  int contacts = 0;        ///< places where the scene's solids may touch
  long impacts = 0;        ///< how often they met with a speed
  double impact_loss = 0;  ///< J: lost in them altogether (a part of work_events)
  /// J: the most that contacts within steps (moreau) gave an independent group or took from it beside what
  /// their laws say. It is booked as work, so the balance does not show it; it is judged by the same
  /// threshold.
  double contact_error = 0;

  /// What putting the initial state on the constraints changed: the coordinate most moved (lengths against
  /// the scene's size, angles against 1 rad), by how much (m or rad, m/s or rad/s), and its name; empty:
  /// none.
  double assembly_position = 0, assembly_velocity = 0;
  std::string assembly_position_coordinate, assembly_velocity_coordinate;

  std::vector<Conserved> conserved;
  std::vector<ConstraintResidual> residuals;     ///< one per constraint
  int constraint_rows = 0, constraint_rank = 0;  ///< at the start
  /// How near rows that are independent came to dependence (sine of an angle; 1: no rows), and when; how
  /// often the run passed a singular position, where they are dependent, and by how much the line of the
  /// velocities turned there at most, rad.
  double nearness = 1, nearness_time = 0;
  int singular_passages = 0;
  double singular_turn = 0;
  std::vector<std::string> redundant;  ///< rows that depend on others; the multipliers are the least ones

  long steps_accepted = 0, steps_rejected = 0;
  long evaluations = 0;                              ///< of the equations, those of projections included
  double smallest_step = 0, smallest_step_time = 0;  ///< s

  /// Of steps of one length: by what part of a step one was off, at most, from where the rates at its ends
  /// lead (step_watch.hpp), when (s), and of which coordinate. Empty: steps were not looked at.
  double step_defect = 0, step_defect_time = 0;
  std::string step_defect_coordinate;

  double accuracy = 0;         ///< that was asked for; 0: none was
  double estimated_error = 0;  ///< of the run, where accuracy was asked for (see accuracy.hpp)
  /// The time, s, up to which the state is known to the accuracy. NaN: no accuracy was asked for.
  double known_until = std::numeric_limits<double>::quiet_NaN();
  /// s, when an explicit method found the scene stiff: its steps bounded by stability, not by accuracy. NaN:
  /// never.
  double stiff_from = std::numeric_limits<double>::quiet_NaN();

  std::vector<LoggedEvent> events;  ///< in order of time
  std::vector<std::string> notes;   ///< e.g. a coordinate that left its range, and when

  /// All that is filled in while a run goes on (keeper.hpp).
  template <class Keeper>
  void keep(Keeper& k) {
    k(trusted, reason, reason_time, stiff_from, impacts, impact_loss, conserved, residuals, constraint_rank,
      redundant, steps_accepted, steps_rejected, smallest_step, smallest_step_time);
    k.growing(events);
    k.growing(notes);
  }
};

}  // namespace borelli
