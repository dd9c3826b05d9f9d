// The momenta of a scene, and which of them it conserves, read off its structure: part of the certificate.
//
// Solids that nothing ties to the world but switches conserve the momentum along the first of these: a
// displacement or turn of all of them alike changes neither their inner efforts nor, if gravity allows, their
// weight's work (Noether). Weight is uniform, so its impulse M g t is subtracted, and about the gravity
// centre it has no moment.
#pragma once

#include <string>
#include <vector>

#include "dynamics/equations/kinematics.hpp"

namespace borelli {

/// Mass, gravity centre and momenta of all moving solids.
struct Momenta {
  double mass = 0;                                   ///< kg
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< gravity centre, m; without mass: the world's origin
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< of the gravity centre, m/s
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();    ///< momentum, kg m/s
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();   ///< about the gravity centre, kg m^2/s
};

/// The angular momenta of all bodies about their gravity centres, kg m^2/s. They are found once after every
/// update of the kinematics, however many ask for them.
const std::vector<Eigen::Vector3d>& find_spins(const Parameters& parameters, Kinematics& kinematics);

/// From the kinematics of either set of equations, which were given no accelerations.
Momenta momenta(const System& system, const Parameters& parameters, Kinematics& kinematics);

/// Linear or angular momentum of some bodies, projected on the directions in which it is conserved.
struct ConservedMomentum {
  enum class About { nothing, gravity_centre, fixed_point };  ///< nothing: linear momentum
  std::string name;
  std::vector<int> bodies;
  About about = About::nothing;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();           ///< of a fixed point: world, m
  Eigen::Matrix3d directions = Eigen::Matrix3d::Identity();  ///< projector on them
};

/// What the scene conserves.
std::vector<ConservedMomentum> conserved_momenta(const System& system, const Parameters& parameters);

struct MomentumValue {
  Eigen::Vector3d value =
      Eigen::Vector3d::Zero();  ///< kg m/s or kg m^2/s, less the impulse of weight since t = 0
  double scale = 0;             ///< the sum of the bodies' own, without regard to direction
  double rounding =
      0;  ///< what of the value may be rounding: a solid that falls without turning has no other spin
};
MomentumValue momentum_value(const ConservedMomentum& momentum, const Parameters& parameters,
                             Kinematics& kinematics);

}  // namespace borelli
