// Inverse dynamics: the efforts that given accelerations ask for, by the recursion of Newton and Euler over
// the links of the articulated bodies (articulated.hpp): outwards how they move, inwards the wrenches that
// this takes, O(n) (Featherstone, Rigid Body Dynamics Algorithms, 2008, chapter 5). Equal to A a + B - Q of
// the paper's scan (lagrange.hpp) but for rounding.
#pragma once

#include "dynamics/equations/articulated.hpp"

namespace borelli {

/// needed <- A a + B - Q (nv): what accelerations a (nv) at time t, positions q (nq) and velocities v (nv)
/// ask for beside the scene's own efforts. Over double and Lanes. Nothing else is to be relied on afterwards.
template <class T>
void inverse_dynamics(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials,
                      double t, const T* q, const T* v, const T* a, KinematicsOf<T>& kinematics,
                      EffortSumsOf<T>& efforts, ArticulationOf<T>& articulation, T* needed);

}  // namespace borelli
