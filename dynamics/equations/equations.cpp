#include "dynamics/equations/equations.hpp"

#include <fmt/format.h>

#include "dynamics/equations/branch_sparse.hpp"
#include "dynamics/system/border.hpp"

namespace borelli {

namespace {

/// Whether every evaluation needs the mass matrix A.
bool always_asks_for_mass_matrix(const System& system, Equations equations) {
  return system.rows > 0 || equations != Equations::recursive;
}

double mass_matrix_bytes(const System& system) {
  const double n = system.size(), free = system.nv;
  return sizeof(double) * (n * n + free * free) + Branches::bytes(system);
}

Result<void> admit_mass_matrix(const System& system, int count) {
  return admit_large(system, count * mass_matrix_bytes(system),
                     [&] { return fmt::format("the mass matrix of {} coordinates", system.size()); });
}

}  // namespace

Result<void> admit_workspaces(const System& system, Equations equations, int count, bool mass_matrix) {
  const double n = system.size(), rows = system.rows;
  if (rows > 0) {
    // L and its unit rows, slip directions, and one bit per pair of rows
    const double numbers = 2 * rows * n + double(system.contacts.size()) * n + rows * rows / 64;
    if (auto fine = admit_large(
            system, count * sizeof(double) * numbers,
            [&] { return fmt::format("the equations of {} constraint rows and {} coordinates", rows, n); });
        !fine)
      return fine;
  }
  if (mass_matrix || always_asks_for_mass_matrix(system, equations))
    if (auto fine = admit_mass_matrix(system, count); !fine) return fine;
  if (equations == Equations::recursive) return {};
  double supports = 0;
  for (const Body& body : system.bodies) supports += body.support_count;
  return admit_large(system, count * sizeof(double) * 6 * supports,
                     [&] { return fmt::format("the paper's scan over {} coordinates", n); });
}

Workspace::Workspace(const System& system, Equations equations)
    : kinematics(system, equations),
      efforts(system),
      terms(system, always_asks_for_mass_matrix(system, equations)),
      articulation(system),
      rows(system),
      solver(system),
      bilateral_rows(system.bilateral_rows()),
      a(Eigen::VectorXd::Zero(system.nv)),
      multipliers(Eigen::VectorXd::Zero(system.rows)),
      drive_efforts(Eigen::VectorXd::Zero(system.driven_nv)),
      group_power(Eigen::VectorXd::Zero(system.groups)),
      group_violation(group_power),
      wanted(multipliers),
      correction(a) {
  if (always_asks_for_mass_matrix(system, equations)) factor.setZero(system.nv, system.nv);
  if (equations == Equations::recursive && system.rows > 0) recursion.emplace(system);
}

Error describe(const System& system, const Fault& fault, double t) {
  switch (fault.kind) {
    case Fault::Kind::singular_mass:
      return {fmt::format("coordinate '{}'", system.velocity_name(fault.index)),
              fmt::format("the mass matrix is singular at t = {:.6g} s: this coordinate moves no mass, once "
                          "those before it follow freely; give the solids that it moves an inertial, or lock "
                          "it; if two axes of a rotation sequence have become parallel, use a ball",
                          t)};
    case Fault::Kind::not_finite:
      return {fmt::format("coordinate '{}'", system.velocity_name(fault.index)),
              fmt::format("its acceleration at t = {:.6g} s is not a finite number", t)};
    case Fault::Kind::degenerate_constraint:
      return {system.row_place(fault.index),
              fmt::format(
                  "it has no direction at t = {:.6g} s: its two points coincide, or its disc lies flat", t)};
    case Fault::Kind::no_memory:
      if (auto now = admit_mass_matrix(system, 1); !now) return now.error();
      return {system.scene, "not enough memory for the mass matrix"};
    case Fault::Kind::none:
      break;
  }
  return {"", "no fault"};
}

namespace {

/// Kinematics, efforts and energies.
void update_motion(const System& system, const Parameters& parameters, double t, const double* q,
                   const double* v, Workspace& w) {
  update_kinematics(system, parameters, t, q, v, w.kinematics);
  if (!system.efforts.empty()) scan_efforts(system, parameters, w.kinematics, w.efforts);
  if (w.kinematics.equations != Equations::recursive) return;
  if (!w.recursion) w.recursion.emplace(system);
  find_own_forces(system, parameters, parameters.inertials, w.kinematics, w.efforts, *w.recursion, w.terms);
}

/// A, B and Q, after update_motion.
Fault find_terms(const System& system, const Parameters& parameters, Workspace& w) {
  if (w.terms.A.rows() < system.size()) {
    if (!admit_mass_matrix(system, 1)) return {Fault::Kind::no_memory, 0};
    w.terms.A.setZero(system.size(), system.size());
  }
  if (w.kinematics.equations == Equations::recursive) {
    find_efforts(system, parameters, w.kinematics, w.efforts, *w.recursion, w.terms);
    find_mass_matrix(system, parameters, parameters.inertials, w.kinematics, *w.recursion, w.terms);
  } else {
    scan_solids(system, parameters, parameters.inertials, w.kinematics, w.efforts, w.terms);
  }
  return {};
}

/// A, B, Q and the factor of A, after update_motion.
Fault find_factored_terms(const System& system, const Parameters& parameters, Workspace& w) {
  if (const Fault fault = find_terms(system, parameters, w)) return fault;
  if (w.factor.rows() < system.nv) w.factor.setZero(system.nv, system.nv);
  const int singular = factor_mass_matrix(system, w.terms.A, w.factor);
  if (singular < 0) return {};
  // A state that is not finite shows here first.
  const bool finite =
      std::isfinite(w.terms.A(singular, singular)) && std::isfinite(w.factor(singular, singular));
  return {finite ? Fault::Kind::singular_mass : Fault::Kind::not_finite, singular};
}

/// Clears rows, multipliers and friction for a state without active rows.
void empty_rows(Workspace& w) {
  if (w.rows_empty) return;
  w.rows.empty();
  w.multipliers.setZero();
  w.friction.sliding.clear();
  w.rows_empty = true;
}

Fault find_rows(const System& system, const Parameters& parameters, Workspace& w) {
  if (!w.has_rows()) {
    empty_rows(w);
    return {};
  }
  w.rows_empty = false;
  scan_constraints(system, parameters, w.kinematics, w.rows);
  if (w.rows.degenerate >= 0) return {Fault::Kind::degenerate_constraint, w.rows.degenerate};
  return {};
}

}  // namespace

Fault update_terms(const System& system, const Parameters& parameters, double t, const double* q,
                   const double* v, Workspace& w) {
  ++w.evaluations;
  w.complete = true;
  update_motion(system, parameters, t, q, v, w);
  if (const Fault fault = find_factored_terms(system, parameters, w)) return fault;
  return find_rows(system, parameters, w);
}

Fault update_unfactored_terms(const System& system, const Parameters& parameters, double t, const double* q,
                              const double* v, Workspace& w) {
  w.complete = true;
  update_motion(system, parameters, t, q, v, w);
  return find_terms(system, parameters, w);
}

Fault update_energies(const System& system, const Parameters& parameters, double t, const double* q,
                      const double* v, Workspace& w) {
  if (w.kinematics.equations != Equations::recursive) return update_terms(system, parameters, t, q, v, w);
  w.complete = true;
  update_motion(system, parameters, t, q, v, w);
  return {};
}

namespace {

/// Adds the accelerations that the constraints cause.
void add_constraints(const RowHandling& handling, Workspace& w) {
  w.solver.prepare(w.rows.L, w.factor, handling.decide_rank);
  w.wanted.noalias() = -w.rows.E;
  w.solver.take_from(w.wanted, w.rows.L, w.a);
  if (handling.alpha != 0 || handling.beta != 0)
    w.wanted -= 2 * handling.alpha * w.rows.rate + handling.beta * handling.beta * w.rows.h;
  w.solver.correct(w.factor, w.wanted, w.correction);
  w.solver.multipliers(w.multipliers);
  w.a += w.correction;
}

/// Drive forces: each drive's own row of the equations, with all accelerations known.
void find_drive_efforts(const System& system, Workspace& w) {
  const int n = system.nv;
  for (int d = 0; d < system.driven_nv; ++d) {
    double effort = w.terms.A.row(n + d).head(n).dot(w.a) + w.terms.B[n + d] - w.terms.Q[n + d];
    for (int r = 0; r < system.rows; ++r) effort -= w.multipliers[r] * w.rows.L(r, n + d);
    for (int i : w.friction.sliding) effort += w.friction.force[i] * w.rows.slip(i, n + d);
    w.drive_efforts[d] = effort;
  }
}

/// Efforts, and accelerations by articulated bodies. Returns false if they do not apply, or A must decide.
bool articulate(const System& system, const Parameters& parameters, double t, const double* q,
                const double* v, Workspace& w, const double* applied) {
  if (w.kinematics.equations != Equations::recursive || w.has_rows() || !w.articulation.every_body_moves)
    return false;
  empty_rows(w);
  const bool acted = !system.efforts.empty();
  move_links<double>(system, parameters, parameters.inertials, t, q, v, nullptr, w.kinematics,
                     w.articulation);
  if (acted) {
    find_bodies<double>(system, parameters, parameters.inertials, w.kinematics, w.articulation);
    scan_efforts(system, parameters, w.kinematics, w.efforts);
  }
  return find_accelerations(system, parameters, parameters.inertials, w.kinematics,
                            acted ? &w.efforts : nullptr, applied, w.articulation, w.a.data(),
                            w.drive_efforts.data());
}

}  // namespace

Fault accelerate(const System& system, const Parameters& parameters, double t, const double* q,
                 const double* v, const RowHandling& handling, Workspace& w, const double* applied,
                 Wanted wanted) {
  const int n = system.nv;
  ++w.evaluations;
  w.complete = !articulate(system, parameters, t, q, v, w, applied);
  if (w.complete) {
    update_motion(system, parameters, t, q, v, w);
    if (const Fault fault = find_factored_terms(system, parameters, w)) return fault;
    if (const Fault fault = find_rows(system, parameters, w)) return fault;
    if (applied)
      for (int i = 0; i < n; ++i) w.terms.Q[i] += applied[i];
    w.a = w.terms.Q.head(n) - w.terms.B.head(n);
    solve_transposed(system, w.factor, w.a.data());
    solve_lower(system, w.factor, w.a.data());
    if (w.has_rows()) add_constraints(handling, w);
    if (!system.contacts.empty() && !w.leaves_contacts) add_sliding_friction(system, parameters, w);
    if (system.driven_nv > 0) find_drive_efforts(system, w);
  } else if (wanted == Wanted::all) {
    complete(system, parameters, w);
  }
  for (int i = 0; i < n; ++i)
    if (!std::isfinite(w.a[i])) return {Fault::Kind::not_finite, i};

  w.power.efforts = w.efforts.power;
  w.power.drives = w.drive_efforts.dot(w.kinematics.u.tail(system.driven_nv));
  w.power.constraints = -w.multipliers.dot(w.rows.partial_rate);
  w.power.violation = w.multipliers.dot(w.rows.rate);
  w.group_power = w.efforts.group_power;
  for (int d = 0; d < system.driven_nv; ++d)
    w.group_power[system.velocity_groups[n + d]] += w.drive_efforts[d] * w.kinematics.u[n + d];
  for (int i : w.friction.sliding) {
    const double power = -w.friction.force[i] * w.friction.speed[i];
    w.power.efforts += power;
    w.group_power[system.constraints[system.contacts[i].constraint].group] += power;
  }
  if (system.rows > 0) w.group_violation.setZero();
  for (int r = 0; r < system.rows; ++r) {
    if (w.multipliers[r] == 0) continue;  // (most contacts are open)
    const int group = system.constraints[system.row_constraint[r]].group;
    w.group_power[group] += w.multipliers[r] * (w.rows.rate[r] - w.rows.partial_rate[r]);
    w.group_violation[group] += w.multipliers[r] * w.rows.rate[r];
  }
  return {};
}

void complete(const System& system, const Parameters& parameters, Workspace& w) {
  if (w.complete) return;
  w.complete = true;
  const bool acted = !system.efforts.empty();
  if (!acted) find_bodies<double>(system, parameters, parameters.inertials, w.kinematics, w.articulation);
  find_energies(system, parameters, parameters.inertials, w.kinematics, acted ? &w.efforts : nullptr,
                w.articulation, w.terms);
}

}  // namespace borelli
