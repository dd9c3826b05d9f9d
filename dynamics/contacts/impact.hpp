// Impact laws: the impulses of contacts that meet at one moment, from their velocities and from what an
// impulse on one does to the velocity of another. Positions stay; the bilateral constraints and all that is
// driven are in that matrix already.
//
// No impact gives energy: where Newton's or Poisson's restitution would (with friction they can: Kane, A
// dynamics puzzle, Stanford Mechanics Alumni Club Newsletter, 1984; or with unlike restitutions all at once),
// the rebound is scaled back between none at all and that law until the contacts' impulses do no work on
// balance, in the way of Stronge (Rigid body collisions with friction, Proc. R. Soc. A 431, 1990).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "dynamics/scene/contact.hpp"
#include "dynamics/scene/settings.hpp"

namespace borelli {

/// n contacts that are closed; 3n rows: each contact's normal and two across (zero where it has none).
struct Shock {
  std::vector<ContactSurface> surfaces;
  Eigen::MatrixXd response;  ///< 3n x 3n: velocity along a row by unit impulse along another, 1/kg
  Eigen::VectorXd velocity;  ///< 3n: before; a normal's is negative where they approach, m/s
  /// n: of contacts whose friction has a direction already, that of their slip (unit); zero: none. For
  /// press().
  std::vector<Eigen::Vector2d> slip;
  std::vector<int> pair;  ///< n: which two solids; the contacts of one pair meet at once under every law
};

struct ShockResult {
  bool settled = false;  ///< false: impulses follow each other without end
  int jammed = -1;       ///< press(): one that closes, but that friction leaves without an impulse; -1: none
  bool energetic = false;    ///< the rebound was scaled back, lest energy rise
  Eigen::VectorXd impulse;   ///< 3n, N s
  Eigen::VectorXd velocity;  ///< 3n, after
  Eigen::VectorXd lost;      ///< n: minus the work of each contact's impulse, J
};

/// Friction no larger than its limit: projected on Coulomb's cone (a disc, the normal part being given).
inline Eigen::Vector2d on_friction_cone(const Eigen::Vector2d& friction, double limit) {
  const double squared = friction.squaredNorm();
  return squared > limit * limit ? Eigen::Vector2d(friction * (limit / std::sqrt(squared))) : friction;
}

/// Contacts that approach more slowly than `rest_speed` do not rebound.
ShockResult resolve(const Shock& shock, ImpactLaw law, RestitutionLaw restitution, double rest_speed);

/// Impulses that keep the contacts from closing and from slipping, as far as friction can: without rebound,
/// all at once. Read as forces and accelerations: what holds at contacts that stay closed. A contact that
/// friction presses on faster than its normal force lifts it gets none.
ShockResult press(const Shock& shock);

}  // namespace borelli
