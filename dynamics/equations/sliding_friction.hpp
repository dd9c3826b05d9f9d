// Coulomb's friction of contacts that slide: the friction coefficient times the normal force, against the
// slip. The normal forces are multipliers that the friction itself changes, so those of all sliding contacts
// are found together: with N0 the normal forces without friction and D_ij what friction of unit normal force
// at j adds to that at i, (1 - D) N = N0.
//
// Where 1 - D_jj <= 0 the friction presses contact j into the surface faster than its normal force can lift
// it: Painleve's case (Genot and Brogliato, New results on Painleve paradoxes, European Journal of Mechanics
// A/Solids 18, 1999).
#pragma once

#include <vector>

#include "dynamics/system/system.hpp"

namespace borelli {

struct Workspace;

/// Scratch and result for one System; without room until something slides.
struct SlidingFriction {
  std::vector<int> sliding;  ///< contacts that slide with friction
  Eigen::VectorXd force;     ///< per contact: the friction force, N, against the slip
  Eigen::VectorXd speed;     ///< per contact: of the slip, m/s
  Eigen::VectorXd gain;      ///< per contact: D_jj
  // scratch
  Rows response;     ///< per sliding contact: accelerations for unit normal force
  Rows multipliers;  ///< the same of all rows' multipliers
  Rows D;
  Eigen::VectorXd normal, row;
};

/// Adds to the accelerations and multipliers in `workspace`, solved without friction, those of the friction
/// of the contacts that slide. Multipliers of their rows across are the components of the friction force.
void add_sliding_friction(const System& system, const Parameters& parameters, Workspace& workspace);

}  // namespace borelli
