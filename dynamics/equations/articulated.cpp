// Vectors of three are stored number by number: a pair store read back as single numbers, or the reverse,
// stalls on memory.
#define EIGEN_UNALIGNED_VECTORIZE 0
#include "dynamics/equations/articulated.hpp"

#include <algorithm>
#include <span>

#include "dynamics/equations/armature.hpp"
#include "dynamics/equations/articulated_side.hpp"
#include "dynamics/equations/articulated_step.hpp"
#include "dynamics/numbers/dual.hpp"
#include "dynamics/numbers/lanes.hpp"
#include "dynamics/numbers/processor.hpp"

namespace borelli {

using Eigen::Vector3;
using namespace articulated;

namespace {

/// The link before a joint; null: the world.
template <class T>
LinkOf<T>* link_before(const Joint& joint, LinkOf<T>* links) {
  return joint.before < 0 ? nullptr : links + joint.before;
}

/// Whether the joint is a loose ball, which is eliminated at once.
bool is_loose(const Joint& joint, const Parameters& parameters) {
  return joint.free_ball && parameters.armatures[joint.step] == 0;
}

// The passes over alike trees are separate functions, so that the other passes keep their registers.
BORELLI_INLINED_FOR_PROCESSOR
void move_trees(const System& system, const Parameters& parameters, const InertialsOf<double>& inertials,
                bool given, const Kinematics& k, Articulation& articulation) {
  for (SideBySide& side : articulation.trees)
    move_side(system, parameters, inertials, given, articulation, k, side);
}

BORELLI_INLINED_FOR_PROCESSOR
void place_trees(const System& system, const Parameters& parameters, const Kinematics& k,
                 Articulation& articulation) {
  for (SideBySide& side : articulation.trees) place_side(system, parameters, articulation, k, side);
}

BORELLI_INLINED_FOR_PROCESSOR
void find_bodies_of_trees(const System& system, const Parameters& parameters,
                          const InertialsOf<double>& inertials, Kinematics& k, Articulation& articulation) {
  for (SideBySide& side : articulation.trees) {
    unswing(system, parameters, inertials, articulation, k, side);
    find_bodies_of_side(side, k);
  }
}

BORELLI_INLINED_FOR_PROCESSOR
bool free_trees(const System& system, const Parameters& parameters, const EffortSums* efforts,
                const double* given, Articulation& articulation) {
  for (SideBySide& side : articulation.trees)
    if (!free_side(system, parameters, efforts, given, articulation, side)) return false;
  return true;
}

BORELLI_INLINED_FOR_PROCESSOR
void find_energies_of_trees(const System& system, const Parameters& parameters,
                            const Articulation& articulation, LagrangeTerms& terms) {
  for (const SideBySide& side : articulation.trees) find_energies_of_side(system, parameters, side, terms);
}

BORELLI_INLINED_FOR_PROCESSOR
void follow_trees(const System& system, const Parameters& parameters, Articulation& articulation, double* a) {
  for (SideBySide& side : articulation.trees) follow_side(system, parameters, articulation, side, a);
}

template <class T>
std::span<const Joint> swinging(const ArticulationOf<T>& articulation) {
  return std::span(articulation.joints).subspan(articulation.first_swing);
}
template <class T>
std::span<const Joint> linked(const ArticulationOf<T>& articulation) {
  return std::span(articulation.joints)
      .first(articulation.swung ? articulation.first_swing : articulation.joints.size());
}

/// Moves the links; q, u and acceleration are extended. `given`: free accelerations are given; otherwise only
/// those of drives are read.
template <class T>
void move_all(const Parameters& parameters, const T* q, const T* u, const T* acceleration, bool given,
              std::span<const Joint> joints, ArticulationOf<T>& articulation) {
  articulation.placed = false;
  LinkOf<T>* const links = articulation.links.data();
  for (const Joint& joint : joints) {
    LinkOf<T>& link = links[joint.step];
    link.carries = false;
    const LinkOf<T>* before = link_before(joint, links);
    std::visit(
        [&]<class Kind>(const Kind& kind) {
          link.motion = move(kind, parameters.placements[joint.step],
                             turns_freely<Kind> && !given && is_loose(joint, parameters),
                             before ? &before->motion : nullptr, q + joint.q, u + joint.u,
                             given || joint.drive >= 0 ? acceleration + joint.u : nullptr,
                             articulation.pivots.data() + joint.u, link.turning);
        },
        parameters.kinds[joint.step]);
  }
}

/// Force and inverse inertia of the joints that use the pendulum equation. Returns false if some lane's
/// inertia is negligible.
template <class T>
bool swing_all(const Parameters& parameters, const InertialsOf<T>& inertials, const T* q,
               ArticulationOf<T>& articulation) {
  for (const Joint& joint : swinging(articulation)) {
    const Eigen::Vector3d pull = parameters.placements[joint.step].X.R.transpose() * parameters.gravity;
    const PendulumOf<T> swing =
        find_pendulum<T>(std::get_if<Rotation>(&parameters.kinds[joint.step])->axis, pull,
                         inertials[joint.body], parameters.armatures[joint.step]);
    if (!swing.sound) return false;
    PivotOf<T>& pivot = articulation.pivots[joint.u];
    const T angle = q[joint.q];
    pivot.inverse = 1 / swing.meets;
    pivot.rest = swing.cosine * sin(angle) - swing.sine * cos(angle);
  }
  return true;
}

template <class T>
void place_all(const Parameters& parameters, const KinematicsOf<T>& k, ArticulationOf<T>& articulation) {
  LinkOf<T>* const links = articulation.links.data();
  for (const Joint& joint : articulation.joints)
    std::visit(
        [&]<class Kind>(const Kind&) {
          find_place<Kind, T>(link_before(joint, links), k.u.data() + joint.u,
                              articulation.pivots.data() + joint.u, links[joint.step]);
        },
        parameters.kinds[joint.step]);
}

template <class T>
void find_bodies_of(const System& system, const InertialsOf<T>& inertials, KinematicsOf<T>& k,
                    const ArticulationOf<T>& articulation) {
  for (int b : articulation.alone) {
    const LinkOf<T>* frame = articulation.link(b);
    if (!frame) continue;
    const LinkMotion<T>& motion = frame->motion;
    BodyMotionOf<T>& m = k.bodies[b];
    m.X = {motion.R, frame->place.p};
    m.w = motion.w;
    m.g = frame->place.p;
    m.v = frame->place.v;
    if (!system.bodies[b].massive) continue;
    const Vector3<T> d = motion.R * inertials[b].centre;
    m.g += d;
    m.v += motion.w.cross(d);
  }
}

template <class T>
void find_energies_of(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials,
                      const KinematicsOf<T>& k, const EffortSumsOf<T>* efforts,
                      const ArticulationOf<T>& articulation, LagrangeTermsOf<T>& terms) {
  terms.kinetic = terms.potential = 0;
  terms.group_kinetic.setZero();
  terms.group_potential.setZero();
  if (efforts) {
    terms.potential = efforts->potential;
    terms.group_potential = efforts->group_potential;
  }
  add_armature_energy(system, parameters, k, terms);
  for (int b : articulation.alone) {
    const Body& body = system.bodies[b];
    if (!body.massive) continue;
    const auto [kinetic, potential] = energies<T>(inertials[b], parameters.gravity, *articulation.link(b));
    terms.kinetic += kinetic;
    terms.potential += potential;
    terms.group_kinetic[body.group] += kinetic;
    terms.group_potential[body.group] += potential;
  }
}

/// Wrench of the efforts on a body, at its frame's origin.
template <class T>
Wrench<T> applied_to(int b, const KinematicsOf<T>& k, const EffortSumsOf<T>& efforts, const LinkOf<T>& link) {
  const Vector3<T> d = k.bodies[b].g - link.place.p;
  return {efforts.moment[b] + d.cross(efforts.force[b]), efforts.force[b]};
}

/// Articulated body at a body's frame: its own inertia and bias plus its children's, minus applied wrenches.
/// `holds_child`: `carried` already holds one child.
template <class T>
void begin_body(const Body& body, const Parameters& parameters, int b, const InertialsOf<T>& inertials,
                const KinematicsOf<T>& k, const EffortSumsOf<T>* efforts, const LinkOf<T>& link, bool turning,
                bool holds_child, ArticulatedBody<T>& carried) {
  if (body.massive) {
    if (holds_child)
      put_own<true>(inertials[b], parameters.gravity, link.motion, turning, carried);
    else
      put_own<false>(inertials[b], parameters.gravity, link.motion, turning, carried);
  } else if (!holds_child) {
    carried = {};
  }
  if (link.carries) add(link.body, carried);
  if (efforts && body.touched) {
    const Wrench<T> applied = applied_to(b, k, *efforts, link);
    carried.bias.n -= applied.n;
    carried.bias.f -= applied.f;
    carried.extended = true;
  }
}

/// Whether the body of a loose joint is a pendant, provided that it carries nothing.
template <class T>
bool is_pendant(const Joint& joint, const System& system, const InertialsOf<T>& inertials) {
  if constexpr (is_lanes<T>)
    return joint.body >= 0 && system.bodies[joint.body].massive && inertials[joint.body].round;
  else
    return false;
}

template <class T>
bool accelerate_all(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials,
                    const KinematicsOf<T>& k, const EffortSumsOf<T>* efforts, const T* given,
                    ArticulationOf<T>& articulation, T* a, T* drive_efforts) {
  const auto stays = [&]<class Kind>(const Kind&, int s) {
    return !Kind::slides && parameters.placements[s].form == Placement::Form::identity;
  };
  LinkOf<T>* const links = articulation.links.data();
  PivotOf<T>* const pivots = articulation.pivots.data();
  const std::span<const Joint> joints = linked(articulation);
  ArticulatedBody<T> carried;  // articulated body carried by the current joint
  bool holds_child = false;    // `carried` already holds the previous joint, which this one carries
  for (auto at = joints.rbegin(); at != joints.rend(); ++at) {
    const Joint& joint = *at;
    LinkOf<T>& link = links[joint.step];
    const bool loose = is_loose(joint, parameters);
    const bool hangs = loose && !holds_child && !link.carries && is_pendant<T>(joint, system, inertials);
    if (joint.body >= 0 && !hangs)
      begin_body(system.bodies[joint.body], parameters, joint.body, inertials, k, efforts, link, !loose,
                 holds_child, carried);
    LinkOf<T>* const before = link_before(joint, links);
    const bool followed = std::visit(
        [&]<class Kind>(const Kind& kind) {
          const T* const acting = efforts ? efforts->coordinate.data() + joint.u : nullptr;
          const T* const added = given && joint.drive < 0 ? given + joint.u : nullptr;
          if (hangs) {
            if constexpr (is_lanes<T> && turns_freely<Kind>) {
              const auto hang = [&](const Wrench<T>* applied) {
                let_hang<T>(inertials[joint.body], parameters.gravity, applied, acting, added, !before,
                            carried, link);
              };
              if (efforts) {
                const Wrench<T> applied = applied_to(joint.body, k, *efforts, link);
                hang(&applied);
              } else {
                hang(nullptr);
              }
            }
          } else if (!free_step<Kind, T>(parameters.armatures[joint.step], loose, acting, added,
                                         joint.drive < 0 ? nullptr : k.acceleration.data() + joint.u, !before,
                                         pivots + joint.u, carried, link)) {
            return false;
          }
          if (before && !stays(kind, joint.step))
            move_origin<T>(link.motion.r, carried);
          else if (!carried.extended)
            flatten(carried);
          return true;
        },
        parameters.kinds[joint.step]);
    if (!followed) return false;
    holds_child = before && at + 1 != joints.rend() && at[1].step == joint.before;
    if (!before || holds_child) continue;
    if (before->carries)
      add(carried, before->body);
    else
      before->body = carried;
    before->carries = true;
  }
  for (const Joint& joint : joints)
    std::visit(
        [&]<class Kind>(const Kind& kind) {
          const PendantOf<T>* pendant = nullptr;
          if constexpr (is_lanes<T>)
            if (joint.body >= 0) pendant = &inertials[joint.body].pendant;
          follow<Kind, T>(stays(kind, joint.step), turns_freely<Kind> && is_loose(joint, parameters),
                          link_before(joint, links), pivots + joint.u, pendant, links[joint.step],
                          a + joint.u, joint.drive >= 0 ? drive_efforts + (joint.u - system.nv) : nullptr);
        },
        parameters.kinds[joint.step]);
  if constexpr (is_lanes<T>)
    if (articulation.swung)
      for (const Joint& joint : swinging(articulation)) {
        const PivotOf<T>& pivot = pivots[joint.u];
        a[joint.u] = pivot.inverse * (given ? pivot.rest + given[joint.u] : pivot.rest);
      }
  return true;
}

// For double everything is inlined and compiled for several processors.
BORELLI_INLINED_FOR_PROCESSOR
void move_numbers(const Parameters& parameters, const double* q, const double* u, const double* acceleration,
                  bool given, Articulation& articulation) {
  move_all<double>(parameters, q, u, acceleration, given, articulation.joints, articulation);
}
BORELLI_INLINED_FOR_PROCESSOR
void place_numbers(const Parameters& parameters, const Kinematics& k, Articulation& articulation) {
  place_all(parameters, k, articulation);
}
BORELLI_INLINED_FOR_PROCESSOR
void find_bodies_of_numbers(const System& system, const InertialsOf<double>& inertials, Kinematics& k,
                            const Articulation& articulation) {
  find_bodies_of(system, inertials, k, articulation);
}
BORELLI_INLINED_FOR_PROCESSOR
bool accelerate_numbers(const System& system, const Parameters& parameters,
                        const InertialsOf<double>& inertials, const Kinematics& k, const EffortSums* efforts,
                        const double* given, Articulation& articulation, double* a, double* drive_efforts) {
  return accelerate_all(system, parameters, inertials, k, efforts, given, articulation, a, drive_efforts);
}
BORELLI_INLINED_FOR_PROCESSOR
void find_energies_of_numbers(const System& system, const Parameters& parameters,
                              const InertialsOf<double>& inertials, const Kinematics& k,
                              const EffortSums* efforts, const Articulation& articulation,
                              LagrangeTerms& terms) {
  find_energies_of(system, parameters, inertials, k, efforts, articulation, terms);
}

/// move_all with lanes in registers.
template <class T>
void move_lanes(const Parameters& parameters, const T* q, const T* u, const T* acceleration, bool given,
                std::span<const Joint> joints, ArticulationOf<T>& articulation) {
  in_registers([]<int>(auto&... each) { move_all(each...); }, parameters, q, u, acceleration, given, joints,
               articulation);
}

}  // namespace

template <class T>
void move_links(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials, double t,
                const T* q, const T* v, const T* a, KinematicsOf<T>& kinematics,
                ArticulationOf<T>& articulation) {
  set_coordinates<T>(system, parameters, t, q, v, a, kinematics);
  const T *const positions = kinematics.q.data(), *const velocities = kinematics.u.data(),
                 *const accelerations = kinematics.acceleration.data();
  articulation.swung = false;
  if constexpr (std::is_same_v<T, DualNumber>)
    move_all<T>(parameters, positions, velocities, accelerations, a != nullptr, articulation.joints,
                articulation);
  else if constexpr (is_lanes<T>)
    move_lanes<T>(parameters, positions, velocities, accelerations, a != nullptr, articulation.joints,
                  articulation);
  else
    move_numbers(parameters, positions, velocities, accelerations, a != nullptr, articulation);
  if constexpr (std::is_same_v<T, double>)
    if (!articulation.trees.empty())
      move_trees(system, parameters, inertials, a != nullptr, kinematics, articulation);
}

template <class T>
void move_links_alone(const Parameters& parameters, const InertialsOf<T>& inertials, const T* q, const T* v,
                      ArticulationOf<T>& articulation) {
  articulation.swung =
      !swinging(articulation).empty() &&
      in_registers([]<int>(auto& p, auto& i, auto& x, auto& to) { return swing_all(p, i, x, to); },
                   parameters, inertials, q, articulation);
  move_lanes<T>(parameters, q, v, nullptr, false, linked(articulation), articulation);
}
template void move_links_alone(const Parameters&, const InertialsOf<Lanes>&, const Lanes*, const Lanes*,
                               ArticulationOf<Lanes>&);
template void move_links_alone(const Parameters&, const InertialsOf<Quad>&, const Quad*, const Quad*,
                               ArticulationOf<Quad>&);

namespace {

/// Positions and velocities of the links, once after each move_links.
template <class T>
void place_links(const System& system, const Parameters& parameters, const KinematicsOf<T>& kinematics,
                 ArticulationOf<T>& articulation) {
  if (articulation.placed) return;
  if constexpr (is_lanes<T>)
    if (articulation.swung)
      move_lanes<T>(parameters, kinematics.q.data(), kinematics.u.data(), nullptr, false,
                    swinging(articulation), articulation);
  articulation.swung = false;
  articulation.placed = true;
  if constexpr (std::is_same_v<T, DualNumber>)
    place_all(parameters, kinematics, articulation);
  else if constexpr (is_lanes<T>)
    in_registers([]<int>(auto&... each) { place_all(each...); }, parameters, kinematics, articulation);
  else
    place_numbers(parameters, kinematics, articulation);
  if constexpr (std::is_same_v<T, double>)
    if (!articulation.trees.empty()) place_trees(system, parameters, kinematics, articulation);
}

}  // namespace

template <class T>
void find_bodies(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials,
                 KinematicsOf<T>& kinematics, ArticulationOf<T>& articulation) {
  place_links(system, parameters, kinematics, articulation);
  kinematics.spins.clear();
  if constexpr (std::is_same_v<T, DualNumber>)
    find_bodies_of(system, inertials, kinematics, articulation);
  else if constexpr (is_lanes<T>)
    in_registers([]<int>(auto&... each) { find_bodies_of(each...); }, system, inertials, kinematics,
                 articulation);
  else
    find_bodies_of_numbers(system, inertials, kinematics, articulation);
  if constexpr (std::is_same_v<T, double>)
    if (!articulation.trees.empty())
      find_bodies_of_trees(system, parameters, inertials, kinematics, articulation);
}

template <class T>
bool find_accelerations(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials,
                        const KinematicsOf<T>& kinematics, const EffortSumsOf<T>* efforts, const T* given,
                        ArticulationOf<T>& articulation, T* a, T* drive_efforts) {
  if constexpr (std::is_same_v<T, DualNumber>) {
    return accelerate_all(system, parameters, inertials, kinematics, efforts, given, articulation, a,
                          drive_efforts);
  } else if constexpr (is_lanes<T>) {
    return in_registers([]<int>(auto&... each) { return accelerate_all(each...); }, system, parameters,
                        inertials, kinematics, efforts, given, articulation, a, drive_efforts);
  } else {
    const bool any_trees = !articulation.trees.empty();
    if (any_trees && !free_trees(system, parameters, efforts, given, articulation)) return false;
    if (!accelerate_numbers(system, parameters, inertials, kinematics, efforts, given, articulation, a,
                            drive_efforts))
      return false;
    if (any_trees) follow_trees(system, parameters, articulation, a);
    return true;
  }
}

template <class T>
void find_energies(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials,
                   const KinematicsOf<T>& kinematics, const EffortSumsOf<T>* efforts,
                   ArticulationOf<T>& articulation, LagrangeTermsOf<T>& terms) {
  place_links(system, parameters, kinematics, articulation);
  if constexpr (std::is_same_v<T, DualNumber>)
    find_energies_of(system, parameters, inertials, kinematics, efforts, articulation, terms);
  else if constexpr (is_lanes<T>)
    in_registers([]<int>(auto&... each) { find_energies_of(each...); }, system, parameters, inertials,
                 kinematics, efforts, articulation, terms);
  else
    find_energies_of_numbers(system, parameters, inertials, kinematics, efforts, articulation, terms);
  if constexpr (std::is_same_v<T, double>)
    if (!articulation.trees.empty()) find_energies_of_trees(system, parameters, articulation, terms);
}

#define BORELLI_ARTICULATED_OVER(T)                                                                    \
  template void move_links(const System&, const Parameters&, const InertialsOf<T>&, double, const T*,  \
                           const T*, const T*, KinematicsOf<T>&, ArticulationOf<T>&);                  \
  template void find_bodies(const System&, const Parameters&, const InertialsOf<T>&, KinematicsOf<T>&, \
                            ArticulationOf<T>&);                                                       \
  template bool find_accelerations(const System&, const Parameters&, const InertialsOf<T>&,            \
                                   const KinematicsOf<T>&, const EffortSumsOf<T>*, const T*,           \
                                   ArticulationOf<T>&, T*, T*);                                        \
  template void find_energies(const System&, const Parameters&, const InertialsOf<T>&,                 \
                              const KinematicsOf<T>&, const EffortSumsOf<T>*, ArticulationOf<T>&,      \
                              LagrangeTermsOf<T>&);
BORELLI_ARTICULATED_OVER(double)
BORELLI_ARTICULATED_OVER(DualNumber)
BORELLI_ARTICULATED_OVER(Lanes)
BORELLI_ARTICULATED_OVER(Quad)

}  // namespace borelli
