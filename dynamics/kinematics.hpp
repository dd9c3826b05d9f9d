// Where every body is and how it moves: the pose (the paper's positioning function Phi_k), its first
// derivatives by the coordinates of its support, as velocities (equation 12), and its acceleration at zero
// acceleration of the free coordinates, which is its second derivatives contracted with the velocities.
//
// The paper's q_0 = t: a driven coordinate is carried like a free one, with its rate and acceleration known.
#pragma once

#include <vector>

#include "dynamics/system.hpp"

namespace borelli {

/// One body at one instant. World axes, SI.
struct BodyMotion {
  Pose X;                                          ///< X_WB
  Eigen::Vector3d w = Eigen::Vector3d::Zero();     ///< angular velocity
  Eigen::Vector3d wdot = Eigen::Vector3d::Zero();  ///< its rate at zero free acceleration
  Eigen::Vector3d g = Eigen::Vector3d::Zero();     ///< gravity centre (B's origin without mass)
  Eigen::Vector3d v = Eigen::Vector3d::Zero();     ///< velocity of g
  Eigen::Vector3d vdot = Eigen::Vector3d::Zero();  ///< its rate at zero free acceleration
  int derivatives = 0;                             ///< where its block begins in Kinematics::derivatives
};

/// Scratch and result of update_kinematics; one per thread. Sized once for a System.
struct Kinematics {
  explicit Kinematics(const System& system);

  double t = 0;
  Eigen::VectorXd q;             ///< extended positions: free, then driven
  Eigen::VectorXd u;             ///< extended velocities: v, then driven rates
  Eigen::VectorXd acceleration;  ///< extended: zeros, then driven accelerations

  /// Per extended coordinate: the unit twist that it gives to all that it carries.
  std::vector<Eigen::Vector3d> angular, linear, origin;
  /// Twice the angular velocity before its switch, plus that of the switch itself: with it the second
  /// derivatives d2Phi/dq_i dq_j = Omega_min(i,j) x V_max(i,j) sum up over i and j to convective[i] x V_i u_i
  /// over i.
  std::vector<Eigen::Vector3d> convective;

  std::vector<BodyMotion> bodies;
  /// Per touched body, six rows over its support: V_ki of the gravity centre (x, y, z), then Omega_ki.
  std::vector<double> derivatives;

  /// Row c of body k's block (c = 0..2: V, 3..5: Omega), one number per coordinate of its support.
  const double* row(const System& system, int k, int c) const {
    return derivatives.data() + bodies[k].derivatives + c * system.bodies[k].support_count;
  }
};

/// Fills `kinematics` for time t, positions q (nq) and velocities v (nv).
void update_kinematics(const System& system, const Parameters& parameters, double t, const double* q,
                       const double* v, Kinematics& kinematics);

/// The second derivatives of body k's pose by the i-th and j-th coordinates of its support (positions in the
/// support): d V_ki / dq_j, of the gravity centre, and d Omega_ki / dq_j. For a ball's components, whose
/// velocities are not rates of coordinates, the derivative along the j-th unit velocity.
struct SecondDerivative {
  Eigen::Vector3d v, w;
};
SecondDerivative second_derivative(const System& system, const Kinematics& kinematics, int k, int i, int j);

}  // namespace borelli
