// Which closed contacts hold, and how: the complementarity problem of the accelerations. A contact that holds
// must press, one that lets go must not close; one that sticks must stay within Coulomb's cone, one that
// begins to slide must go against its friction, one that slides already has its friction against its slip.
//
// The forces are found as the impulses of an impact without rebound are (impact.hpp), to 1e-13 of the
// accelerations, where friction is at its very limit to 1e-8; contacts that depend on each other (a box on
// four corners) may then share the load in many ways, of which the equations of motion later take the least.
#pragma once

#include "dynamics/contacts/impact.hpp"

namespace borelli {

struct Choice {
  bool settled = false;
  int jammed = -1;  ///< a contact that no force can keep from closing (Painleve); -1: none
  std::vector<ContactMode> modes;
};

/// `contacts`: n closed ones that neither approach nor part; its `velocity` holds the accelerations that they
/// have without any of their forces, m/s^2, and `slip` the directions of those that slide. `slip_at_limit`:
/// where to those slide (unit) that come from sticking at the limit of their friction, if that is still
/// reached; zero: others. `gravity`, m/s^2: with the accelerations it says what is small.
Choice choose_modes(const Shock& contacts, const std::vector<Eigen::Vector2d>& slip_at_limit, double gravity);

}  // namespace borelli
