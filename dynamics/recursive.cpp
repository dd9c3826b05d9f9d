#include "dynamics/recursive.hpp"

#include "dynamics/armature.hpp"

#include "dynamics/dual.hpp"
#include "dynamics/lanes.hpp"

namespace borelli {

using Eigen::Matrix3;
using Eigen::Vector3;

namespace {

/// Whether the frame after a step has its origin where the one before it has.
bool stays(const System& system, const Parameters& parameters, int step) {
  return !system.steps[step].slides && parameters.placements[step].form == Placement::Form::identity;
}

/// From the origin of the frame before a step of a body to that after it.
template <class T>
Vector3<T> moved(const System& system, const KinematicsOf<T>& k, const Body& body, int step) {
  const Vector3<T>& before =
      step > body.first_step ? k.origin[system.steps[step - 1].u] : k.bodies[body.parent].X.p;
  return k.origin[system.steps[step].u] - before;
}

template <class T>
void add(const Wrench<T>& wrench, Wrench<T>& to) {
  to.n += wrench.n;
  to.f += wrench.f;
}

/// The power of a wrench along the unit twist of coordinate u.
template <class T>
T power(const KinematicsOf<T>& k, const Step& step, int u, const Wrench<T>& wrench) {
  if (!step.slides) return k.angular[u].dot(wrench.n);
  if (!step.rotates) return k.linear[u].dot(wrench.f);
  return k.angular[u].dot(wrench.n) + k.linear[u].dot(wrench.f);
}

/// R tensor R^T
template <class T, class Tensor>
Matrix3<T> tensor_in_world(const Matrix3<T>& R, const Tensor& tensor) {
  const Matrix3<T> half = R * tensor;
  Matrix3<T> I;
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j) I(j, i) = I(i, j) = half.row(i).dot(R.row(j));
  return I;
}

/// The tensor's change as its point moves by -r: of 2 r.h 1 - r h^T - h r^T, h the first moment.
template <class T>
Symmetric3<T> coupling(const Vector3<T>& r, const Vector3<T>& h) {
  const T xx = 2 * r[0] * h[0], yy = 2 * r[1] * h[1], zz = 2 * r[2] * h[2];
  const T xy = -(r[0] * h[1] + r[1] * h[0]), xz = -(r[0] * h[2] + r[2] * h[0]),
          yz = -(r[1] * h[2] + r[2] * h[1]);
  return {yy + zz, xy, xz, xx + zz, yz, xx + yy};
}

}  // namespace

template <class T>
RecursionOf<T>::RecursionOf(const System& system)
    : own(system.bodies.size()),
      composites(own),
      inertia(own.size()),
      applied(own.size()),
      carried(own.size()),
      acted(own.size()) {}

template <class T>
void find_own_forces(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials,
                     const KinematicsOf<T>& kinematics, const EffortSumsOf<T>& efforts,
                     RecursionOf<T>& recursion, LagrangeTermsOf<T>& terms) {
  terms.kinetic = 0;
  terms.potential = efforts.potential;
  terms.group_kinetic.setZero();
  terms.group_potential = efforts.group_potential;
  for (std::size_t b = 1; b < system.bodies.size(); ++b) {
    const Body& body = system.bodies[b];
    if (!body.touched) continue;  // as it was made: without mass and force
    const BodyMotionOf<T>& m = kinematics.bodies[b];
    Wrench<T>& inertia = recursion.inertia[b];
    Wrench<T>& applied = recursion.applied[b];
    applied = {efforts.moment[b], efforts.force[b]};  // about the gravity centre
    const Vector3<T> d = m.g - m.X.p;
    if (body.massive) {
      const auto& inertial = inertials[b];
      const Matrix3<T> I_W = tensor_in_world<T>(m.X.R, inertial.tensor);
      const Vector3<T> momentum = I_W * m.w;
      const Vector3<T> weight = inertial.mass * parameters.gravity;
      inertia.f = inertial.mass * m.vdot;
      inertia.n = I_W * m.wdot + m.w.cross(momentum) + d.cross(inertia.f);
      applied.f += weight;
      const T kinetic = 0.5 * (inertial.mass * m.v.squaredNorm() + m.w.dot(momentum));
      const T height = weight.dot(m.g);
      terms.kinetic += kinetic;
      terms.potential -= height;
      terms.group_kinetic[body.group] += kinetic;
      terms.group_potential[body.group] -= height;
      auto& own = recursion.own[b];
      own.mass = inertial.mass;
      own.first = inertial.mass * d;
      own.second = point_inertia<T>(inertial.mass, d);
      own.second += Symmetric3<T>::upper_of(I_W);
    }
    applied.n += d.cross(applied.f);
  }
  add_armature_energy(system, parameters, kinematics, terms);
}

template <class T>
void find_efforts(const System& system, const Parameters& parameters, const KinematicsOf<T>& kinematics,
                  const EffortSumsOf<T>& efforts, RecursionOf<T>& recursion, LagrangeTermsOf<T>& terms) {
  recursion.carried = recursion.inertia;
  recursion.acted = recursion.applied;
  for (int b = int(system.bodies.size()) - 1; b > 0; --b) {
    const Body& body = system.bodies[b];
    Wrench<T>& inertia = recursion.carried[b];
    Wrench<T>& applied = recursion.acted[b];
    for (int s = body.first_step + body.step_count - 1; s >= body.first_step; --s) {
      const Step& step = system.steps[s];
      for (int u = step.u; u < step.u + step.nv; ++u) {
        terms.B[u] = power(kinematics, step, u, inertia);
        terms.Q[u] = efforts.coordinate[u] + power(kinematics, step, u, applied);
      }
      if ((s == body.first_step && body.parent == 0) || stays(system, parameters, s)) continue;
      const Vector3<T> r = moved(system, kinematics, body, s);
      inertia.n += r.cross(inertia.f);
      applied.n += r.cross(applied.f);
    }
    if (body.parent == 0) continue;
    add(inertia, recursion.carried[body.parent]);
    add(applied, recursion.acted[body.parent]);
  }
  add_armature_to_bias(system, parameters, kinematics, terms);
}

template <class T>
void find_mass_matrix(const System& system, const Parameters& parameters, const KinematicsOf<T>& kinematics,
                      RecursionOf<T>& recursion, LagrangeTermsOf<T>& terms) {
  recursion.composites = recursion.own;
  T* entries = terms.A.data();
  for (int entry : system.pattern) entries[entry] = 0;
  for (int b = int(system.bodies.size()) - 1; b > 0; --b) {
    const Body& body = system.bodies[b];
    auto& composite = recursion.composites[b];
    for (int s = body.first_step + body.step_count - 1; s >= body.first_step; --s) {
      const Step& step = system.steps[s];
      const Matrix3<T> second = composite.second.full();
      for (int u = step.u; u < step.u + step.nv; ++u) {
        const Vector3<T>&w = kinematics.angular[u], &l = kinematics.linear[u];
        Wrench<T> wrench;  // what moves all of it along the coordinate
        if (step.rotates) wrench = {second * w, w.cross(composite.first)};
        if (step.slides) add<T>({composite.first.cross(l), composite.mass * l}, wrench);
        int above = s, at = b;  // down to the root: its power along each coordinate
        for (int i = step.u; i <= u; ++i) terms.A(u, i) = power(kinematics, step, i, wrench);
        while (above > system.bodies[at].first_step || system.bodies[at].parent != 0) {
          if (!stays(system, parameters, above))
            wrench.n += moved(system, kinematics, system.bodies[at], above).cross(wrench.f);
          if (above == system.bodies[at].first_step) {
            at = system.bodies[at].parent;
            above = system.bodies[at].first_step + system.bodies[at].step_count;
          }
          --above;
          const Step& other = system.steps[above];
          for (int i = other.u; i < other.u + other.nv; ++i)
            terms.A(std::max(u, i), std::min(u, i)) = power(kinematics, other, i, wrench);
        }
      }
      if ((s == body.first_step && body.parent == 0) || stays(system, parameters, s)) continue;
      const Vector3<T> r = moved(system, kinematics, body, s);
      Symmetric3<T> change = coupling<T>(r, composite.first);
      change += point_inertia<T>(composite.mass, r);
      composite.second += change;
      composite.first += composite.mass * r;
    }
    if (body.parent == 0) continue;
    auto& parent = recursion.composites[body.parent];
    parent.mass += composite.mass;
    parent.first += composite.first;
    parent.second += composite.second;
  }
  add_armature_to_mass_matrix(system, parameters, terms);
}

#define BORELLI_RECURSIVE_OVER(T)                                                                           \
  template struct RecursionOf<T>;                                                                           \
  template void find_own_forces(const System&, const Parameters&, const InertialsOf<T>&,                    \
                                const KinematicsOf<T>&, const EffortSumsOf<T>&, RecursionOf<T>&,            \
                                LagrangeTermsOf<T>&);                                                       \
  template void find_efforts(const System&, const Parameters&, const KinematicsOf<T>&,                      \
                             const EffortSumsOf<T>&, RecursionOf<T>&, LagrangeTermsOf<T>&);                 \
  template void find_mass_matrix(const System&, const Parameters&, const KinematicsOf<T>&, RecursionOf<T>&, \
                                 LagrangeTermsOf<T>&);
BORELLI_RECURSIVE_OVER(double)
BORELLI_RECURSIVE_OVER(DualNumber)
BORELLI_RECURSIVE_OVER(Lanes)

}  // namespace borelli
