// Derivatives of inverse dynamics by recursion, O(n depth), exact to rounding. They give those of forward
// dynamics too (derivatives.hpp). Sources: Carpentier, Mansard, Analytical derivatives of rigid body dynamics
// algorithms, RSS 2018; Singh, Russell, Wensing, Efficient analytical derivatives of rigid-body dynamics
// using spatial vector algebra, IEEE RA-L 7(2), 2022.
//
// Notation. S_j: unit twist of coordinate j. v, a: spatial velocity and acceleration; index < for the frame
// before j's switch. x, x*: spatial cross products of motions and forces. A change of q_j rotates and shifts
// all that j carries by S_j. As seen from there, velocity and acceleration of each carried body change by
//
//   psi_j                  psi_j = v_< x S_j + p_j,  p_j = sum_i b_ij u_i
//   alpha_j + psi_j x v    alpha_j = a_< x S_j + v_< x psi_j + (v_< + v_s) x p_j + sum_i b_ij du_i/dt
//                                    + sum_ik c_ikj u_i u_k
//
// with v_s the twist of j's switch, b_ij the change of its S_i by q_j and c_ikj that of b_ik, as seen from the
// frame behind it; sums over the switch's coordinates. Only some switches have them (Bending). By u_j
// velocity and acceleration change by S_j and gamma_j + S_j x v, gamma_j = psi_j + dS_j/dt, where dS_j/dt =
// (v_< + v_s) x S_j + sum_k b_jk u_k. So the force f of a composite body that j carries, with the inertia I
// and the velocity matrix B, changes by S_j x* f + I alpha_j + B psi_j and I gamma_j + B S_j. For tau_i =
// S_i . f_i that gives
//
//   j at or before i:  dtau_i/dq_j = S_i . (I_i alpha_j + B_i psi_j)  (and b_ij . f_i within a switch)
//   j behind i:        dtau_i/dq_j = S_i . (S_j x* f_j + I_j alpha_j + B_j psi_j)
//   both:              dtau_i/du_j = S_i . (I gamma_j + B S_j),  with I and B of the later one.
//
// B psi is the sum over bodies of I (psi x v) + psi x* (I v) + v x* (I psi) (twice the B of Singh et al.).
// About the gravity centre, with the momentum p = m v, it is moment -2 w x (E psi_w), E = trace(J)/2 - J, and
// force 2 psi_w x p: the linear part of psi does not enter.
//
// The three components of a ball change one another's twist by the same rule: they turn with the frame behind
// it. Its directions are those of derivatives.hpp.
#pragma once

#include "dynamics/equations/composite_body.hpp"
#include "dynamics/equations/passes.hpp"
#include "dynamics/numbers/wrench.hpp"

namespace borelli {

/// A spatial motion: angular part, and the linear part at some point; world axes.
template <class T>
struct SpatialMotion {
  Eigen::Vector3<T> w, v;
};

/// A composite body, with the sums that the derivatives of its force need; about its frame's origin.
template <class T>
struct MovingComposite {
  CompositeBody<T> inertia;
  Eigen::Vector3<T> momentum = Eigen::Vector3<T>::Zero();  ///< sum of m v, kg m/s
  Eigen::Matrix3<T> gyration = Eigen::Matrix3<T>::Zero();  ///< moment of B psi per psi_w
  Wrench<T> force;                                         ///< inertial force less weight and efforts

  MovingComposite& operator+=(const MovingComposite& other);
  /// Moves the origin by -r.
  void move(const Eigen::Vector3<T>& r);
};

/// Results and scratch of find_inverse_derivatives; one per thread. Nothing allocates after the constructor.
///
/// A matrix with one row per extended coordinate (padded) and one column per number lets several coordinates
/// be loaded at once. Positions and velocities are relative to the frame of the first body of their tree, so
/// that no digits are lost far from the world's origin.
template <class T>
struct InverseDerivativesOf {
  explicit InverseDerivativesOf(const System& system);

  Eigen::VectorX<T> needed;  ///< nv: tau = A a + B - Q
  /// nv x 2 `half`: dtau/dq, then from column `half` on dtau/dv. `half` is nv, padded to whole registers.
  /// Entries off the branches stay as they are.
  RowsOf<T> by_state;
  int half = 0;
  RowsOf<T> A;  ///< nv x nv: dtau/da; only row >= column, and only along branches

  template <int columns>
  using Table = Eigen::Matrix<T, Eigen::Dynamic, columns>;
  Table<24> motions;  ///< twist, alpha, gamma, psi (angular, linear), at the tree's reference point
  static constexpr int twist = 0, alpha = 6, gamma = 12, psi = 18;  ///< their first columns
  SpatialMotion<T> motion(int u, int first) const {
    const auto n = [&](int i) { return motions(u, first + i); };
    return {{n(0), n(1), n(2)}, {n(3), n(4), n(5)}};
  }

  Table<18> frames;                     ///< see keep_frame
  Table<28> carried;                    ///< see keep_composite
  Table<21> factors;                    ///< see find_factors
  Table<18> bent;                       ///< see keep_bends; empty: nothing bends
  std::vector<SpatialMotion<T>> bends;  ///< of steps that bend, the rows b_i0, b_i1, ... of each coordinate i
  std::vector<int> bending;             ///< per step: the first of them; -1: none

  std::vector<MovingComposite<T>> composites;  ///< per body: sum over its children
  std::vector<char> carries;                   ///< per body: `composites` holds a child
  std::vector<int> roots;                      ///< per body: the first body of its tree

  /// Ranges of consecutive free coordinates: per step, those of its chain up to its own. first_ranges holds
  /// the offsets, one more than there are steps.
  struct Range {
    int first = 0, count = 0;
  };
  std::vector<Range> ranges;
  std::vector<int> first_ranges;
};
using InverseDerivatives = InverseDerivativesOf<double>;

/// Fills `out` after update_kinematics with accelerations a. `efforts` (after scan_efforts) may be null for
/// none. Applied wrenches and generalised forces count as constant in the axes of what they act on; see
/// action_derivatives.hpp for their own changes.
template <class T>
void find_inverse_derivatives(const System& system, const Parameters& parameters,
                              const InertialsOf<T>& inertials, const KinematicsOf<T>& kinematics,
                              const EffortSumsOf<T>* efforts, InverseDerivativesOf<T>& out);

}  // namespace borelli
