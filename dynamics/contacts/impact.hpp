// Impact laws: impulses of contacts that meet at one instant, from their velocities and the response of each
// velocity to each impulse. Positions do not change. The response already includes bilateral constraints and
// drives.
//
// No impact adds energy. Newton's or Poisson's restitution can, with friction (Kane, A dynamics puzzle,
// Stanford Mechanics Alumni Club Newsletter, 1984) or with different restitutions in simultaneous impacts.
// The rebound is then scaled back, between none and the law's, until the contact impulses do no net work, in
// the manner of Stronge (Rigid body collisions with friction, Proc. R. Soc. A 431, 1990).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "dynamics/scene/contact.hpp"
#include "dynamics/scene/settings.hpp"

namespace borelli {

/// n closed contacts; 3n rows: each contact's normal and two tangential ones (zero for a contact without
/// friction rows).
struct Shock {
  std::vector<ContactSurface> surfaces;
  Eigen::MatrixXd response;  ///< 3n x 3n: velocity per unit impulse, row by row, 1/kg
  Eigen::VectorXd velocity;  ///< 3n, m/s: before impact; negative normals approach
  /// n: slip direction (unit) of contacts that slide already; zero: none. Used by press().
  std::vector<Eigen::Vector2d> slip;
  std::vector<int> pair;  ///< n: identifies the two solids; contacts of one pair are resolved together under
                          ///< every law
};

struct ShockResult {
  bool settled = false;  ///< false: the impulses do not converge
  int jammed = -1;  ///< press(): contact that closes, with no impulse due to friction (Painleve); -1: none
  bool energetic = false;    ///< the rebound was scaled back to keep energy from rising
  Eigen::VectorXd impulse;   ///< 3n, N s
  Eigen::VectorXd velocity;  ///< 3n, m/s: after impact
  Eigen::VectorXd lost;      ///< n: energy lost at each contact (minus its impulse's work), J
};

/// Projects friction onto Coulomb's cone: a disc of radius `limit` for a given normal part.
inline Eigen::Vector2d on_friction_cone(const Eigen::Vector2d& friction, double limit) {
  const double squared = friction.squaredNorm();
  return squared > limit * limit ? Eigen::Vector2d(friction * (limit / std::sqrt(squared))) : friction;
}

/// Contacts that approach more slowly than `rest_speed` do not rebound.
ShockResult resolve(const Shock& shock, ImpactLaw law, RestitutionLaw restitution, double rest_speed);

/// Impulses, all at once and without rebound, that keep the contacts from closing and, within the limit of
/// friction, from slipping. Read as forces and accelerations, they tell which closed contacts hold. A contact
/// gets no impulse if friction presses it on faster than its normal force lifts it (Painleve).
ShockResult press(const Shock& shock);

}  // namespace borelli
