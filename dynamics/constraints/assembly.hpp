// Puts positions and velocities on the constraints: the initial state before a run (assembly), and every
// accepted step after it (projection). Corrections are the least ones, measured by the mass matrix
// (Gauss-Newton).
#pragma once

#include "dynamics/equations/equations.hpp"

namespace borelli {

/// What was found out about the constraint rows at the assembled state.
struct Assembly {
  int rank = 0;
  std::vector<std::string> redundant;  ///< rows that depend on the others and are satisfied with them

  /// What assembly changed of the state, at the coordinate most changed.
  struct Move {
    double size = 0;         ///< m or rad, or these per second
    double relative = 0;     ///< the same against the scene's size or 1 rad
    bool angle = false;      ///< rad
    std::string coordinate;  ///< its name; empty: nothing changed
  };
  Move position = {}, velocity = {};
};

/// The coordinate most changed between two states: of positions, or of velocities.
Assembly::Move largest_move(const System& system, const State& before, const State& after, bool positions);

/// Moves `state` on to the constraints, from where it is, and makes its velocities agree with them. Fails
/// with the names of rows that contradict others or cannot be reached.
Result<Assembly> assemble(const System& system, const Parameters& parameters, State& state,
                          Workspace& workspace);

/// The same with a workspace of its own, for one-off use.
Result<Assembly> assemble(const System& system, State& state);

/// What putting a state back on the constraints did.
struct Projection {
  Eigen::VectorXd energy_before;    ///< kinetic + potential of each independent group at the state given, J
  Eigen::VectorXd velocity_change;  ///< of each group: the energy of what was changed of its velocities, J
  Fault fault;
  int unreached = -1;         ///< the row that would not come back; -1: all did
  Eigen::VectorXi worst_row;  ///< of each group: the row that was farthest off at the state given; -1: none
};

/// The rows that a row is left unmet by, for the end of a sentence: those that it depends on, and those that
/// are unmet beside it at the state that the workspace holds. Empty: none.
std::string contradiction(const System& system, const Workspace& workspace, int row);

/// Puts the state after an accepted step back on the constraints: positions, then velocities. Allocates only
/// where `projection` is new.
void project(const System& system, const Parameters& parameters, State& state, Workspace& workspace,
             Projection& projection);

}  // namespace borelli
