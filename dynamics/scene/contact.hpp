// Unilateral constraints (the paper's u(q) >= 0): contacts that push but cannot pull. Each contact has a
// normal row, in its opening direction. With friction it has two tangential rows too: the slip velocity of
// one surface over the other. An open contact enforces no row, a sliding one its normal row, a sticking one
// all three.
//
// A constraint kind is unilateral if it gives the number of rows per contact (`contact_rows`). It then has a
// `surface`, or a `restitution` alone if it has no friction.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "dynamics/numbers/scalar.hpp"

namespace borelli {

enum class Touch : char {
  open,     ///< no force
  sliding,  ///< closed; friction, if any, is the coefficient times the normal force, against the slip
  sticking  ///< closed, without slip
};

struct ContactMode {
  Touch touch = Touch::open;
  double slip[2] = {0, 0};  ///< sliding: unit slip direction along the two tangential rows, for velocities
                            ///< too small to define it
  bool operator==(const ContactMode&) const = default;
};

inline bool any_closed(const std::vector<ContactMode>& modes) {
  return std::any_of(modes.begin(), modes.end(),
                     [](const ContactMode& mode) { return mode.touch != Touch::open; });
}

/// One possible contact point, as listed in a System.
struct Contact {
  int constraint = 0;
  int row = 0;  ///< the normal row; the two tangential rows follow it
  bool tangents = false;
  std::string name;  ///< the constraint's name; with [k] if it has several contacts
};

/// Contact parameters of a pair of surfaces.
struct ContactSurface {
  double restitution = 0;  ///< coefficient of restitution; 0: no rebound, 1: no loss
  double friction = 0;     ///< Coulomb coefficient, the same for stick and slip

  /// In files its fields stand among those of the constraint that contains it.
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

/// m/s. A slip below least_slip has ended. A slip below least_steered_slip keeps the stored direction
/// (ContactMode::slip), since the smallest force turns so slow a slip faster than any step can follow.
inline constexpr double least_slip = 1e-10, least_steered_slip = 1e-6;

/// Unit slip direction of a sliding contact with the tangential velocity `slip` (m/s). A reversed slip has
/// passed the end of sliding, an event that is still to be located. Until then the stored direction is kept,
/// so that friction stays smooth.
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
