// The equations of motion by recursions along the tree, each over the same System, kinematics and efforts as
// the paper's scan (lagrange.hpp), and equal to it but for rounding:
//
// - the terms A (composite rigid bodies, O(n depth)), B and Q (recursive Newton-Euler, O(n));
// - the accelerations themselves (articulated bodies, O(n)), where no constraint row asks for A.
//
// See Featherstone, Rigid Body Dynamics Algorithms, 2008, chapters 5 to 7. Here motions and forces are
// written in world axes at the origin of the frame they concern, so that no digits are lost far from the
// world's origin, and accelerations are what the free coordinates add to the motion at zero (or given)
// acceleration: velocities then enter the bodies' own forces only. A driven coordinate adds nothing and
// returns its effort; a ball is three coordinates one after the other in one point.
#pragma once

#include "dynamics/kinematics.hpp"
#include "dynamics/lagrange.hpp"
#include "dynamics/scan.hpp"

namespace borelli {

/// A force and its moment about the origin of the frame that it acts on; world axes, N, N m.
template <class T>
struct Wrench {
  Eigen::Vector3<T> n = Eigen::Vector3<T>::Zero();  ///< moment
  Eigen::Vector3<T> f = Eigen::Vector3<T>::Zero();  ///< force
};

/// A body with all that it carries, held rigid; about the frame's origin.
template <class T>
struct CompositeBody {
  T mass = 0;
  Eigen::Vector3<T> first = Eigen::Vector3<T>::Zero();   ///< mass times centre, kg m
  Eigen::Matrix3<T> second = Eigen::Matrix3<T>::Zero();  ///< inertia tensor, kg m^2
};

/// A body with all that it carries, free to follow: the wrench that gives it an acceleration of the frame's
/// origin is (I, H; H^T, M) (angular, linear) + bias.
template <class T>
struct ArticulatedBody {
  Eigen::Matrix3<T> I, H, M;
  Wrench<T> bias;
  // what an entry of the mass matrix is compared with: mass, first moment and half the trace of I, rigid
  T mass;
  Eigen::Vector3<T> first;
  T polar;
};

/// What the inward pass leaves of a coordinate for the outward one.
template <class T>
struct Pivot {
  Wrench<T> U;  ///< (I, H; H^T, M) times its twist
  T inverse;    ///< of what meets it alone, 1/kg or 1/(kg m^2)
  T rest;       ///< the effort that is left to accelerate it (of a drive: what the rest needs)
};

/// Scratch of the recursions; one per thread.
template <class T>
struct RecursionOf {
  explicit RecursionOf(const System& system);

  std::vector<CompositeBody<T>> own, composites;  ///< per body
  std::vector<Wrench<T>> inertia, applied;        ///< per body: own inertial force, what acts on it
  std::vector<Wrench<T>> carried, acted;          ///< the same of all that it carries
  std::vector<ArticulatedBody<T>> articulated;    ///< per body
  std::vector<Pivot<T>> pivots;                   ///< per extended coordinate
  std::vector<Wrench<T>> added;  ///< per body: acceleration (n angular, f linear) added to it
};
using Recursion = RecursionOf<double>;

/// Each body's own inertia, inertial force and what acts on it, at the origin of its frame; and the energies
/// of `terms`. What the functions below start from.
template <class T>
void find_own_forces(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials,
                     const KinematicsOf<T>& kinematics, const EffortSumsOf<T>& efforts,
                     RecursionOf<T>& recursion, LagrangeTermsOf<T>& terms);

/// B and Q of `terms`, over the extended coordinates; B with A a where the kinematics were given a.
template <class T>
void find_efforts(const System& system, const Parameters& parameters, const KinematicsOf<T>& kinematics,
                  const EffortSumsOf<T>& efforts, RecursionOf<T>& recursion, LagrangeTermsOf<T>& terms);

/// A of `terms`.
template <class T>
void find_mass_matrix(const System& system, const Parameters& parameters, const KinematicsOf<T>& kinematics,
                      RecursionOf<T>& recursion, LagrangeTermsOf<T>& terms);

/// The free accelerations a (nv) without constraints, and what the drives exert (driven_nv). `given` (nv, or
/// null) is added to the generalized efforts. False where a coordinate meets so little inertia beside what it
/// carries that rounding may have made it: then A must decide (factor_mass_matrix).
template <class T>
bool find_accelerations(const System& system, const Parameters& parameters, const KinematicsOf<T>& kinematics,
                        const EffortSumsOf<T>& efforts, const T* given, RecursionOf<T>& recursion, T* a,
                        T* drive_efforts);

}  // namespace borelli
