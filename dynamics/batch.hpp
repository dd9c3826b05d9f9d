// Eight states of one System at once: ensembles of starts, of inertias, of efforts. The equations are the
// recursive ones, in the same source as one state's (articulated.hpp, recursive.hpp), over eight numbers side
// by side (lanes.hpp) and compiled for AVX-512, for AVX2 and for any processor; each lane's results are those
// of one state but for rounding.
//
// Batches are for smooth scenes: constraints, contacts and a program's own efforts they refuse. A lane that
// elimination serves badly (what a joint carries is thin to rounding) is solved by itself. Nothing here
// allocates but the constructors, and a lane by itself.
#pragma once

#include <array>
#include <optional>

#include "dynamics/equations.hpp"
#include "dynamics/lanes.hpp"

namespace borelli {

/// Whether a system can be computed in batches; the error says what of it cannot.
Result<void> check_batch(const System& system);

/// Eight states at one time.
struct BatchState {
  explicit BatchState(const System& system);  ///< all of them the scene's start
  double t = 0;
  Eigen::VectorX<Lanes> q, v;  ///< nq, nv

  /// Takes over a lane's positions and velocities; its time is the batch's.
  void set(int lane, const State& state);
  State state(int lane) const;
};

/// Scratch and results for eight states; one per thread.
struct BatchWorkspace {
  /// For a System of which check_batch has no complaint. `mass_matrix`: whether find_mass_matrix is to be
  /// called, which needs eight matrices of room.
  explicit BatchWorkspace(const System& system, bool mass_matrix = false);

  /// Gives a lane its own inertial elements of a body (in the body's frame); else it has the parameters'.
  void set_inertial(int lane, int body, const Inertial& inertial);

  InertialsOf<Lanes> inertials;  ///< per body
  KinematicsOf<Lanes> kinematics;
  EffortSumsOf<Lanes> efforts;
  LagrangeTermsOf<Lanes> terms;
  ArticulationOf<Lanes> articulation;
  RecursionOf<Lanes> recursion;

  Eigen::VectorX<Lanes> a;                 ///< nv, accelerations
  Eigen::VectorX<Lanes> drive_efforts;     ///< driven_nv: what the drives exert
  Eigen::VectorX<Lanes> group_power;       ///< W, of efforts and drives on each independent group
  std::array<Fault, Lanes::count> faults;  ///< of each lane, at the last accelerate()
  bool together = true;                    ///< else, there, its lanes were solved by themselves

  // for lanes that are solved by themselves
  std::optional<Workspace> single;  ///< none before the first
  Parameters numbers;
  Eigen::VectorXd given;  ///< nv
};

/// Accelerations, what drives exert, energies (unless accelerations alone are wanted) and powers of eight
/// states. `applied` (nv, or null) is added to the generalized efforts. False: of some lane the equations
/// cannot be solved; see `faults`.
bool accelerate(const System& system, const Parameters& parameters, const BatchState& state,
                BatchWorkspace& workspace, const Lanes* applied = nullptr, Wanted wanted = Wanted::all);

/// The energies, after accelerate() without them.
void find_energies(const System& system, const Parameters& parameters, BatchWorkspace& workspace);

/// efforts <- A a + B - Q (nv), what the accelerations a (nv) ask for beside the scene's own efforts.
void inverse_dynamics(const System& system, const Parameters& parameters, const BatchState& state,
                      const Eigen::VectorX<Lanes>& a, BatchWorkspace& workspace,
                      Eigen::VectorX<Lanes>& efforts);

/// A, into workspace.terms.A: row >= column only (see LagrangeTermsOf).
void find_mass_matrix(const System& system, const Parameters& parameters, const BatchState& state,
                      BatchWorkspace& workspace);

}  // namespace borelli
