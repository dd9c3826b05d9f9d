#include "dynamics/equations/lagrange.hpp"

#include "dynamics/equations/armature.hpp"

#include "dynamics/numbers/dual.hpp"
#include "dynamics/numbers/lanes.hpp"

namespace borelli {

using Eigen::Matrix3;
using Eigen::Vector3;

namespace {

/// Zeroes the possible entries of the mass matrix: rows of each body's own coordinates over its support.
template <class T>
void clear_mass_matrix(const System& system, RowsOf<T>& A) {
  const int* const all = system.branches().support.data();
  for (std::size_t b = 1; b < system.bodies.size(); ++b) {
    const Body& body = system.bodies[b];
    const int* const support = all + body.first_support;
    for (int i = system.bodies[body.parent].support_count; i < body.support_count; ++i)
      for (int j = 0; j <= i; ++j) A(std::max(support[i], support[j]), std::min(support[i], support[j])) = 0;
  }
}

/// Adds one body's products of derivatives to the mass matrix.
template <class T>
void add_mass_matrix(const System& system, const Body& body, const T* D, const T& mass, const Matrix3<T>& I_W,
                     T* products, RowsOf<T>& A) {
  const int n = body.support_count;
  const int* support = system.branches().support.data() + body.first_support;
  const T *Vx = D, *Vy = D + n, *Vz = D + 2 * n, *Wx = D + 3 * n, *Wy = D + 4 * n, *Wz = D + 5 * n;
  for (int j = 0; j < n; ++j) {
    const T px = mass * Vx[j], py = mass * Vy[j], pz = mass * Vz[j];
    const T hx = I_W(0, 0) * Wx[j] + I_W(0, 1) * Wy[j] + I_W(0, 2) * Wz[j];
    const T hy = I_W(1, 0) * Wx[j] + I_W(1, 1) * Wy[j] + I_W(1, 2) * Wz[j];
    const T hz = I_W(2, 0) * Wx[j] + I_W(2, 1) * Wy[j] + I_W(2, 2) * Wz[j];
    for (int i = 0; i <= j; ++i)
      products[i] = Vx[i] * px + Vy[i] * py + Vz[i] * pz + Wx[i] * hx + Wy[i] * hy + Wz[i] * hz;
    const int u = support[j];
    for (int i = 0; i <= j; ++i) A(std::max(u, support[i]), std::min(u, support[i])) += products[i];
  }
}

/// Adds one body's virtual powers: of its inertial forces to B, of applied forces to Q.
template <class T>
void add_powers(const System& system, const Body& body, const T* D, const Vector3<T>& inertia_force,
                const Vector3<T>& inertia_moment, const Vector3<T>& force, const Vector3<T>& moment,
                LagrangeTermsOf<T>& terms) {
  const int n = body.support_count;
  const int* support = system.branches().support.data() + body.first_support;
  for (int i = 0; i < n; ++i) {
    const Vector3<T> V(D[i], D[n + i], D[2 * n + i]), W(D[3 * n + i], D[4 * n + i], D[5 * n + i]);
    terms.B[support[i]] += V.dot(inertia_force) + W.dot(inertia_moment);
    terms.Q[support[i]] += V.dot(force) + W.dot(moment);
  }
}

}  // namespace

template <class T>
LagrangeTermsOf<T>::LagrangeTermsOf(const System& system, bool mass_matrix)
    : A(RowsOf<T>::Zero(mass_matrix ? system.size() : 0, mass_matrix ? system.size() : 0)),
      B(Eigen::VectorX<T>::Zero(system.size())),
      Q(B),
      group_kinetic(Eigen::VectorX<T>::Zero(system.groups)),
      group_potential(group_kinetic),
      products(system.size()) {}

template <class T>
void scan_solids(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials,
                 const KinematicsOf<T>& kinematics, const EffortSumsOf<T>& efforts,
                 LagrangeTermsOf<T>& terms) {
  clear_mass_matrix(system, terms.A);
  terms.B.setZero();
  terms.Q = efforts.coordinate;
  terms.kinetic = 0;
  terms.potential = efforts.potential;
  terms.group_kinetic.setZero();
  terms.group_potential = efforts.group_potential;
  for (std::size_t k = 1; k < system.bodies.size(); ++k) {
    const Body& body = system.bodies[k];
    if (!body.touched) continue;
    const BodyMotionOf<T>& m = kinematics.bodies[k];
    const T* D = kinematics.derivatives.data() + m.derivatives;
    Vector3<T> inertia_force = Vector3<T>::Zero(), inertia_moment = Vector3<T>::Zero(),
               weight = Vector3<T>::Zero();
    if (body.massive) {
      const auto& inertial = inertials[k];
      const Matrix3<T> I_W = m.X.R * inertial.tensor * m.X.R.transpose();
      add_mass_matrix(system, body, D, inertial.mass, I_W, terms.products.data(), terms.A);
      const Vector3<T> momentum = I_W * m.w;
      weight = inertial.mass * parameters.gravity;
      inertia_force = inertial.mass * m.vdot;
      inertia_moment = I_W * m.wdot + m.w.cross(momentum);
      const T kinetic = 0.5 * (inertial.mass * m.v.squaredNorm() + m.w.dot(momentum));
      terms.kinetic += kinetic;
      terms.potential -= weight.dot(m.g);
      terms.group_kinetic[body.group] += kinetic;
      terms.group_potential[body.group] -= weight.dot(m.g);
    }
    add_powers<T>(system, body, D, inertia_force, inertia_moment, weight + efforts.force[k],
                  efforts.moment[k], terms);
  }
  add_armature_to_mass_matrix(system, parameters, terms);
  add_armature_to_bias(system, parameters, kinematics, terms);
  add_armature_energy(system, parameters, kinematics, terms);
}

#define BORELLI_LAGRANGE_OVER(T)                                                                             \
  template struct LagrangeTermsOf<T>;                                                                        \
  template void scan_solids(const System&, const Parameters&, const InertialsOf<T>&, const KinematicsOf<T>&, \
                            const EffortSumsOf<T>&, LagrangeTermsOf<T>&);
BORELLI_LAGRANGE_OVER(double)
BORELLI_LAGRANGE_OVER(DualNumber)
template struct LagrangeTermsOf<Lanes>;
template struct LagrangeTermsOf<Quad>;

}  // namespace borelli
