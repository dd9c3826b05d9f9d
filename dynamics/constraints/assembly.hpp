// Moves positions and velocities onto the constraints: assembly does this for the initial state, projection
// after every accepted step. Both apply the least correction in the norm of the mass matrix (Gauss-Newton).
#pragma once

#include "dynamics/equations/equations.hpp"

namespace borelli {

/// Rank and redundancy of the constraint rows at the assembled state.
struct Assembly {
  int rank = 0;
  std::vector<std::string> redundant;  ///< rows that depend on the others and are satisfied with them

  /// The largest change that assembly made to a coordinate.
  struct Move {
    double size = 0;         ///< m or rad, or these per second
    double relative = 0;     ///< `size` over the scene's length or 1 rad
    bool angle = false;      ///< whether `size` is an angle
    std::string coordinate;  ///< the coordinate's name; empty: nothing changed
  };
  Move position = {}, velocity = {};
};

/// The coordinate that differs most between two states; `positions`: compare positions, else velocities.
Assembly::Move largest_move(const System& system, const State& before, const State& after, bool positions);

/// Moves the positions of `state` onto the constraints and then corrects its velocities. Fails with the names
/// of rows that contradict others or cannot be reached.
Result<Assembly> assemble(const System& system, const Parameters& parameters, State& state,
                          Workspace& workspace);

/// The same, with its own workspace, for one-off use.
Result<Assembly> assemble(const System& system, State& state);

/// Result of a projection.
struct Projection {
  Eigen::VectorXd energy_before;    ///< per independent group, kinetic + potential before projection, J
  Eigen::VectorXd velocity_change;  ///< per group, kinetic energy of the velocity correction, J
  Fault fault;
  int unreached = -1;         ///< the row that did not converge; -1: all did
  Eigen::VectorXi worst_row;  ///< per group, the row with the largest residual before projection; -1: none
};

/// Names the rows that `row` contradicts, as the end of a sentence: the rows it depends on, and the other
/// rows with a residual at the state in the workspace. Empty: none.
std::string contradiction(const System& system, const Workspace& workspace, int row);

/// Projects the state after an accepted step onto the constraints: positions, then velocities. Allocates only
/// when `projection` is new.
void project(const System& system, const Parameters& parameters, State& state, Workspace& workspace,
             Projection& projection);

}  // namespace borelli
