// Coulomb friction of sliding contacts: the friction coefficient times the normal force, opposed to the slip.
// Friction changes the normal forces, which are multipliers, so those of all sliding contacts are solved
// together. With N0 the normal forces without friction and D_ij the change of the normal force at i by the
// friction of unit normal force at j, (1 - D) N = N0.
//
// If 1 - D_jj <= 0, friction presses contact j into the surface faster than its normal force can lift it:
// Painleve's case (Genot and Brogliato, New results on Painleve paradoxes, European Journal of Mechanics
// A/Solids 18, 1999).
#pragma once

#include <vector>

#include "dynamics/system/system.hpp"

namespace borelli {

struct Workspace;

/// Scratch and result for one System; allocated when a contact first slides.
struct SlidingFriction {
  std::vector<int> sliding;  ///< contacts that slide with friction
  Eigen::VectorXd force;     ///< per contact: friction force opposed to the slip, N
  Eigen::VectorXd speed;     ///< per contact: slip speed, m/s
  Eigen::VectorXd gain;      ///< per contact: D_jj
  // scratch
  Rows response;     ///< per sliding contact: accelerations by the friction of unit normal force
  Rows multipliers;  ///< the same for the multipliers of all rows
  Rows D;
  Eigen::VectorXd normal, row;
};

/// Adds the effect of sliding friction to accelerations and multipliers in `workspace`, which were solved
/// without it. Multipliers of the tangential rows become the components of the friction force.
void add_sliding_friction(const System& system, const Parameters& parameters, Workspace& workspace);

}  // namespace borelli
