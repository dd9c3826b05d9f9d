// Chooses the mode of each closed contact from the complementarity problem of the accelerations. A contact
// that holds must press; one that opens must not close. A sticking contact must stay within Coulomb's cone.
// Friction of a contact that begins to slide opposes its tangential acceleration; of one that slides already,
// its slip.
//
// The forces are found like the impulses of an impact without rebound (impact.hpp), to 1e-13 of the
// accelerations, or to 1e-8 if friction is exactly at its limit. Dependent contacts (a box on four corners)
// may share the load in many ways; the equations of motion later take the least.
#pragma once

#include "dynamics/contacts/impact.hpp"

namespace borelli {

/// The chosen modes.
struct Choice {
  bool settled = false;            ///< false: the forces do not converge
  int jammed = -1;                 ///< contact that no force can keep from closing (Painleve); -1: none
  std::vector<ContactMode> modes;  ///< one per contact
};

/// `contacts`: n closed contacts that neither approach nor separate. Its `velocity` holds the accelerations
/// without any contact force, m/s^2; its `slip` the slip directions of contacts that slide already.
/// `slip_at_limit`, one per contact: a sticking contact that has just reached its limit of friction slides in
/// this direction (unit) if its friction is still at that limit; zero: not at the limit. `gravity`, m/s^2:
/// with the accelerations it sets the scale below which an acceleration counts as zero.
Choice choose_modes(const Shock& contacts, const std::vector<Eigen::Vector2d>& slip_at_limit, double gravity);

}  // namespace borelli
