#include "dynamics/recursive.hpp"

#include "dynamics/armature.hpp"

#include "dynamics/dual.hpp"

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

/// [a]x
template <class T>
Matrix3<T> cross_matrix(const Vector3<T>& a) {
  Matrix3<T> M;
  M << T(0), -a[2], a[1], a[2], T(0), -a[0], -a[1], a[0], T(0);
  return M;
}

/// The upper triangle, mirrored.
template <class T>
void mirror(Matrix3<T>& M) {
  M(1, 0) = M(0, 1);
  M(2, 0) = M(0, 2);
  M(2, 1) = M(1, 2);
}

/// R tensor R^T
template <class T, class Tensor>
Matrix3<T> turned(const Matrix3<T>& R, const Tensor& tensor) {
  const Matrix3<T> half = R * tensor;
  Matrix3<T> I;
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j) I(i, j) = half.row(i).dot(R.row(j));
  mirror(I);
  return I;
}

/// -m [d]x [d]x: the inertia about a point of a mass m at d from it.
template <class T>
Matrix3<T> point_inertia(const T& m, const Vector3<T>& d) {
  const T x = m * d[0], y = m * d[1], z = m * d[2];
  const T xx = x * d[0], yy = y * d[1], zz = z * d[2], xy = -x * d[1], xz = -x * d[2], yz = -y * d[2];
  Matrix3<T> I;
  I << yy + zz, xy, xz, xy, xx + zz, yz, xz, yz, xx + yy;
  return I;
}

/// The tensor's change as its point moves by -r: of 2 r.h 1 - r h^T - h r^T, h the first moment.
template <class T>
Matrix3<T> coupling(const Vector3<T>& r, const Vector3<T>& h) {
  const T xx = 2 * r[0] * h[0], yy = 2 * r[1] * h[1], zz = 2 * r[2] * h[2];
  const T xy = -(r[0] * h[1] + r[1] * h[0]), xz = -(r[0] * h[2] + r[2] * h[0]),
          yz = -(r[1] * h[2] + r[2] * h[1]);
  Matrix3<T> I;
  I << yy + zz, xy, xz, xy, xx + zz, yz, xz, yz, xx + yy;
  return I;
}

}  // namespace

template <class T>
RecursionOf<T>::RecursionOf(const System& system)
    : own(system.bodies.size()),
      composites(own),
      inertia(own.size()),
      applied(own.size()),
      carried(own.size()),
      acted(own.size()),
      articulated(own.size()),
      pivots(system.size()),
      added(own.size()) {}

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
      const Matrix3<T> I_W = turned<T>(m.X.R, inertial.tensor);
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
      own.second = I_W + point_inertia<T>(inertial.mass, d);
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
      for (int u = step.u; u < step.u + step.nv; ++u) {
        const Vector3<T>&w = kinematics.angular[u], &l = kinematics.linear[u];
        Wrench<T> wrench;  // what moves all of it along the coordinate
        if (step.rotates) wrench = {composite.second * w, w.cross(composite.first)};
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
      composite.second += coupling<T>(r, composite.first) + point_inertia<T>(composite.mass, r);
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

namespace {

/// The wrench that gives the frame the unit acceleration of coordinate u.
template <class T>
Wrench<T> wrench_of(const ArticulatedBody<T>& body, const KinematicsOf<T>& k, const Step& step, int u) {
  const Vector3<T>&w = k.angular[u], &l = k.linear[u];
  if (!step.slides) return {body.I * w, body.H.transpose() * w};
  if (!step.rotates) return {body.H * l, body.M * l};
  return {body.I * w + body.H * l, body.H.transpose() * w + body.M * l};
}

/// Lets the coordinate of a pivot follow: takes out of the body what then meets no resistance.
template <class T>
void release(const Pivot<T>& pivot, ArticulatedBody<T>& body) {
  const Vector3<T> n = pivot.inverse * pivot.U.n, f = pivot.inverse * pivot.U.f;
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      body.I(i, j) -= n[i] * pivot.U.n[j];
      body.M(i, j) -= f[i] * pivot.U.f[j];
    }
    for (int j = 0; j < 3; ++j) body.H(i, j) -= n[i] * pivot.U.f[j];
  }
  mirror(body.I);
  mirror(body.M);
  body.bias.n += pivot.rest * n;
  body.bias.f += pivot.rest * f;
}

/// Writes a body's inertia at a point that is -r away.
template <class T>
void shift(const Vector3<T>& r, ArticulatedBody<T>& body) {
  // H' = H + [r]x M, I' = I - H [r]x + [r]x H'^T
  const Matrix3<T> H = body.H;
  for (int j = 0; j < 3; ++j) body.H.col(j) += r.cross(body.M.col(j));
  const Matrix3<T>& G = body.H;
  body.I(0, 0) += r[1] * (H(0, 2) + G(0, 2)) - r[2] * (H(0, 1) + G(0, 1));
  body.I(1, 1) += r[2] * (H(1, 0) + G(1, 0)) - r[0] * (H(1, 2) + G(1, 2));
  body.I(2, 2) += r[0] * (H(2, 1) + G(2, 1)) - r[1] * (H(2, 0) + G(2, 0));
  body.I(0, 1) += r[2] * H(0, 0) - r[0] * H(0, 2) + r[1] * G(1, 2) - r[2] * G(1, 1);
  body.I(0, 2) += r[0] * H(0, 1) - r[1] * H(0, 0) + r[1] * G(2, 2) - r[2] * G(2, 1);
  body.I(1, 2) += r[0] * H(1, 1) - r[1] * H(1, 0) + r[2] * G(2, 0) - r[0] * G(2, 2);
  mirror(body.I);
  body.bias.n += r.cross(body.bias.f);
  body.polar += 2 * r.dot(body.first) + body.mass * r.squaredNorm();
  body.first += body.mass * r;
}

template <class T>
void add(const ArticulatedBody<T>& body, ArticulatedBody<T>& to) {
  to.I += body.I;
  to.H += body.H;
  to.M += body.M;
  add(body.bias, to.bias);
  to.mass += body.mass;
  to.first += body.first;
  to.polar += body.polar;
}

/// From the leaves to the roots: articulated inertias and what each coordinate must still accelerate.
template <class T>
bool gather(const System& system, const Parameters& parameters, const KinematicsOf<T>& k,
            const EffortSumsOf<T>& efforts, const T* given, RecursionOf<T>& recursion) {
  for (std::size_t b = 1; b < system.bodies.size(); ++b) {
    const auto& own = recursion.own[b];
    ArticulatedBody<T>& body = recursion.articulated[b];
    body.I = own.second;
    body.H = cross_matrix(own.first);
    body.M = own.mass * Matrix3<T>::Identity();
    body.bias = {recursion.inertia[b].n - recursion.applied[b].n,
                 recursion.inertia[b].f - recursion.applied[b].f};
    body.mass = own.mass;
    body.first = own.first;
    body.polar = 0.5 * own.second.trace();
  }
  for (int b = int(system.bodies.size()) - 1; b > 0; --b) {
    const Body& structure = system.bodies[b];
    ArticulatedBody<T>& body = recursion.articulated[b];
    for (int s = structure.first_step + structure.step_count - 1; s >= structure.first_step; --s) {
      const Step& step = system.steps[s];
      const bool at_root = s == structure.first_step && structure.parent == 0;
      for (int u = step.u + step.nv - 1; u >= step.u; --u) {
        Pivot<T>& pivot = recursion.pivots[u];
        pivot.U = wrench_of(body, k, step, u);
        pivot.rest = efforts.coordinate[u] - power(k, step, u, body.bias) -
                     parameters.armatures[s] * k.acceleration[u];
        if (step.drive >= 0) continue;
        if (given) pivot.rest += given[u];
        const T meets = power(k, step, u, pivot.U) + parameters.armatures[s];
        // no less than its entry of the mass matrix; what elimination leaves below 1e-14 of that is rounding
        T entry = parameters.armatures[s];
        if (step.rotates) entry += body.polar * k.angular[u].squaredNorm();
        if (step.slides) entry += body.mass * k.linear[u].squaredNorm();
        if (!(meets > 2e-14 * entry)) return false;
        pivot.inverse = 1 / meets;
        if (!at_root || u > step.u) release(pivot, body);
      }
      if (at_root || stays(system, parameters, s)) continue;
      shift<T>(moved(system, k, structure, s), body);
    }
    if (structure.parent > 0) add<T>(body, recursion.articulated[structure.parent]);
  }
  return true;
}

/// From the roots to the leaves: accelerations.
template <class T>
void spread(const System& system, const Parameters& parameters, const KinematicsOf<T>& k,
            RecursionOf<T>& recursion, T* a, T* drive_efforts) {
  for (std::size_t b = 1; b < system.bodies.size(); ++b) {
    const Body& body = system.bodies[b];
    Wrench<T>& added = recursion.added[b];
    added = recursion.added[body.parent];  // zero for the world
    for (int s = body.first_step; s < body.first_step + body.step_count; ++s) {
      const Step& step = system.steps[s];
      if ((s > body.first_step || body.parent > 0) && !stays(system, parameters, s))
        added.f += added.n.cross(moved(system, k, body, s));
      for (int u = step.u; u < step.u + step.nv; ++u) {
        const Pivot<T>& pivot = recursion.pivots[u];
        const T follows = pivot.U.n.dot(added.n) + pivot.U.f.dot(added.f);
        if (step.drive >= 0) {
          drive_efforts[u - system.nv] = follows - pivot.rest;
          continue;
        }
        a[u] = pivot.inverse * (pivot.rest - follows);
        if (step.rotates) added.n += a[u] * k.angular[u];
        if (step.slides) added.f += a[u] * k.linear[u];
      }
    }
  }
}

}  // namespace

template <class T>
bool find_accelerations(const System& system, const Parameters& parameters, const KinematicsOf<T>& kinematics,
                        const EffortSumsOf<T>& efforts, const T* given, RecursionOf<T>& recursion, T* a,
                        T* drive_efforts) {
  if (!gather(system, parameters, kinematics, efforts, given, recursion)) return false;
  spread(system, parameters, kinematics, recursion, a, drive_efforts);
  return true;
}

#define BORELLI_RECURSIVE_OVER(T)                                                                           \
  template struct RecursionOf<T>;                                                                           \
  template void find_own_forces(const System&, const Parameters&, const InertialsOf<T>&,                    \
                                const KinematicsOf<T>&, const EffortSumsOf<T>&, RecursionOf<T>&,            \
                                LagrangeTermsOf<T>&);                                                       \
  template void find_efforts(const System&, const Parameters&, const KinematicsOf<T>&,                      \
                             const EffortSumsOf<T>&, RecursionOf<T>&, LagrangeTermsOf<T>&);                 \
  template void find_mass_matrix(const System&, const Parameters&, const KinematicsOf<T>&, RecursionOf<T>&, \
                                 LagrangeTermsOf<T>&);                                                      \
  template bool find_accelerations(const System&, const Parameters&, const KinematicsOf<T>&,                \
                                   const EffortSumsOf<T>&, const T*, RecursionOf<T>&, T*, T*);
BORELLI_RECURSIVE_OVER(double)
BORELLI_RECURSIVE_OVER(DualNumber)

}  // namespace borelli
