// Second derivatives of poses, from the products of first ones that the equations of motion add up.
#pragma once

#include "dynamics/equations/kinematics.hpp"

namespace borelli::test {

/// Second derivatives of body k's pose by the i-th and j-th coordinates of its support: d V_ki / dq_j of the
/// gravity centre, and d Omega_ki / dq_j. For a ball, whose velocities are not rates of coordinates: the
/// derivative along the j-th unit velocity. Not for switches that bend.
struct SecondDerivative {
  Eigen::Vector3d v, w;
};

inline SecondDerivative second_derivative(const System& system, const Kinematics& kinematics, int k, int i,
                                          int j) {
  const Body& body = system.bodies[k];
  const int* support = system.branches().support.data() + body.first_support;
  const int a = support[i], b = support[j];
  const auto V = [&](int n) {
    return Eigen::Vector3d(kinematics.row(system, k, 0)[n], kinematics.row(system, k, 1)[n],
                           kinematics.row(system, k, 2)[n]);
  };
  // The coordinate whose switch comes first, or any component of the same ball, rotates the other's motion.
  const auto step_of = [&](int u) {
    for (std::size_t s = 0; s < system.steps.size(); ++s)
      if (u >= system.steps[s].u && u < system.steps[s].u + system.steps[s].nv) return int(s);
    return -1;
  };
  if (step_of(b) <= step_of(a))
    return {kinematics.angular(b).cross(V(i)), kinematics.angular(b).cross(kinematics.angular(a))};
  return {kinematics.angular(a).cross(V(j)), Eigen::Vector3d::Zero()};
}

}  // namespace borelli::test
