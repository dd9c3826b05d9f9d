#include "dynamics/lagrange.hpp"

namespace borelli {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Adds one body's products of derivatives to the mass matrix.
void add_mass_matrix(const System& system, const Body& body, const double* D, double mass,
                     const Matrix3d& I_W, double* products, Rows& A) {
  const int n = body.support_count;
  const int* support = system.support.data() + body.first_support;
  const double *Vx = D, *Vy = D + n, *Vz = D + 2 * n, *Wx = D + 3 * n, *Wy = D + 4 * n, *Wz = D + 5 * n;
  for (int j = 0; j < n; ++j) {
    const double px = mass * Vx[j], py = mass * Vy[j], pz = mass * Vz[j];
    const double hx = I_W(0, 0) * Wx[j] + I_W(0, 1) * Wy[j] + I_W(0, 2) * Wz[j];
    const double hy = I_W(1, 0) * Wx[j] + I_W(1, 1) * Wy[j] + I_W(1, 2) * Wz[j];
    const double hz = I_W(2, 0) * Wx[j] + I_W(2, 1) * Wy[j] + I_W(2, 2) * Wz[j];
    for (int i = 0; i <= j; ++i)
      products[i] = Vx[i] * px + Vy[i] * py + Vz[i] * pz + Wx[i] * hx + Wy[i] * hy + Wz[i] * hz;
    const int u = support[j];
    for (int i = 0; i <= j; ++i) A(std::max(u, support[i]), std::min(u, support[i])) += products[i];
  }
}

/// Adds one body's virtual powers: those of its inertial forces to B, those of what acts on it to Q.
void add_powers(const System& system, const Body& body, const double* D, const Vector3d& inertia_force,
                const Vector3d& inertia_moment, const Vector3d& force, const Vector3d& moment,
                LagrangeTerms& terms) {
  const int n = body.support_count;
  const int* support = system.support.data() + body.first_support;
  for (int i = 0; i < n; ++i) {
    const Vector3d V(D[i], D[n + i], D[2 * n + i]), W(D[3 * n + i], D[4 * n + i], D[5 * n + i]);
    terms.B[support[i]] += V.dot(inertia_force) + W.dot(inertia_moment);
    terms.Q[support[i]] += V.dot(force) + W.dot(moment);
  }
}

}  // namespace

LagrangeTerms::LagrangeTerms(const System& system)
    : A(Rows::Zero(system.size(), system.size())),
      B(Eigen::VectorXd::Zero(system.size())),
      Q(B),
      group_kinetic(Eigen::VectorXd::Zero(system.groups)),
      group_potential(group_kinetic),
      products(system.size()) {}

void scan_solids(const System& system, const Parameters& parameters, const Kinematics& kinematics,
                 const EffortSums& efforts, LagrangeTerms& terms) {
  double* entries = terms.A.data();
  for (int entry : system.pattern) entries[entry] = 0;
  terms.B.setZero();
  terms.Q = efforts.coordinate;
  terms.kinetic = 0;
  terms.potential = efforts.potential;
  terms.group_kinetic.setZero();
  terms.group_potential = efforts.group_potential;
  for (std::size_t k = 1; k < system.bodies.size(); ++k) {
    const Body& body = system.bodies[k];
    if (!body.touched) continue;
    const BodyMotion& m = kinematics.bodies[k];
    const double* D = kinematics.derivatives.data() + m.derivatives;
    Vector3d inertia_force = Vector3d::Zero(), inertia_moment = Vector3d::Zero(), weight = Vector3d::Zero();
    if (body.massive) {
      const Inertial& inertial = parameters.inertials[k];
      const Matrix3d I_W = m.X.R * inertial.tensor * m.X.R.transpose();
      add_mass_matrix(system, body, D, inertial.mass, I_W, terms.products.data(), terms.A);
      const Vector3d momentum = I_W * m.w;
      weight = inertial.mass * parameters.gravity;
      inertia_force = inertial.mass * m.vdot;
      inertia_moment = I_W * m.wdot + m.w.cross(momentum);
      const double kinetic = 0.5 * (inertial.mass * m.v.squaredNorm() + m.w.dot(momentum));
      terms.kinetic += kinetic;
      terms.potential -= weight.dot(m.g);
      terms.group_kinetic[body.group] += kinetic;
      terms.group_potential[body.group] -= weight.dot(m.g);
    }
    add_powers(system, body, D, inertia_force, inertia_moment, weight + efforts.force[k], efforts.moment[k],
               terms);
  }
}

}  // namespace borelli
