// How points, the gravity centre and the momentum of a scene go with its velocities: Jacobians over the free
// coordinates, and what of the accelerations they leave (dJ/dt v).
#pragma once

#include "dynamics/kinematics.hpp"

namespace borelli {

/// A point fixed in a solid. World axes, m, s. Velocity = jacobian v + what drives give it, acceleration =
/// jacobian a + bias; likewise the angular ones of its solid. The columns of a ball are those of its angular
/// velocity in its own axes.
struct PointMotion {
  Eigen::Vector3d position, velocity, angular_velocity;
  Eigen::Matrix3Xd jacobian, angular_jacobian;  ///< 3 x nv
  Eigen::Vector3d bias, angular_bias;           ///< accelerations at a = 0
};

/// Mass, gravity centre and momenta of all moving solids.
struct Momenta {
  double mass = 0;                                   ///< kg
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< gravity centre, m; without mass: the world's origin
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< of the gravity centre, m/s
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();    ///< momentum, kg m/s
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();   ///< about the gravity centre, kg m^2/s
};

/// The centroidal momentum matrix and its bias: h = (angular about the gravity centre, linear) = matrix v +
/// what drives give it, dh/dt = matrix a + bias (Orin, Goswami, Lee, Centroidal dynamics of a humanoid robot,
/// Autonomous Robots 35, 2013, equations 7 and 24). Of the gravity centre, matrix and bias are the last three
/// rows over the mass. Armatures have no part in it.
struct CentroidalMomentum {
  Eigen::Matrix<double, 6, Eigen::Dynamic> matrix;  ///< 6 x nv
  Eigen::Matrix<double, 6, 1> bias;
};

/// A body's angular momentum about its gravity centre, kg m^2/s.
inline Eigen::Vector3d spin(const Inertial& inertial, const BodyMotion& motion) {
  const Eigen::Vector3d own = motion.X.R.transpose() * motion.w;  // velocity in the body's axes
  return motion.X.R * Eigen::Vector3d(inertial.tensor * own);
}

/// From the kinematics of either set of equations, which were given no accelerations.
Momenta momenta(const System& system, const Parameters& parameters, const Kinematics& kinematics);
CentroidalMomentum centroidal_momentum(const System& system, const Parameters& parameters,
                                       const Kinematics& kinematics);

/// At a state. Fails where the point's solid is not in the scene ("world" neither) or the point not finite.
Result<PointMotion> point_motion(const System& system, const State& state, const SolidPoint& at);

}  // namespace borelli
