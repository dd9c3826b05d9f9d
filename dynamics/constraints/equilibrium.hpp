// Equilibria: positions at which everything stays at rest, Q(q, 0, t) + L^T lambda = 0 and h(q, t) = 0.
#pragma once

#include "dynamics/system/system.hpp"

namespace borelli {

struct Equilibrium {
  State state;                  ///< at rest
  Eigen::VectorXd multipliers;  ///< of the constraint rows; of dependent ones the least
  int iterations = 0;
  double imbalance = 0;  ///< what is left: the largest |Q + L^T lambda| of a coordinate, times its length (a
                         ///< turn: 1), against the largest such effort there is, or that a move by this
                         ///< length would call up; below 1e-10
};

/// The equilibrium that Newton's method comes to from the positions of `start` (put on the constraints
/// first; its velocities do not count), at its time: by the exact derivatives of the residual
/// (derivatives.hpp), damped after Levenberg and Marquardt where a full step would not lessen it, and pushed
/// downhill where none does (a level pendulum). It may be
/// stable or not: linearize() tells. What depends on time stands still at that time. Fails, by name, where a
/// drive or constraint moves then, where there are contacts, and where no equilibrium is found: with the
/// coordinate or constraint that is farthest from balance.
Result<Equilibrium> find_equilibrium(const System& system, const State& start);

}  // namespace borelli
