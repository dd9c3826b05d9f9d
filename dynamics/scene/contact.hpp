// Unilateral constraints (the paper's u(q) >= 0): contacts that can press but not pull. Each contact is a row
// in the direction in which it opens and, where it can rub, two more across it: the velocity of the one
// surface over the other. A contact that is open asks nothing; a closed one holds its first row like any
// constraint, and all three where it sticks.
//
// A kind of constraint is unilateral if it says how many rows each of its contacts has (`contact_rows`); it
// then has a `surface`, or a `restitution` alone where it cannot rub.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "dynamics/numbers/scalar.hpp"

namespace borelli {

enum class Touch : char {
  open,     ///< no force
  sliding,  ///< touches; friction, if any, is the coefficient times the normal force, against the slip
  sticking  ///< touches and does not slip
};

struct ContactMode {
  Touch touch = Touch::open;
  double slip[2] = {0, 0};  ///< sliding: the unit direction of the slip along the two rows across, where the
                            ///< velocity is too small to say
  bool operator==(const ContactMode&) const = default;
};

inline bool any_closed(const std::vector<ContactMode>& modes) {
  return std::any_of(modes.begin(), modes.end(),
                     [](const ContactMode& mode) { return mode.touch != Touch::open; });
}

/// One point where two things can touch, as a System lists it.
struct Contact {
  int constraint = 0;
  int row = 0;  ///< of the normal; the two across follow it
  bool tangents = false;
  std::string name;  ///< the constraint's; with [k] where it has several contacts
};

/// What two things are to each other where they touch.
struct ContactSurface {
  double restitution = 0;  ///< 0: no rebound, 1: without loss
  double friction = 0;     ///< Coulomb's coefficient, for stick and slip alike

  /// Its fields stand among those of the constraint that it is part of.
  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("restitution", self.restitution);
    visit("friction", self.friction);
  }

  std::string complaint() const {
    if (!(restitution >= 0 && restitution <= 1)) return "its restitution must lie between 0 and 1";
    return friction >= 0 ? "" : "its friction must be 0 or more";
  }
};

/// m/s. A slip that has come down to less has ended; one below the second has the direction in which it went,
/// or was to begin: its own would follow the least of forces, in less time than any step.
inline constexpr double least_slip = 1e-10, least_steered_slip = 1e-6;

/// The slip direction of a sliding contact whose velocity across is `slip` (m/s). One that has turned round
/// is past its end, which is an event: until that is located friction goes on as before, smoothly.
template <class T>
void slip_direction(const ContactMode& mode, const T (&slip)[2], T (&direction)[2]) {
  using std::sqrt;
  const double x = value_of(slip[0]), y = value_of(slip[1]), along = x * mode.slip[0] + y * mode.slip[1];
  const double squares = x * x + y * y;
  direction[0] = mode.slip[0];
  direction[1] = mode.slip[1];
  if (squares <= least_steered_slip * least_steered_slip || (along < 0 && 2 * along * along >= squares))
    return;
  const T speed = sqrt(slip[0] * slip[0] + slip[1] * slip[1]);
  direction[0] = slip[0] / speed;
  direction[1] = slip[1] / speed;
}

}  // namespace borelli
