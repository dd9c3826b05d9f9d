// The equations of motion at one state, solved: A(q) a + B(q, v) = Q(q, v, t) + L^T lambda, L a + E = 0.
// All scratch is in the Workspace: nothing allocates, but once for A, B and Q of a scene without rows, and
// once where a contact slides. (A grows with the square of the coordinates; articulated-body accelerations do
// without it.)
#pragma once

#include <optional>

#include "dynamics/equations/articulated.hpp"
#include "dynamics/equations/constraint_solver.hpp"
#include "dynamics/equations/lagrange.hpp"
#include "dynamics/equations/passes.hpp"
#include "dynamics/equations/recursive.hpp"
#include "dynamics/equations/sliding_friction.hpp"

namespace borelli {

/// Why the equations could not be solved.
struct Fault {
  enum class Kind {
    none,
    singular_mass,          ///< index: the free velocity that meets no inertia
    not_finite,             ///< index: the free velocity whose acceleration is not a number
    degenerate_constraint,  ///< index: the row
    no_memory,              ///< for the mass matrix
  };
  Kind kind = Kind::none;
  int index = -1;
  explicit operator bool() const { return kind != Kind::none; }
};

/// The fault as an error with the names of what it concerns; t in s.
Error describe(const System& system, const Fault& fault, double t);

/// What does work on the system beside what has a potential, W.
struct Powers {
  double efforts = 0;      ///< forces, torques, dampers
  double drives = 0;       ///< driven coordinates
  double constraints = 0;  ///< constraints that move in time
  double violation = 0;    ///< multipliers on rows that are not at rest: Baumgarte's restoring, drift
  double total() const { return efforts + drives + constraints + violation; }
};

/// Scratch and results for one System; one per thread.
struct Workspace {
  explicit Workspace(const System& system) : Workspace(system, system.settings.equations) {}
  Workspace(const System& system, Equations equations);
  // after `accelerate` by the recursive equations without constraints of the first: poses and velocities
  // alone, of the terms: energies alone (neither before `complete` where accelerations alone were wanted)
  Kinematics kinematics;
  EffortSums efforts;
  LagrangeTerms terms;
  Articulation articulation;
  std::optional<Recursion> recursion;  ///< of A, B, Q; without rows once they are asked for
  Rows factor;                         ///< of the mass matrix
  ConstraintRows rows;
  ConstraintSolver solver;

  /// Contacts are left to the method (Integrator::handles_contacts): none holds in the equations, and their
  /// rows stay empty unlooked at.
  bool leaves_contacts = false;
  /// Whether any row holds: while all contacts of a scene without other rows are open, its equations are
  /// those of a scene without them.
  bool has_rows() const { return bilateral_rows > 0 || (!leaves_contacts && any_closed(rows.modes)); }
  int bilateral_rows = 0;  ///< rows that are no contact's

  Eigen::VectorXd a;              ///< nv, accelerations
  Eigen::VectorXd multipliers;    ///< rows
  Eigen::VectorXd drive_efforts;  ///< driven_nv: what the drives exert
  Powers power;
  Eigen::VectorXd group_power;      ///< W, all of them together, on each independent group
  Eigen::VectorXd group_violation;  ///< W: the part of it by multipliers on rows that are off
  long evaluations = 0;             ///< so far

  Eigen::VectorXd wanted, correction;  ///< scratch: rows, nv
  SlidingFriction friction;
  bool complete = true;    ///< poses, velocities and energies are those of the last evaluation
  bool rows_empty = true;  ///< rows, multipliers and friction are those of a state in which none holds

  /// What outlasts an evaluation.
  template <class Keeper>
  void keep(Keeper& k) {
    k(solver, rows.modes, evaluations);
  }
};

/// Asks for the memory of `count` Workspaces (process/memory.hpp). `mass_matrix`: include A even where
/// neither rows nor the equations need it.
Result<void> admit_workspaces(const System& system, Equations equations, int count, bool mass_matrix);

/// How constraint rows enter one evaluation.
struct RowHandling {
  bool decide_rank = true;  ///< else rank and order of rows stay as last decided (within a step)
  double alpha = 0;         ///< Baumgarte: L a + E + 2 alpha dh/dt + beta^2 h = 0, 1/s
  double beta = 0;
};

/// The terms at time t, positions q (nq), velocities v (nv): kinematics, efforts, A, B, Q, the factor of A,
/// and the constraint rows. All that projection and assembly need.
Fault update_terms(const System& system, const Parameters& parameters, double t, const double* q,
                   const double* v, Workspace& workspace);

/// Energies alone; of what update_terms finds, nothing else is to be relied on.
Fault update_energies(const System& system, const Parameters& parameters, double t, const double* q,
                      const double* v, Workspace& workspace);

/// What is wanted of an evaluation: most of those within a step need no poses and no energies, which
/// complete() adds.
enum class Wanted { all, accelerations };

/// update_terms, then accelerations, multipliers, efforts of the drives and powers. `applied` (nv or null) is
/// added to Q.
Fault accelerate(const System& system, const Parameters& parameters, double t, const double* q,
                 const double* v, const RowHandling& handling, Workspace& workspace,
                 const double* applied = nullptr, Wanted wanted = Wanted::all);

/// After accelerate() for the accelerations alone: what it left out.
void complete(const System& system, const Parameters& parameters, Workspace& workspace);

}  // namespace borelli
