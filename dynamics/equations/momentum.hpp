// Momenta of a scene, and which of them its structure conserves; part of the certificate.
//
// A group of solids tied to the world only through its joints conserves momentum along the root's first joint
// coordinates. Moving or turning all its solids together does no work against internal forces nor, in
// suitable directions, against gravity (Noether). Gravity is uniform: its impulse M g t is subtracted, and it
// has no moment about the gravity centre.
#pragma once

#include <string>
#include <vector>

#include "dynamics/equations/kinematics.hpp"

namespace borelli {

/// Mass, gravity centre and momenta of all moving solids.
struct Momenta {
  double mass = 0;                                     ///< kg
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();    ///< gravity centre, m; the world's origin if massless
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< of the gravity centre, m/s
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();    ///< momentum, kg m/s
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();   ///< about the gravity centre, kg m^2/s
};

/// Angular momenta of all bodies about their gravity centres, kg m^2/s. Computed once after every update of
/// the kinematics.
const std::vector<Eigen::Vector3d>& find_spins(const Parameters& parameters, Kinematics& kinematics);

/// Momenta from the kinematics of either set of equations.
Momenta momenta(const System& system, const Parameters& parameters, Kinematics& kinematics);

/// Linear or angular momentum of a group of bodies, projected on the directions in which it is conserved.
struct ConservedMomentum {
  enum class About { nothing, gravity_centre, fixed_point };  ///< nothing: linear momentum
  std::string name;
  std::vector<int> bodies;
  About about = About::nothing;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();           ///< the fixed point, world axes, m
  Eigen::Matrix3d directions = Eigen::Matrix3d::Identity();  ///< projector on the conserved directions
};

/// The momenta that the scene conserves.
std::vector<ConservedMomentum> conserved_momenta(const System& system, const Parameters& parameters);

/// A conserved momentum at one state.
struct MomentumValue {
  Eigen::Vector3d value =
      Eigen::Vector3d::Zero();  ///< kg m/s or kg m^2/s, minus the impulse of weight since t = 0
  double scale = 0;             ///< sum of the magnitudes of the bodies' own momenta
  double rounding =
      0;  ///< bound on rounding in the value; a solid that falls without turning has a value of that size
};
/// After update_kinematics, by either set of equations.
MomentumValue momentum_value(const ConservedMomentum& momentum, const Parameters& parameters,
                             Kinematics& kinematics);

}  // namespace borelli
