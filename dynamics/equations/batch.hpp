// Several states of one System at once: ensembles of starts, of inertias, of efforts (eight: Lanes), or what
// a method asks for within a step (four or eight). The equations are the recursive ones, in the same source
// as one state's (articulated.hpp, recursive.hpp), over numbers side by side (lanes.hpp) and compiled for
// AVX-512, for AVX2 and for any processor; each lane's results are those of one state but for rounding.
//
// Batches are for smooth scenes: constraints, contacts and a program's own efforts they refuse. A lane that
// elimination serves badly (what a joint carries is thin to rounding) is solved by itself. Nothing here
// allocates but the constructors, and a lane by itself.
#pragma once

#include <array>
#include <optional>
#include <type_traits>

#include "dynamics/equations/equations.hpp"
#include "dynamics/numbers/lanes.hpp"

namespace borelli {

/// Whether a system can be computed in batches; the error says what of it cannot.
Result<void> check_batch(const System& system);
/// The same while no row of its constraints and contacts holds.
Result<void> check_batch_without_rows(const System& system);

/// As many states as T has lanes, at one time. Turns are unit quaternions (which is not looked at).
template <class T>
struct BatchStateOf {
  explicit BatchStateOf(const System& system);  ///< all of them the scene's start
  double t = 0;
  Eigen::VectorX<T> q, v;  ///< nq, nv

  /// Takes over a lane's positions and velocities; its time is the batch's.
  void set(int lane, const State& state);
  State state(int lane) const;
};

using BatchState = BatchStateOf<Lanes>;

/// Scratch and results for them; one per thread.
template <class T>
struct BatchWorkspaceOf {
  /// For a System of which check_batch has no complaint. `mass_matrix`: whether find_mass_matrix is to be
  /// called, which needs a matrix of room per lane.
  explicit BatchWorkspaceOf(const System& system, bool mass_matrix = false);

  /// Gives a lane its own inertial elements of a body (in the body's frame); else it has the parameters'.
  void set_inertial(int lane, int body, const Inertial& inertial);

  InertialsOf<T> inertials;  ///< per body
  KinematicsOf<T> kinematics;
  EffortSumsOf<T> efforts;
  LagrangeTermsOf<T> terms;
  ArticulationOf<T> articulation;
  std::optional<RecursionOf<T>> recursion;  ///< where mass matrices are wanted

  Eigen::VectorX<T> a;                 ///< nv, accelerations
  Eigen::VectorX<T> drive_efforts;     ///< driven_nv: what the drives exert
  Eigen::VectorX<T> group_power;       ///< W, of efforts and drives on each independent group
  std::array<Fault, T::count> faults;  ///< of each lane, at the last accelerate()
  bool together = true;                ///< else, there, its lanes were solved by themselves
  bool coordinates_set = false;        ///< there, in `kinematics`: nothing asked for it if not

  /// For lanes that are solved by themselves; none before the first.
  struct Alone {
    Workspace workspace;
    Parameters parameters;
    Eigen::VectorXd given;  ///< nv
  };
  std::optional<Alone> alone;
};
using BatchWorkspace = BatchWorkspaceOf<Lanes>;

/// Accelerations, what drives exert, energies (unless accelerations alone are wanted) and powers of the
/// states (Lanes or Quad). `applied` (nv, or null) is added to the generalized efforts. False: of some lane
/// the equations cannot be solved; see `faults`.
template <class T>
bool accelerate(const System& system, const Parameters& parameters, const BatchStateOf<T>& state,
                BatchWorkspaceOf<T>& workspace, const std::type_identity_t<T>* applied = nullptr,
                Wanted wanted = Wanted::all);

/// The energies, after accelerate() without them of the same states.
template <class T>
void find_energies(const System& system, const Parameters& parameters, const BatchStateOf<T>& state,
                   BatchWorkspaceOf<T>& workspace);

/// efforts <- A a + B - Q (nv), what the accelerations a (nv) ask for beside the scene's own efforts.
void inverse_dynamics(const System& system, const Parameters& parameters, const BatchState& state,
                      const Eigen::VectorX<Lanes>& a, BatchWorkspace& workspace,
                      Eigen::VectorX<Lanes>& efforts);

/// A, into workspace.terms.A: row >= column only (see LagrangeTermsOf).
void find_mass_matrix(const System& system, const Parameters& parameters, const BatchState& state,
                      BatchWorkspace& workspace);

}  // namespace borelli
