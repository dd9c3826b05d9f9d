// How points, the gravity centre and the momentum of a scene go with its velocities: Jacobians over the free
// coordinates, and what of the accelerations they leave (dJ/dt v).
#pragma once

#include "dynamics/equations/momentum.hpp"

namespace borelli {

/// A point fixed in a solid. World axes, m, s. Velocity = jacobian v + what drives give it, acceleration =
/// jacobian a + bias; likewise the angular ones of its solid. The columns of a ball are those of its angular
/// velocity in its own axes.
struct PointMotion {
  Eigen::Vector3d position, velocity, angular_velocity;
  Eigen::Matrix3Xd jacobian, angular_jacobian;  ///< 3 x nv
  Eigen::Vector3d bias, angular_bias;           ///< accelerations at a = 0
};

/// The centroidal momentum matrix and its bias: h = (angular about the gravity centre, linear) = matrix v +
/// what drives give it, dh/dt = matrix a + bias (Orin, Goswami, Lee, Centroidal dynamics of a humanoid robot,
/// Autonomous Robots 35, 2013, equations 7 and 24). Of the gravity centre, matrix and bias are the last three
/// rows over the mass. Armatures have no part in it.
struct CentroidalMomentum {
  Eigen::Matrix<double, 6, Eigen::Dynamic> matrix;  ///< 6 x nv
  Eigen::Matrix<double, 6, 1> bias;
};

CentroidalMomentum centroidal_momentum(const System& system, const Parameters& parameters,
                                       Kinematics& kinematics);

/// At a state. Fails where the point's solid is not in the scene ("world" neither) or the point not finite.
Result<PointMotion> point_motion(const System& system, const State& state, const SolidPoint& at);

}  // namespace borelli
