// The terms of the equations of motion by recursions along the tree, over the same System, kinematics and
// efforts as the paper's scan (lagrange.hpp), and equal to it but for rounding: A (composite rigid bodies,
// O(n depth)), B and Q (recursive Newton-Euler, O(n)). See Featherstone, Rigid Body Dynamics Algorithms,
// 2008, chapters 5 and 6. The accelerations themselves, where no row asks for A, are articulated.hpp's.
//
// Here motions and forces are written in world axes at the origin of the frame they concern, so that no
// digits are lost far from the world's origin; a ball is three coordinates one after the other in one point.
#pragma once

#include "dynamics/equations/kinematics.hpp"
#include "dynamics/equations/lagrange.hpp"
#include "dynamics/equations/passes.hpp"
#include "dynamics/numbers/symmetric.hpp"
#include "dynamics/numbers/wrench.hpp"

namespace borelli {

/// A body with all that it carries, held rigid; about the frame's origin.
template <class T>
struct CompositeBody {
  T mass = 0;
  Eigen::Vector3<T> first = Eigen::Vector3<T>::Zero();  ///< mass times centre, kg m
  Symmetric3<T> second;                                 ///< inertia tensor, kg m^2
};

/// Scratch of the recursions; one per thread.
template <class T>
struct RecursionOf {
  explicit RecursionOf(const System& system);

  std::vector<CompositeBody<T>> composites;  ///< per body: what its children add to it
  std::vector<char> carries;                 ///< per body, within find_mass_matrix: one has added to it
  std::vector<Wrench<T>> inertia, applied;   ///< per body: own inertial force, what acts on it
  std::vector<Wrench<T>> carried, acted;     ///< the same of all that it carries
  std::vector<int> before;                   ///< per step: the step that carries it; -1: the world

  /// Columns of A with consecutive numbers. Per step, those of its chain up to its own, as few as can be;
  /// and where each step's begin (one more than there are steps).
  struct Columns {
    int first = 0, count = 0;
  };
  std::vector<Columns> columns;
  std::vector<int> first_columns;
};
using Recursion = RecursionOf<double>;

/// Each body's inertial force and what acts on it, at the origin of its frame; and the energies of `terms`.
template <class T>
void find_own_forces(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials,
                     const KinematicsOf<T>& kinematics, const EffortSumsOf<T>& efforts,
                     RecursionOf<T>& recursion, LagrangeTermsOf<T>& terms);

/// After find_own_forces, B and Q of `terms` over the extended coordinates; B with A a where the kinematics
/// were given a.
template <class T>
void find_efforts(const System& system, const Parameters& parameters, const KinematicsOf<T>& kinematics,
                  const EffortSumsOf<T>& efforts, RecursionOf<T>& recursion, LagrangeTermsOf<T>& terms);

/// A of `terms`, which must have room for it (LagrangeTermsOf with its mass matrix).
template <class T>
void find_mass_matrix(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials,
                      const KinematicsOf<T>& kinematics, RecursionOf<T>& recursion,
                      LagrangeTermsOf<T>& terms);

}  // namespace borelli
