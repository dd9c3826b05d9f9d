// Static equilibria: positions with Q(q, 0, t) + L^T lambda = 0 and h(q, t) = 0.
#pragma once

#include "dynamics/system/system.hpp"

namespace borelli {

struct Equilibrium {
  State state;                  ///< at rest
  Eigen::VectorXd multipliers;  ///< per constraint row; the least ones if rows are dependent
  int iterations = 0;
  double imbalance = 0;  ///< largest |Q + L^T lambda| times its coordinate's length (1 for a turn), relative
                         ///< to the largest term of that sum or to the stiffness times a move by one length;
                         ///< below 1e-10
  std::string holds_at;  ///< why the balance holds at its time only; empty: it lasts
};

/// Finds the equilibrium nearest along Newton's iteration from the positions of `start`, at its time. The
/// start is assembled first; its velocities are ignored. Newton's method uses the exact derivatives of the
/// residual (derivatives.hpp). Steps are damped after Levenberg and Marquardt when a full step does not lower
/// the residual. When no step does (a horizontal pendulum), the search moves along the forces.
///
/// The equilibrium may be stable or unstable: linearize() tells. Functions of time are frozen at the start's
/// time, and `holds_at` says if that matters. Fails by name if a drive or constraint moves at that time, if
/// the scene has contacts, or if no equilibrium is found; the last error names the coordinate or constraint
/// farthest from balance.
Result<Equilibrium> find_equilibrium(const System& system, const State& start);

}  // namespace borelli
