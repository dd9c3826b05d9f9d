// Jacobians of points, gravity centre and momentum over the free coordinates, and their bias accelerations
// (dJ/dt v).
#pragma once

#include "dynamics/equations/momentum.hpp"

namespace borelli {

/// A point fixed in a solid. World axes, m, s. Velocity = jacobian v + the drives' part, acceleration =
/// jacobian a + bias; likewise the angular ones of its solid. A ball's columns belong to its angular velocity
/// in its own axes.
struct PointMotion {
  Eigen::Vector3d position, velocity, angular_velocity;
  Eigen::Matrix3Xd jacobian, angular_jacobian;  ///< 3 x nv
  Eigen::Vector3d bias, angular_bias;           ///< accelerations at a = 0, drives included
};

/// Centroidal momentum matrix and its bias. h = (angular about the gravity centre, linear) = matrix v + the
/// drives' part, dh/dt = matrix a + bias (Orin, Goswami, Lee, Centroidal dynamics of a humanoid robot,
/// Autonomous Robots 35, 2013, equations 7 and 24). The last three rows over the mass are the gravity
/// centre's Jacobian and bias. Armatures are not included.
struct CentroidalMomentum {
  Eigen::Matrix<double, 6, Eigen::Dynamic> matrix;  ///< 6 x nv
  Eigen::Matrix<double, 6, 1> bias;
};

/// After update_kinematics at zero free accelerations.
CentroidalMomentum centroidal_momentum(const System& system, const Parameters& parameters,
                                       Kinematics& kinematics);

/// Motion of a point at a state. Fails if the scene has no such solid ("world" is not one), the point is not
/// finite, or the state does not fit.
Result<PointMotion> point_motion(const System& system, const State& state, const SolidPoint& at);

}  // namespace borelli
