// Vectors of three numbers are written one by one (see articulated.cpp).
#define EIGEN_UNALIGNED_VECTORIZE 0
#include "dynamics/recursive.hpp"

#include "dynamics/armature.hpp"
#include "dynamics/dual.hpp"
#include "dynamics/lanes.hpp"
#include "dynamics/processor.hpp"

namespace borelli {

using Eigen::Matrix3;
using Eigen::Vector3;

namespace {

/// Whether the frame after a step has its origin where the one before it has.
template <class Kind>
bool stays(const Parameters& parameters, int step) {
  return !Kind::slides && parameters.placements[step].form == Placement::Form::identity;
}

/// From the origin of the frame before each step to that after it.
template <class T>
void find_arms(const System& system, const KinematicsOf<T>& k, RecursionOf<T>& recursion) {
  for (std::size_t b = 1; b < system.bodies.size(); ++b) {
    const Body& body = system.bodies[b];
    const Vector3<T>* before = &k.bodies[body.parent].X.p;
    for (int s = body.first_step; s < body.first_step + body.step_count; ++s) {
      const Vector3<T>* here = &k.origin[system.steps[s].u];
      recursion.arm[s] = *here - *before;
      before = here;
    }
  }
}

template <class T>
void add(const Wrench<T>& wrench, Wrench<T>& to) {
  to.n += wrench.n;
  to.f += wrench.f;
}

/// The power of a wrench along the unit twist of coordinate u.
template <class Kind, class T>
T power(const KinematicsOf<T>& k, int u, const Wrench<T>& wrench) {
  if constexpr (!Kind::slides)
    return k.angular[u].dot(wrench.n);
  else if constexpr (!Kind::rotates)
    return k.linear[u].dot(wrench.f);
  else
    return k.angular[u].dot(wrench.n) + k.linear[u].dot(wrench.f);
}

/// R tensor R^T, with less work where the body's axes are principal ones.
template <class T, class Tensor>
Matrix3<T> tensor_in_world(const Matrix3<T>& R, const Tensor& tensor) {
  Matrix3<T> half, I;
  bool principal = false;
  if constexpr (std::is_same_v<T, double>)
    principal = tensor(0, 1) == 0 && tensor(0, 2) == 0 && tensor(1, 2) == 0;
  if (principal)
    for (int j = 0; j < 3; ++j) half.col(j) = R.col(j) * tensor(j, j);
  else
    half.noalias() = R * tensor;
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
      acted(own.size()),
      before(system.steps.size()),
      arm(system.steps.size()) {
  std::vector<int> last(system.bodies.size(), -1);
  for (std::size_t b = 1; b < system.bodies.size(); ++b) {
    const Body& body = system.bodies[b];
    last[b] = last[body.parent];
    for (int s = body.first_step; s < body.first_step + body.step_count; ++s) {
      before[s] = last[b];
      last[b] = s;
    }
  }
}

namespace {

template <class T>
void find_own_forces_of(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials,
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
void find_efforts_of(const System& system, const Parameters& parameters, const KinematicsOf<T>& kinematics,
                     const EffortSumsOf<T>& efforts, RecursionOf<T>& recursion, LagrangeTermsOf<T>& terms) {
  find_arms(system, kinematics, recursion);
  recursion.carried = recursion.inertia;
  recursion.acted = recursion.applied;
  for (int b = int(system.bodies.size()) - 1; b > 0; --b) {
    const Body& body = system.bodies[b];
    Wrench<T> inertia = recursion.carried[b], applied = recursion.acted[b];
    for (int s = body.first_step + body.step_count - 1; s >= body.first_step; --s)
      std::visit(
          [&]<class Kind>(const Kind&) {
            const int u = system.steps[s].u;
            for (int i = u; i < u + Kind::nv; ++i) {
              terms.B[i] = power<Kind>(kinematics, i, inertia);
              terms.Q[i] = efforts.coordinate[i] + power<Kind>(kinematics, i, applied);
            }
            if (recursion.before[s] < 0 || stays<Kind>(parameters, s)) return;
            const Vector3<T> r = recursion.arm[s];
            inertia.n += r.cross(inertia.f);
            applied.n += r.cross(applied.f);
          },
          parameters.kinds[s]);
    if (body.parent == 0) continue;
    add(inertia, recursion.carried[body.parent]);
    add(applied, recursion.acted[body.parent]);
  }
  add_armature_to_bias(system, parameters, kinematics, terms);
}

/// The columns of a step: what moves the composite along its coordinates, as powers along its own and those
/// of all that carries it.
template <class Kind, class T>
void find_columns(const System& system, const Parameters& parameters, const KinematicsOf<T>& k, int s,
                  const CompositeBody<T>& composite, const RecursionOf<T>& recursion,
                  LagrangeTermsOf<T>& terms) {
  const int u = system.steps[s].u;
  const Matrix3<T> second = composite.second.full();
  Wrench<T> wrench[Kind::nv + 1];
  for (int i = 0; i < Kind::nv; ++i) {
    const Vector3<T>&w = k.angular[u + i], &l = k.linear[u + i];
    if (Kind::rotates) wrench[i] = {second * w, w.cross(composite.first)};
    if (Kind::slides) add<T>({composite.first.cross(l), composite.mass * l}, wrench[i]);
    for (int j = 0; j <= i; ++j) terms.A(u + i, u + j) = power<Kind>(k, u + j, wrench[i]);
  }
  bool there = stays<Kind>(parameters, s);
  for (int via = s, above = recursion.before[s]; above >= 0; via = above, above = recursion.before[above]) {
    if (!there) {
      const Vector3<T> r = recursion.arm[via];
      for (int i = 0; i < Kind::nv; ++i) wrench[i].n += r.cross(wrench[i].f);
    }
    std::visit(
        [&]<class Above>(const Above&) {
          const int to = system.steps[above].u;
          for (int j = to; j < to + Above::nv; ++j)
            for (int i = 0; i < Kind::nv; ++i)
              terms.A(std::max(u + i, j), std::min(u + i, j)) = power<Above>(k, j, wrench[i]);
          there = stays<Above>(parameters, above);
        },
        parameters.kinds[above]);
  }
}

template <class T>
void find_mass_matrix_of(const System& system, const Parameters& parameters,
                         const KinematicsOf<T>& kinematics, RecursionOf<T>& recursion,
                         LagrangeTermsOf<T>& terms) {
  find_arms(system, kinematics, recursion);
  recursion.composites = recursion.own;
  for (int b = int(system.bodies.size()) - 1; b > 0; --b) {
    const Body& body = system.bodies[b];
    CompositeBody<T> composite = recursion.composites[b];
    for (int s = body.first_step + body.step_count - 1; s >= body.first_step; --s)
      std::visit(
          [&]<class Kind>(const Kind&) {
            find_columns<Kind, T>(system, parameters, kinematics, s, composite, recursion, terms);
            if (recursion.before[s] < 0 || stays<Kind>(parameters, s)) return;
            const Vector3<T> r = recursion.arm[s];
            Symmetric3<T> change = coupling<T>(r, composite.first);
            change += point_inertia<T>(composite.mass, r);
            composite.second += change;
            composite.first += composite.mass * r;
          },
          parameters.kinds[s]);
    if (body.parent == 0) continue;
    auto& parent = recursion.composites[body.parent];
    parent.mass += composite.mass;
    parent.first += composite.first;
    parent.second += composite.second;
  }
  add_armature_to_mass_matrix(system, parameters, terms);
}

// Over numbers themselves everything is inlined.
BORELLI_INLINED
void find_own_forces_of_numbers(const System& system, const Parameters& parameters,
                                const InertialsOf<double>& inertials, const Kinematics& kinematics,
                                const EffortSums& efforts, Recursion& recursion, LagrangeTerms& terms) {
  find_own_forces_of(system, parameters, inertials, kinematics, efforts, recursion, terms);
}
BORELLI_INLINED
void find_efforts_of_numbers(const System& system, const Parameters& parameters, const Kinematics& kinematics,
                             const EffortSums& efforts, Recursion& recursion, LagrangeTerms& terms) {
  find_efforts_of(system, parameters, kinematics, efforts, recursion, terms);
}
BORELLI_INLINED
void find_mass_matrix_of_numbers(const System& system, const Parameters& parameters,
                                 const Kinematics& kinematics, Recursion& recursion, LagrangeTerms& terms) {
  find_mass_matrix_of(system, parameters, kinematics, recursion, terms);
}

}  // namespace

template <class T>
void find_own_forces(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials,
                     const KinematicsOf<T>& kinematics, const EffortSumsOf<T>& efforts,
                     RecursionOf<T>& recursion, LagrangeTermsOf<T>& terms) {
  if constexpr (std::is_same_v<T, double>)
    find_own_forces_of_numbers(system, parameters, inertials, kinematics, efforts, recursion, terms);
  else
    find_own_forces_of(system, parameters, inertials, kinematics, efforts, recursion, terms);
}

template <class T>
void find_efforts(const System& system, const Parameters& parameters, const KinematicsOf<T>& kinematics,
                  const EffortSumsOf<T>& efforts, RecursionOf<T>& recursion, LagrangeTermsOf<T>& terms) {
  if constexpr (std::is_same_v<T, double>)
    find_efforts_of_numbers(system, parameters, kinematics, efforts, recursion, terms);
  else
    find_efforts_of(system, parameters, kinematics, efforts, recursion, terms);
}

template <class T>
void find_mass_matrix(const System& system, const Parameters& parameters, const KinematicsOf<T>& kinematics,
                      RecursionOf<T>& recursion, LagrangeTermsOf<T>& terms) {
  if constexpr (std::is_same_v<T, double>)
    find_mass_matrix_of_numbers(system, parameters, kinematics, recursion, terms);
  else
    find_mass_matrix_of(system, parameters, kinematics, recursion, terms);
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
