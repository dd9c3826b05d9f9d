// Solves the equations of motion at one state: A(q) a + B(q, v) = Q(q, v, t) + L^T lambda, L a + E = 0. All
// scratch is in the Workspace. Nothing allocates later, except A, B and Q of a scene without rows at first
// use, and sliding friction at first use. (A grows with the square of the coordinates; articulated-body
// accelerations do not need it.)
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
    not_finite,             ///< index: the free velocity whose acceleration is not finite
    degenerate_constraint,  ///< index: the row
    no_memory,              ///< for the mass matrix
  };
  Kind kind = Kind::none;
  int index = -1;
  explicit operator bool() const { return kind != Kind::none; }
};

/// The fault as an error with the names of the coordinate or row; t in s.
Error describe(const System& system, const Fault& fault, double t);

/// Power of everything without a potential, W.
struct Powers {
  double efforts = 0;      ///< forces, torques, dampers
  double drives = 0;       ///< driven coordinates
  double constraints = 0;  ///< constraints that move in time
  double violation = 0;    ///< multipliers on rows with dh/dt != 0: Baumgarte's terms, drift
  double total() const { return efforts + drives + constraints + violation; }
};

/// Scratch and results for one System; one per thread.
struct Workspace {
  explicit Workspace(const System& system) : Workspace(system, system.settings.equations) {}
  Workspace(const System& system, Equations equations);
  // After accelerate() by the recursive equations without active rows, `kinematics` holds only poses and
  // velocities, and `terms` only energies. If only accelerations were wanted, both wait for complete().
  Kinematics kinematics;
  EffortSums efforts;
  LagrangeTerms terms;
  Articulation articulation;
  std::optional<Recursion> recursion;  ///< for A, B, Q; without rows created at first use
  Rows factor;                         ///< factor of the mass matrix
  ConstraintRows rows;
  ConstraintSolver solver;

  /// The method handles contacts (Integrator::handles_contacts): none is active in the equations, and their
  /// rows stay empty and unread.
  bool leaves_contacts = false;
  /// Whether any row is active. While all contacts of a scene without other rows are open, its equations are
  /// those of a scene without rows.
  bool has_rows() const { return bilateral_rows > 0 || (!leaves_contacts && any_closed(rows.modes)); }
  int bilateral_rows = 0;  ///< rows of constraints other than contacts

  Eigen::VectorXd a;              ///< nv, accelerations
  Eigen::VectorXd multipliers;    ///< rows
  Eigen::VectorXd drive_efforts;  ///< driven_nv: the drives' generalised forces
  Powers power;
  Eigen::VectorXd group_power;      ///< per independent group, total power, W
  Eigen::VectorXd group_violation;  ///< per group, power of multipliers on rows with dh/dt != 0, W
  long evaluations = 0;             ///< count so far

  Eigen::VectorXd wanted, correction;  ///< scratch: rows, nv
  SlidingFriction friction;
  bool complete = true;    ///< poses, velocities and energies belong to the last evaluation
  bool rows_empty = true;  ///< rows, multipliers and friction are those of a state without active rows

  /// State that outlasts an evaluation.
  template <class Keeper>
  void keep(Keeper& k) {
    k(solver, rows.modes, evaluations);
  }
};

/// Checks that `count` Workspaces fit into memory (process/memory.hpp). `mass_matrix`: include A even if
/// neither rows nor the equations need it.
Result<void> admit_workspaces(const System& system, Equations equations, int count, bool mass_matrix);

/// How constraint rows enter one evaluation.
struct RowHandling {
  bool decide_rank = true;  ///< false: keep the last rank and order of rows (within a step)
  double alpha = 0;         ///< Baumgarte: L a + E + 2 alpha dh/dt + beta^2 h = 0, 1/s
  double beta = 0;
};

/// The terms at time t, positions q (nq), velocities v (nv): kinematics, efforts, A, B, Q, the factor of A,
/// and the constraint rows. Projection and assembly need no more.
Fault update_terms(const System& system, const Parameters& parameters, double t, const double* q,
                   const double* v, Workspace& workspace);

/// Updates kinematics, efforts, A, B and Q. Unlike update_terms it leaves out the constraint rows and the
/// factor of A, which takes about n^3 operations for a chain of n solids.
Fault update_unfactored_terms(const System& system, const Parameters& parameters, double t, const double* q,
                              const double* v, Workspace& workspace);

/// Updates the energies; nothing else that update_terms finds may be used afterwards.
Fault update_energies(const System& system, const Parameters& parameters, double t, const double* q,
                      const double* v, Workspace& workspace);

/// What an evaluation must give. Most evaluations within a step need neither poses nor energies; complete()
/// adds them.
enum class Wanted { all, accelerations };

/// Accelerations, multipliers, drive forces and powers, after update_terms or by articulated bodies (no
/// active rows). `applied` (nv or null) adds to Q.
Fault accelerate(const System& system, const Parameters& parameters, double t, const double* q,
                 const double* v, const RowHandling& handling, Workspace& workspace,
                 const double* applied = nullptr, Wanted wanted = Wanted::all);

/// After accelerate() for accelerations alone: adds poses, velocities and energies.
void complete(const System& system, const Parameters& parameters, Workspace& workspace);

}  // namespace borelli
