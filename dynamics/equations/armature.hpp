// Armature: inertia that moves with a joint coordinate but belongs to no solid, such as a motor's rotor
// behind its gear. It resists only the coordinate's own rate. J adds to the diagonal of A, J a to the
// coordinate's inertial force, and J v^2 / 2 to the kinetic energy, whatever the solids do (Featherstone,
// Rigid Body Dynamics Algorithms, 2008, section 9.6; MuJoCo's `armature`). Both sets of equations use it.
#pragma once

#include "dynamics/equations/kinematics.hpp"
#include "dynamics/equations/lagrange.hpp"

namespace borelli {

/// Calls visit(u, J) for every extended velocity u whose switch has an armature J (kg or kg m^2).
template <class Visit>
void for_each_armature(const System& system, const Parameters& parameters, Visit&& visit) {
  for (std::size_t s = 0; s < system.steps.size(); ++s) {
    if (parameters.armatures[s] == 0) continue;
    const SwitchStep& step = system.steps[s];
    for (int u = step.u; u < step.u + step.nv; ++u) visit(u, parameters.armatures[s]);
  }
}

template <class T>
void add_armature_energy(const System& system, const Parameters& parameters,
                         const KinematicsOf<T>& kinematics, LagrangeTermsOf<T>& terms) {
  for_each_armature(system, parameters, [&](int u, double J) {
    const T kinetic = 0.5 * J * kinematics.u[u] * kinematics.u[u];
    terms.kinetic += kinetic;
    terms.group_kinetic[system.velocity_groups[u]] += kinetic;
  });
}

template <class T>
void add_armature_to_mass_matrix(const System& system, const Parameters& parameters,
                                 LagrangeTermsOf<T>& terms) {
  for_each_armature(system, parameters, [&](int u, double J) { terms.A(u, u) += J; });
}

/// Adds J times the given accelerations to B: those of drives, and of free coordinates if they were given.
template <class T>
void add_armature_to_bias(const System& system, const Parameters& parameters,
                          const KinematicsOf<T>& kinematics, LagrangeTermsOf<T>& terms) {
  for_each_armature(system, parameters,
                    [&](int u, double J) { terms.B[u] += J * kinematics.acceleration[u]; });
}

}  // namespace borelli
