// A simulation's assessment of its own reliability. Part of every trajectory.
#pragma once

#include <limits>
#include <string>
#include <vector>

namespace borelli {

struct Certificate;

/// `Certificate::method` of a motion that was recorded, not integrated: the certificate then holds no checks.
inline constexpr const char* captured_method = "captured motion";

/// One line on what a trusted certificate guarantees: conservation always, the state only if an accuracy was
/// asked for; nothing for a recorded motion.
std::string vouches_for(const Certificate& certificate);

/// A quantity that the scene conserves (a component of momentum), and its drift in the run.
struct Conserved {
  std::string name;  ///< quantity and solids, e.g. "angular momentum about the axis of 's1'"
  double drift = 0;  ///< largest change since the start, in the quantity's units
  double scale = 0;  ///< reference for the drift
  double time = 0;   ///< s, of the largest drift

  template <class Keeper>
  void keep(Keeper& k) {
    k(name, drift, scale, time);
  }
};

/// The largest residuals of one constraint in the run.
struct ConstraintResidual {
  std::string constraint;
  double position = 0;  ///< |h|, the row's unit
  double velocity = 0;  ///< |dh/dt|
  double position_time = 0, velocity_time = 0;
  /// |L a + E|: of rows that are dependent at a singular position, and of rows under Baumgarte stabilisation
  double acceleration = 0, acceleration_time = 0;

  template <class Keeper>
  void keep(Keeper& k) {
    k(constraint, position, velocity, position_time, velocity_time, acceleration, acceleration_time);
  }
};

/// An event at one time of the run.
struct LoggedEvent {
  double time = 0;  ///< s
  /// - "range_left", "range_entered": the range of a coordinate.
  /// - "stop_reached", "stop_left": the bound of a limit spring.
  /// - "stop_slack", "stop_taut": beyond the bound, the spring ceases to push because the coordinate retreats
  ///   too fast, or pushes again.
  /// - "half_turn": of a torsion spring.
  /// - "impact", "contact_closed", "contact_opened", "stick", "slip": contacts.
  /// - "rank_fell", "rank_regained": a singular position of the constraints.
  /// - The kind given by a user-defined EventSource.
  std::string kind;
  std::string name;        ///< what it happened to, e.g. "coordinate 'knee' above 2.4"
  double impulse = 0;      ///< of an impact: normal impulse, N s or N m s
  double energy_lost = 0;  ///< of an impact: lost energy, J

  template <class Keeper>
  void keep(Keeper& k) {
    k(time, kind, name, impulse, energy_lost);
  }
};

struct Certificate {
  bool trusted = false;
  std::string reason;                                             ///< why not trusted; empty if trusted
  double reason_time = std::numeric_limits<double>::quiet_NaN();  ///< s, when the reason first applied

  std::string method;     ///< the integrator's name
  std::string equations;  ///< which were solved: "recursive" or "lagrange"

  /// Energy balance: kinetic + potential - work done on the system, relative to its start. The work is that
  /// of forces and torques, dampers, driven coordinates, moving constraints, Baumgarte, projection and
  /// events.
  double energy_drift = 0;       ///< largest deviation, J
  double energy_drift_time = 0;  ///< s
  double energy_turnover = 0;  ///< J: energy exchanged between kinetic, potential and work; the reference for
                               ///< the drift
  double energy_threshold = 0;  ///< the largest drift / turnover that is trusted

  double work_efforts = 0;      ///< J at the end: forces, torques, dampers
  double work_drives = 0;       ///< J at the end: driven coordinates
  double work_constraints = 0;  ///< J at the end: constraints that move in time
  double work_baumgarte = 0;    ///< J at the end: restoring accelerations
  double work_projection = 0;   ///< J at the end: projections; the next member sums their magnitudes
  double work_projection_size = 0;
  double work_events =
      0;  ///< J at the end: changes of velocity at events; the next member sums their magnitudes
  double work_events_size = 0;

  int contacts = 0;        ///< number of possible contact points
  long impacts = 0;        ///< number of impacts
  double impact_loss = 0;  ///< J: total loss in impacts (a part of work_events)
  /// J: the largest energy that contacts within steps (moreau) added to or took from an independent group
  /// beyond their contact laws. It counts as work, so the balance does not show it. The same threshold
  /// applies to it.
  double contact_error = 0;

  /// The largest change by assembly, which projects the initial state onto the constraints: in m or rad, m/s
  /// or rad/s, and the name of the coordinate (empty: none). Lengths are compared relative to the size of the
  /// scene, angles to 1 rad.
  double assembly_position = 0, assembly_velocity = 0;
  std::string assembly_position_coordinate, assembly_velocity_coordinate;

  std::vector<Conserved> conserved;
  std::vector<ConstraintResidual> residuals;     ///< one per constraint
  int constraint_rows = 0, constraint_rank = 0;  ///< at the start
  /// The least distance of independent rows from dependence (sine of an angle; 1: no rows), and its time, s.
  /// Then the number of passages of singular positions, where rows are dependent, and the largest turn of the
  /// direction of the velocities there, rad.
  double nearness = 1, nearness_time = 0;
  int singular_passages = 0;
  double singular_turn = 0;
  std::vector<std::string> redundant;  ///< dependent rows; the multipliers are those of minimum norm

  long steps_accepted = 0, steps_rejected = 0;
  long evaluations = 0;  ///< of the equations of motion, those for projections included
  double smallest_step = 0, smallest_step_time = 0;  ///< s

  /// Fixed steps: the largest deviation of a step from the motion that the rates at its ends predict
  /// (step_watch.hpp), as a fraction of the step; its time, s; its coordinate. Empty: not checked.
  double step_defect = 0, step_defect_time = 0;
  std::string step_defect_coordinate;

  double accuracy = 0;         ///< the accuracy asked for; 0: none
  double estimated_error = 0;  ///< of the run, if an accuracy was asked for (see accuracy.hpp)
  /// s, the time up to which the state is known to the accuracy. NaN: no accuracy was asked for.
  double known_until = std::numeric_limits<double>::quiet_NaN();
  /// s, when an explicit method found the scene stiff: stability limits its steps, not accuracy. NaN: never.
  double stiff_from = std::numeric_limits<double>::quiet_NaN();

  std::vector<LoggedEvent> events;  ///< in order of time
  std::vector<std::string> notes;   ///< e.g. a coordinate that left its range, and when

  /// Saves and restores the members filled in during a run (keeper.hpp).
  template <class Keeper>
  void keep(Keeper& k) {
    k(trusted, reason, reason_time, stiff_from, impacts, impact_loss, conserved, residuals, constraint_rank,
      redundant, steps_accepted, steps_rejected, smallest_step, smallest_step_time);
    k.growing(events);
    k.growing(notes);
  }
};

}  // namespace borelli
