// Vectors of three are stored number by number (see articulated.cpp).
#define EIGEN_UNALIGNED_VECTORIZE 0
#include "dynamics/equations/recursive.hpp"

#include <span>

#include "dynamics/equations/armature.hpp"
#include "dynamics/equations/entries.hpp"
#include "dynamics/numbers/dual.hpp"
#include "dynamics/numbers/lanes.hpp"
#include "dynamics/numbers/processor.hpp"

namespace borelli {

using Eigen::Matrix3;
using Eigen::Vector3;

namespace {

/// Whether a step keeps the origin of the frame.
template <class Kind>
bool stays(const Parameters& parameters, int step) {
  return !Kind::slides && parameters.placements[step].form == Placement::Form::identity;
}

/// Vector from the origin before a step to that after it. The step must not begin at the world.
template <class T>
Vector3<T> arm(const System& system, const KinematicsOf<T>& k, const RecursionOf<T>& recursion, int s) {
  return k.origin(system.steps[s].u) - k.origin(system.steps[recursion.before[s]].u);
}

template <class T>
void add(const Wrench<T>& wrench, Wrench<T>& to) {
  to.n += wrench.n;
  to.f += wrench.f;
}

/// Numbers c to c + 2 of the twists of coordinate u and the following ones.
template <class T>
Vector3<typename EntriesOf<T>::Type> packs(const KinematicsOf<T>& k, int u, int c) {
  using Entries = EntriesOf<T>;
  return {Entries::load(&k.twists(u, c)), Entries::load(&k.twists(u, c + 1)),
          Entries::load(&k.twists(u, c + 2))};
}

/// The power of a wrench along the unit twist of coordinate u.
template <class Kind, class T>
T power(const KinematicsOf<T>& k, int u, const Wrench<T>& wrench) {
  if constexpr (!Kind::slides)
    return k.angular(u).dot(wrench.n);
  else if constexpr (!Kind::rotates)
    return k.linear(u).dot(wrench.f);
  else
    return k.angular(u).dot(wrench.n) + k.linear(u).dot(wrench.f);
}

}  // namespace

template <class T>
RecursionOf<T>::RecursionOf(const System& system)
    : composites(system.bodies.size()),
      carries(composites.size(), false),
      inertia(composites.size()),
      applied(composites.size()),
      carried(composites.size()),
      acted(composites.size()),
      before(system.steps.size()),
      first_columns{0} {
  std::vector<int> last(system.bodies.size(), -1);
  for (std::size_t b = 1; b < system.bodies.size(); ++b) {
    const Body& body = system.bodies[b];
    last[b] = last[body.parent];
    for (int s = body.first_step; s < body.first_step + body.step_count; ++s) {
      before[s] = last[b];
      const int begin = first_columns.back(), carried_by = before[s];
      if (carried_by >= 0)
        for (int c = first_columns[carried_by]; c < first_columns[carried_by + 1]; ++c)
          columns.push_back(Columns(columns[c]));
      const SwitchStep& step = system.steps[s];
      if (int(columns.size()) == begin || columns.back().first + columns.back().count != step.u)
        columns.push_back({step.u, 0});
      columns.back().count += step.nv;
      first_columns.push_back(int(columns.size()));
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
    if (!body.touched) continue;  // zero since construction
    const BodyMotionOf<T>& m = kinematics.bodies[b];
    Wrench<T>& inertia = recursion.inertia[b];
    Wrench<T>& applied = recursion.applied[b];
    applied = {efforts.moment[b], efforts.force[b]};  // about the gravity centre
    const Vector3<T> d = m.g - m.X.p;
    if (body.massive) {
      const auto& inertial = inertials[b];
      const Matrix3<T>& R = m.X.R;  // moments in the body's axes, in which the tensor is given
      const Vector3<T> w = R.transpose() * m.w, wdot = R.transpose() * m.wdot;
      const Vector3<T> momentum = inertial.tensor * w;
      const Vector3<T> moment = inertial.tensor * wdot + w.cross(momentum);
      const Vector3<T> weight = inertial.mass * parameters.gravity;
      inertia.f = inertial.mass * m.vdot;
      inertia.n = R * moment + d.cross(inertia.f);
      applied.f += weight;
      const T kinetic = 0.5 * (inertial.mass * m.v.squaredNorm() + w.dot(momentum));
      const T height = weight.dot(m.g);
      terms.kinetic += kinetic;
      terms.potential -= height;
      terms.group_kinetic[body.group] += kinetic;
      terms.group_potential[body.group] -= height;
    }
    applied.n += d.cross(applied.f);
  }
  add_armature_energy(system, parameters, kinematics, terms);
}

template <class T>
void find_efforts_of(const System& system, const Parameters& parameters, const KinematicsOf<T>& kinematics,
                     const EffortSumsOf<T>& efforts, RecursionOf<T>& recursion, LagrangeTermsOf<T>& terms) {
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
            const Vector3<T> r = arm(system, kinematics, recursion, s);
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

/// Wrenches that unit accelerations of a step's coordinates need, at its origin: per component of moment and
/// force, one number per coordinate.
template <class Kind, class T>
struct Asked {
  static constexpr int room =
      (Kind::nv + EntriesOf<T>::count - 1) / EntriesOf<T>::count * EntriesOf<T>::count;
  T moment[3][room], force[3][room];
};

template <class Kind, class T>
Asked<Kind, T> ask(const KinematicsOf<T>& k, int u, const CompositeBody<T>& composite) {
  using Entries = EntriesOf<T>;
  using Pack = typename Entries::Type;
  const Symmetric3<T>& I = composite.second;
  const Symmetric3<Pack> second{Pack(I.xx), Pack(I.xy), Pack(I.xz), Pack(I.yy), Pack(I.yz), Pack(I.zz)};
  const Vector3<Pack> first = composite.first.template cast<Pack>();
  Asked<Kind, T> out;
  for (int i = 0; i < Kind::nv; i += Entries::count) {
    const Vector3<Pack> w = packs<T>(k, u + i, 0), l = packs<T>(k, u + i, 3);
    Vector3<Pack> moment = Vector3<Pack>::Zero(), force = moment;
    if (Kind::rotates) {
      moment = second * w;
      force = w.cross(first);
    }
    if (Kind::slides) {
      moment += first.cross(l);
      force += Pack(composite.mass) * l;
    }
    const auto keep = [&](const Vector3<Pack>& from, auto& to) {
      Entries::store(from[0], &to[0][i]);
      Entries::store(from[1], &to[1][i]);
      Entries::store(from[2], &to[2][i]);
    };
    keep(moment, out.moment);
    keep(force, out.force);
  }
  return out;
}

/// Rows of A of a step: powers of its wrenches along the unit twists of all coordinates before it on the
/// chain, and its own.
template <class Kind, class T>
void find_rows(const KinematicsOf<T>& k, int u, const Asked<Kind, T>& asked,
               std::span<const typename RecursionOf<T>::Columns> chain, RowsOf<T>& A) {
  using Entries = EntriesOf<T>;
  using Pack = typename Entries::Type;
  const Vector3<Pack> origin = k.origin(u).template cast<Pack>();
  const T* const twists = k.twists.data();
  T* const rows = A.data() + u * A.cols();
  const Eigen::Index height = k.twists.rows(), width = A.cols();
  for (const auto& columns : chain)
    for (int begin = 0; begin < columns.count; begin += Entries::count) {
      // the last pack overlaps the one before
      const int first = columns.first + std::max(0, std::min(begin, columns.count - Entries::count));
      const int count = std::min(Entries::count, columns.count);
      const auto twist = [&, from = twists + first](int c) { return Entries::load(from + c * height); };
      const Vector3<Pack> w(twist(0), twist(1), twist(2));
      const Vector3<Pack> r(origin[0] - twist(6), origin[1] - twist(7), origin[2] - twist(8));
      const Vector3<Pack> v((twist(3) + w[1] * r[2]) - w[2] * r[1], (twist(4) + w[2] * r[0]) - w[0] * r[2],
                            (twist(5) + w[0] * r[1]) - w[1] * r[0]);
      Pack entries[Kind::nv];
      for (int i = 0; i < Kind::nv; ++i) {
        entries[i] = w[0] * asked.moment[0][i];
        entries[i] += w[1] * asked.moment[1][i];
        entries[i] += w[2] * asked.moment[2][i];
        entries[i] += v[0] * asked.force[0][i];
        entries[i] += v[1] * asked.force[1][i];
        entries[i] += v[2] * asked.force[2][i];
      }
      if (first >= u + Kind::nv) [[unlikely]] {  // driven coordinates that carry this step
        for (int i = 0; i < Kind::nv; ++i)
          for (int e = 0; e < count; ++e) A(first + e, u + i) = Entries::get(entries[i], e);
      } else if (count == Entries::count) {
        for (int i = 0; i < Kind::nv; ++i) Entries::store(entries[i], rows + i * width + first);
      } else {
        for (int i = 0; i < Kind::nv; ++i)
          for (int e = 0; e < count; ++e) rows[i * width + first + e] = Entries::get(entries[i], e);
      }
    }
}

template <class T>
void find_mass_matrix_of(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials,
                         const KinematicsOf<T>& kinematics, RecursionOf<T>& recursion,
                         LagrangeTermsOf<T>& terms) {
  CompositeBody<T> composite;  // composite of the current body
  bool holds_child = false;    // it already holds a child, the body of the previous iteration
  for (int b = int(system.bodies.size()) - 1; b > 0; --b) {
    const Body& body = system.bodies[b];
    if (recursion.carries[b]) {
      if (holds_child)
        composite += recursion.composites[b];
      else
        composite = recursion.composites[b];
      holds_child = true;
      recursion.carries[b] = false;
    }
    if (body.massive) {
      const BodyMotionOf<T>& m = kinematics.bodies[b];
      const CompositeBody<T> own = rigid_body<T>(inertials[b].mass, central_tensor(inertials[b], m), m);
      if (holds_child)
        composite += own;
      else
        composite = own;
    } else if (!holds_child) {
      composite = {};
    }
    for (int s = body.first_step + body.step_count - 1; s >= body.first_step; --s)
      std::visit(
          [&]<class Kind>(const Kind&) {
            if constexpr (Kind::nv > 0) {
              const int u = system.steps[s].u;
              const auto asked = ask<Kind>(kinematics, u, composite);
              const int begin = recursion.first_columns[s], end = recursion.first_columns[s + 1];
              find_rows<Kind, T>(kinematics, u, asked, {&recursion.columns[begin], std::size_t(end - begin)},
                                 terms.A);
            }
            if (recursion.before[s] < 0 || stays<Kind>(parameters, s)) return;
            composite.move(arm(system, kinematics, recursion, s));
          },
          parameters.kinds[s]);
    holds_child = body.parent == b - 1;
    if (holds_child || body.parent == 0) continue;
    if (recursion.carries[body.parent])
      recursion.composites[body.parent] += composite;
    else
      recursion.composites[body.parent] = composite;
    recursion.carries[body.parent] = true;
  }
  add_armature_to_mass_matrix(system, parameters, terms);
}

// For double everything is inlined and compiled for several processors.
BORELLI_INLINED_FOR_PROCESSOR
void find_own_forces_of_numbers(const System& system, const Parameters& parameters,
                                const InertialsOf<double>& inertials, const Kinematics& kinematics,
                                const EffortSums& efforts, Recursion& recursion, LagrangeTerms& terms) {
  find_own_forces_of(system, parameters, inertials, kinematics, efforts, recursion, terms);
}
BORELLI_INLINED_FOR_PROCESSOR
void find_efforts_of_numbers(const System& system, const Parameters& parameters, const Kinematics& kinematics,
                             const EffortSums& efforts, Recursion& recursion, LagrangeTerms& terms) {
  find_efforts_of(system, parameters, kinematics, efforts, recursion, terms);
}
BORELLI_INLINED_FOR_PROCESSOR
void find_mass_matrix_of_numbers(const System& system, const Parameters& parameters,
                                 const InertialsOf<double>& inertials, const Kinematics& kinematics,
                                 Recursion& recursion, LagrangeTerms& terms) {
  find_mass_matrix_of(system, parameters, inertials, kinematics, recursion, terms);
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
void find_mass_matrix(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials,
                      const KinematicsOf<T>& kinematics, RecursionOf<T>& recursion,
                      LagrangeTermsOf<T>& terms) {
  if constexpr (std::is_same_v<T, double>)
    find_mass_matrix_of_numbers(system, parameters, inertials, kinematics, recursion, terms);
  else if constexpr (is_lanes<T>)
    in_registers([]<int>(auto&... each) { find_mass_matrix_of(each...); }, system, parameters, inertials,
                 kinematics, recursion, terms);
  else
    find_mass_matrix_of(system, parameters, inertials, kinematics, recursion, terms);
}

#define BORELLI_MASS_MATRIX_OVER(T)                                                       \
  template struct RecursionOf<T>;                                                         \
  template void find_mass_matrix(const System&, const Parameters&, const InertialsOf<T>&, \
                                 const KinematicsOf<T>&, RecursionOf<T>&, LagrangeTermsOf<T>&);
#define BORELLI_RECURSIVE_OVER(T)                                                                \
  BORELLI_MASS_MATRIX_OVER(T)                                                                    \
  template void find_own_forces(const System&, const Parameters&, const InertialsOf<T>&,         \
                                const KinematicsOf<T>&, const EffortSumsOf<T>&, RecursionOf<T>&, \
                                LagrangeTermsOf<T>&);                                            \
  template void find_efforts(const System&, const Parameters&, const KinematicsOf<T>&,           \
                             const EffortSumsOf<T>&, RecursionOf<T>&, LagrangeTermsOf<T>&);
BORELLI_RECURSIVE_OVER(double)
BORELLI_RECURSIVE_OVER(DualNumber)
BORELLI_MASS_MATRIX_OVER(Lanes)
template struct RecursionOf<Quad>;

}  // namespace borelli
