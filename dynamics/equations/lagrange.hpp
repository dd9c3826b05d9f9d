// The paper's hierarchical scan over the solids: mass matrix A, bias B and generalized efforts Q of A(q) a +
// B(q, v) = Q(q, v, t) + L^T lambda, from each body's derivatives over its support.
//
//   A_ij = sum_k  m_k V_ki . V_kj    + Omega_ki . (I_k Omega_kj)          (equations 9, 13)
//   B_i  = sum_k  m_k V_ki . Vdot_k  + Omega_ki . (I_k Omegadot_k + Omega_k x I_k Omega_k)
//   Q_i  = sum_k  V_ki . F_k         + Omega_ki . M_k                                      (virtual powers)
//
// Vdot_k and Omegadot_k are taken at zero acceleration of the free coordinates and include the terms of time.
// This form also holds for a ball, whose angular velocity in its own axes is not the rate of a coordinate. If
// all velocities are rates, B equals the paper's equation 11.
#pragma once

#include "dynamics/equations/kinematics.hpp"
#include "dynamics/equations/passes.hpp"

namespace borelli {

/// The terms over the extended coordinates: free, then driven.
template <class T>
struct LagrangeTermsOf {
  explicit LagrangeTermsOf(const System& system, bool mass_matrix = true);  ///< false: A is empty
  RowsOf<T> A;             ///< size x size, symmetric; only row >= column is kept, and only along branches
  Eigen::VectorX<T> B, Q;  ///< size; B includes A a if the kinematics were given accelerations a
  T kinetic = 0, potential = 0;                      ///< J; potential: weight and springs
  Eigen::VectorX<T> group_kinetic, group_potential;  ///< J, of each independent group
  std::vector<T> products;                           ///< scratch
};
using LagrangeTerms = LagrangeTermsOf<double>;

/// Fills `terms` after update_kinematics by the paper's equations; `efforts`: after scan_efforts.
template <class T>
void scan_solids(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials,
                 const KinematicsOf<T>& kinematics, const EffortSumsOf<T>& efforts,
                 LagrangeTermsOf<T>& terms);

}  // namespace borelli
