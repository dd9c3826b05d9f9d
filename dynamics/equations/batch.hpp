// Several states of one System at once, in SIMD lanes: ensembles of initial states, inertias or forces
// (eight: Lanes), or the evaluations of a method within a step (four or eight). The equations are the
// recursive ones, from the same source as for one state (articulated.hpp, recursive.hpp), compiled for
// AVX-512, for AVX2 and for any processor (lanes.hpp). Each lane's results equal those of one state but for
// rounding.
//
// Batches are for smooth scenes: they refuse constraints, contacts and a program's own efforts. If
// elimination is inaccurate in some lane (its articulated inertia is small enough to be rounding), every lane
// is solved alone. Only the constructors and lanes solved alone allocate.
#pragma once

#include <array>
#include <optional>
#include <type_traits>

#include "dynamics/equations/equations.hpp"
#include "dynamics/equations/inverse_derivatives.hpp"
#include "dynamics/numbers/lanes.hpp"

namespace borelli {

/// Whether a system can be computed in batches; the error names what prevents it.
Result<void> check_batch(const System& system);
/// The same, for states in which no constraint or contact row is active.
Result<void> check_batch_without_rows(const System& system);

/// As many states as T has lanes, all at one time. Quaternions must have unit length (not checked).
template <class T>
struct BatchStateOf {
  explicit BatchStateOf(const System& system);  ///< every lane: the scene's initial state
  double t = 0;
  Eigen::VectorX<T> q, v;  ///< nq, nv

  /// Sets a lane's positions and velocities; its time is the batch's.
  void set(int lane, const State& state);
  State state(int lane) const;
};

using BatchState = BatchStateOf<Lanes>;

/// Scratch and results of a batch; one per thread.
template <class T>
struct BatchWorkspaceOf {
  /// For a System that passes check_batch. `mass_matrix`: reserve a matrix per lane for find_mass_matrix.
  explicit BatchWorkspaceOf(const System& system, bool mass_matrix = false);

  /// Sets a lane's own inertial elements of a body (body's frame); the default is the parameters'.
  void set_inertial(int lane, int body, const Inertial& inertial);

  InertialsOf<T> inertials;  ///< per body
  KinematicsOf<T> kinematics;
  EffortSumsOf<T> efforts;
  LagrangeTermsOf<T> terms;
  ArticulationOf<T> articulation;
  std::optional<RecursionOf<T>> recursion;  ///< for find_mass_matrix

  Eigen::VectorX<T> a;                 ///< nv, accelerations
  Eigen::VectorX<T> drive_efforts;     ///< driven_nv: the drives' generalised forces
  Eigen::VectorX<T> group_power;       ///< per independent group, power of efforts and drives, W
  std::array<Fault, T::count> faults;  ///< per lane, of the last accelerate()
  bool together = true;                ///< false: the last accelerate() solved its lanes one by one
  bool coordinates_set = false;  ///< whether the last accelerate() set the coordinates of `kinematics`; it
                                 ///< skips them if nothing needs them

  /// For lanes solved alone; created at first use.
  struct Alone {
    Workspace workspace;
    Parameters parameters;
    Eigen::VectorXd given;  ///< nv
  };
  std::optional<Alone> alone;
};
using BatchWorkspace = BatchWorkspaceOf<Lanes>;

/// Accelerations, drive forces, energies (unless only accelerations are wanted) and powers of the states
/// (Lanes or Quad). `applied` (nv, or null) adds to the generalised forces. Returns false if the equations of
/// some lane cannot be solved; see `faults`.
template <class T>
bool accelerate(const System& system, const Parameters& parameters, const BatchStateOf<T>& state,
                BatchWorkspaceOf<T>& workspace, const std::type_identity_t<T>* applied = nullptr,
                Wanted wanted = Wanted::all);

/// Energies, after accelerate() for accelerations alone at the same states.
template <class T>
void find_energies(const System& system, const Parameters& parameters, const BatchStateOf<T>& state,
                   BatchWorkspaceOf<T>& workspace);

/// efforts <- A a + B - Q (nv): the generalised forces that accelerations a (nv) need beyond the scene's own.
void inverse_dynamics(const System& system, const Parameters& parameters, const BatchState& state,
                      const Eigen::VectorX<Lanes>& a, BatchWorkspace& workspace,
                      Eigen::VectorX<Lanes>& efforts);

/// Derivatives of these efforts by positions and velocities, and A, into `out` (inverse_derivatives.hpp). For
/// a system without efforts of its own.
void find_inverse_derivatives(const System& system, const Parameters& parameters, const BatchState& state,
                              const Eigen::VectorX<Lanes>& a, BatchWorkspace& workspace,
                              InverseDerivativesOf<Lanes>& out);

/// Mass matrix A into workspace.terms.A: row >= column only (see LagrangeTermsOf).
void find_mass_matrix(const System& system, const Parameters& parameters, const BatchState& state,
                      BatchWorkspace& workspace);

}  // namespace borelli
