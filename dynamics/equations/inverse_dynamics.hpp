// Inverse dynamics by the recursive Newton-Euler algorithm over the links of the articulated bodies
// (articulated.hpp): outwards the motion, inwards the wrenches, O(n) (Featherstone, Rigid Body Dynamics
// Algorithms, 2008, chapter 5). Equal to A a + B - Q of the paper's scan (lagrange.hpp) but for rounding.
#pragma once

#include "dynamics/equations/articulated.hpp"

namespace borelli {

/// needed <- A a + B - Q (nv): the generalised forces that accelerations a (nv) at time t, positions q (nq)
/// and velocities v (nv) need beyond the scene's own. Over double and Lanes. Other results in the arguments
/// are scratch.
template <class T>
void inverse_dynamics(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials,
                      double t, const T* q, const T* v, const T* a, KinematicsOf<T>& kinematics,
                      EffortSumsOf<T>& efforts, ArticulationOf<T>& articulation, T* needed);

}  // namespace borelli
