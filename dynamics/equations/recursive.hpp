// The terms of the equations of motion by recursions along the tree: A by composite rigid bodies, O(n depth),
// B and Q by recursive Newton-Euler, O(n). They use the same System, kinematics and efforts as the paper's
// scan (lagrange.hpp) and equal it but for rounding. See Featherstone, Rigid Body Dynamics Algorithms, 2008,
// chapters 5 and 6. Accelerations without active rows come from articulated.hpp.
//
// Motions and forces are in world axes at the origin of the frame they concern, so that no digits are lost
// far from the world's origin. A ball is three successive coordinates at one point.
#pragma once

#include "dynamics/equations/composite_body.hpp"
#include "dynamics/equations/lagrange.hpp"
#include "dynamics/equations/passes.hpp"
#include "dynamics/numbers/wrench.hpp"

namespace borelli {

/// Scratch of the recursions; one per thread.
template <class T>
struct RecursionOf {
  explicit RecursionOf(const System& system);

  std::vector<CompositeBody<T>> composites;  ///< per body: sum over its children
  std::vector<char> carries;                 ///< per body, in find_mass_matrix: `composites` holds a child
  std::vector<Wrench<T>> inertia, applied;   ///< per body: own inertial force, applied wrench
  std::vector<Wrench<T>> carried, acted;     ///< the same, summed over the body and all that it carries
  std::vector<int> before;                   ///< per step: the step before it; -1: the world

  /// Ranges of consecutive columns of A. Per step, as few as cover its chain up to its own; and where each
  /// step's ranges begin (one more than there are steps).
  struct Columns {
    int first = 0, count = 0;
  };
  std::vector<Columns> columns;
  std::vector<int> first_columns;
};
using Recursion = RecursionOf<double>;

/// Each body's inertial force and applied wrench, at the origin of its frame; and the energies of `terms`.
template <class T>
void find_own_forces(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials,
                     const KinematicsOf<T>& kinematics, const EffortSumsOf<T>& efforts,
                     RecursionOf<T>& recursion, LagrangeTermsOf<T>& terms);

/// After find_own_forces: B and Q of `terms` over the extended coordinates. B includes A a if the kinematics
/// were given a.
template <class T>
void find_efforts(const System& system, const Parameters& parameters, const KinematicsOf<T>& kinematics,
                  const EffortSumsOf<T>& efforts, RecursionOf<T>& recursion, LagrangeTermsOf<T>& terms);

/// A of `terms`, which must have been constructed with a mass matrix.
template <class T>
void find_mass_matrix(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials,
                      const KinematicsOf<T>& kinematics, RecursionOf<T>& recursion,
                      LagrangeTermsOf<T>& terms);

}  // namespace borelli
