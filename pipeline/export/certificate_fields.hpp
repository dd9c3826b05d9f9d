// The certificate's fields by name: one list for HDF5 (written and read) and JSON.
#pragma once

#include "dynamics/system/certificate.hpp"

namespace borelli {

/// Whether each file of format version 1 holds a field, or only newer ones.
enum class Presence { always, in_newer_files };

/// Calls visit(name, member, presence) for each number and text. A name "work/drives" is the member "drives" of
/// the object "work" in JSON, and the attribute "work_drives" in HDF5.
template <class C, class Visit>
void visit_certificate(C& c, Visit&& visit) {
  using enum Presence;
  visit("trusted", c.trusted, always);
  visit("reason", c.reason, always);
  visit("reason_time", c.reason_time, always);
  visit("method", c.method, in_newer_files);
  visit("equations", c.equations, in_newer_files);
  visit("energy_drift", c.energy_drift, always);
  visit("energy_drift_time", c.energy_drift_time, always);
  visit("energy_turnover", c.energy_turnover, always);
  visit("energy_threshold", c.energy_threshold, always);
  visit("work/efforts", c.work_efforts, always);
  visit("work/drives", c.work_drives, always);
  visit("work/constraints", c.work_constraints, always);
  visit("work/baumgarte", c.work_baumgarte, always);
  visit("work/projection", c.work_projection, always);
  visit("work/projection_size", c.work_projection_size, always);
  visit("work/events", c.work_events, in_newer_files);
  visit("work/events_size", c.work_events_size, in_newer_files);
  visit("contacts", c.contacts, in_newer_files);
  visit("impacts", c.impacts, in_newer_files);
  visit("impact_loss", c.impact_loss, in_newer_files);
  visit("contact_error", c.contact_error, in_newer_files);
  visit("assembly/position", c.assembly_position, in_newer_files);
  visit("assembly/velocity", c.assembly_velocity, in_newer_files);
  visit("assembly/position_coordinate", c.assembly_position_coordinate, in_newer_files);
  visit("assembly/velocity_coordinate", c.assembly_velocity_coordinate, in_newer_files);
  visit("constraint_rows", c.constraint_rows, always);
  visit("constraint_rank", c.constraint_rank, always);
  visit("nearness", c.nearness, in_newer_files);
  visit("nearness_time", c.nearness_time, in_newer_files);
  visit("singular_passages", c.singular_passages, in_newer_files);
  visit("singular_turn", c.singular_turn, in_newer_files);
  visit("steps_accepted", c.steps_accepted, always);
  visit("steps_rejected", c.steps_rejected, always);
  visit("evaluations", c.evaluations, always);
  visit("smallest_step", c.smallest_step, always);
  visit("smallest_step_time", c.smallest_step_time, always);
  visit("step_defect", c.step_defect, in_newer_files);
  visit("step_defect_time", c.step_defect_time, in_newer_files);
  visit("step_defect_coordinate", c.step_defect_coordinate, in_newer_files);
  visit("accuracy", c.accuracy, in_newer_files);
  visit("estimated_error", c.estimated_error, in_newer_files);
  visit("state_known_until", c.known_until, in_newer_files);
  visit("stiff_from", c.stiff_from, in_newer_files);
}

/// Calls visit(name, pointer to member, unit, presence) for each column of the certificate's tables. The first
/// column has as many entries as the table has rows.
template <class Visit>
void visit_columns(const Conserved* /*row*/, Visit&& visit) {
  using enum Presence;
  visit("name", &Conserved::name, "", always);
  visit("drift", &Conserved::drift, "as named", always);
  visit("scale", &Conserved::scale, "as named", always);
  visit("time", &Conserved::time, "s", always);
}

template <class Visit>
void visit_columns(const ConstraintResidual* /*row*/, Visit&& visit) {
  using enum Presence;
  visit("constraint", &ConstraintResidual::constraint, "", always);
  visit("position", &ConstraintResidual::position, "m or rad", always);
  visit("velocity", &ConstraintResidual::velocity, "m/s or rad/s", always);
  visit("position_time", &ConstraintResidual::position_time, "s", always);
  visit("velocity_time", &ConstraintResidual::velocity_time, "s", always);
  visit("acceleration", &ConstraintResidual::acceleration, "m/s^2 or rad/s^2", in_newer_files);
  visit("acceleration_time", &ConstraintResidual::acceleration_time, "s", in_newer_files);
}

template <class Visit>
void visit_columns(const LoggedEvent* /*row*/, Visit&& visit) {
  using enum Presence;
  visit("time", &LoggedEvent::time, "s", in_newer_files);
  visit("kind", &LoggedEvent::kind, "", in_newer_files);
  visit("name", &LoggedEvent::name, "", in_newer_files);
  visit("impulse", &LoggedEvent::impulse, "N s or N m s", in_newer_files);
  visit("energy_lost", &LoggedEvent::energy_lost, "J", in_newer_files);
}

}  // namespace borelli
