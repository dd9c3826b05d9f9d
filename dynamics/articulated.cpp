// Vectors of three numbers are written one by one: half of one in a register of two, read again number by
// number or the other way round, has to wait for memory.
#define EIGEN_UNALIGNED_VECTORIZE 0
#include "dynamics/articulated.hpp"

#include "dynamics/armature.hpp"
#include "dynamics/articulated_step.hpp"
#include "dynamics/dual.hpp"
#include "dynamics/lanes.hpp"
#include "dynamics/processor.hpp"

namespace borelli {

using Eigen::Vector3;
using namespace articulated;

namespace {

/// The link that the first step of a body begins from, or the step before; null: the world.
template <class T>
LinkOf<T>* link_before(const System& system, const Body& body, int s, ArticulationOf<T>& articulation) {
  if (s > body.first_step) return &articulation.links[s - 1];
  if (body.parent == 0) return nullptr;
  const Body& parent = system.bodies[body.parent];
  return &articulation.links[parent.first_step + parent.step_count - 1];
}

}  // namespace

template <class T>
ArticulationOf<T>::ArticulationOf(const System& system) : links(system.steps.size()), pivots(system.size()) {
  for (std::size_t b = 1; b < system.bodies.size(); ++b)
    if (system.bodies[b].step_count == 0) every_body_moves = false;
}

namespace {

template <class T>
void move_all(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials, double t,
              const T* q, const T* v, bool keep_bodies, KinematicsOf<T>& k, ArticulationOf<T>& articulation) {
  set_coordinates<T>(system, parameters, t, q, v, nullptr, k);
  for (std::size_t b = 1; b < system.bodies.size(); ++b) {
    const Body& body = system.bodies[b];
    const int end = body.first_step + body.step_count;
    for (int s = body.first_step; s < end; ++s) {
      const Step& step = system.steps[s];
      LinkOf<T>& link = articulation.links[s];
      link.carries = false;
      const LinkOf<T>* before = link_before(system, body, s, articulation);
      std::visit(
          [&]<class Kind>(const Kind& kind) {
            link.motion = move<Kind, T>(
                kind, step, parameters.placements[s], is_loose<Kind>(parameters, step, s),
                before ? &before->motion : nullptr, k, articulation.pivots.data() + step.u, link.turning);
          },
          parameters.kinds[s]);
    }
    if (!keep_bodies) continue;
    const LinkMotion<T>& motion = articulation.links[end - 1].motion;
    BodyMotionOf<T>& m = k.bodies[b];
    m.X = motion.X;
    m.w = motion.w;
    m.g = motion.X.p;
    m.v = motion.v;
    if (!body.massive) continue;
    const Vector3<T> d = motion.X.R * inertials[b].centre;
    m.g += d;
    m.v += motion.w.cross(d);
  }
}

/// What a body carries, at its frame: itself and what its children let it feel, less what acts on it.
template <class T>
ArticulatedBody<T> begin_body(const System& system, const Parameters& parameters, int b,
                              const InertialsOf<T>& inertials, const KinematicsOf<T>& k,
                              const EffortSumsOf<T>* efforts, const LinkOf<T>& link, bool turning,
                              LagrangeTermsOf<T>& terms) {
  const Body& body = system.bodies[b];
  ArticulatedBody<T> carried;
  if (body.massive) {
    carried = alone<T>(inertials[b], parameters.gravity, body.group, link.motion, turning, terms);
    if (link.carries) add(link.body, carried);
  } else if (link.carries) {
    carried = link.body;
  }
  if (efforts && body.touched) {
    const Vector3<T> d = k.bodies[b].g - link.motion.X.p;
    carried.bias.n -= efforts->moment[b] + d.cross(efforts->force[b]);
    carried.bias.f -= efforts->force[b];
    carried.extended = true;
  }
  return carried;
}

template <class T>
bool accelerate_all(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials,
                    const KinematicsOf<T>& k, const EffortSumsOf<T>* efforts, const T* given,
                    ArticulationOf<T>& articulation, LagrangeTermsOf<T>& terms, T* a, T* drive_efforts) {
  const auto stays = [&]<class Kind>(const Kind&, int s) {
    return !Kind::slides && parameters.placements[s].form == Placement::Form::identity;
  };
  terms.kinetic = terms.potential = 0;
  terms.group_kinetic.setZero();
  terms.group_potential.setZero();
  if (efforts) {
    terms.potential = efforts->potential;
    terms.group_potential = efforts->group_potential;
  }
  add_armature_energy(system, parameters, k, terms);
  for (int b = int(system.bodies.size()) - 1; b > 0; --b) {
    const Body& body = system.bodies[b];
    const int last = body.first_step + body.step_count - 1;
    const bool loose = std::visit(
        [&]<class Kind>(const Kind&) { return is_loose<Kind>(parameters, system.steps[last], last); },
        parameters.kinds[last]);
    ArticulatedBody<T> carried =
        begin_body(system, parameters, b, inertials, k, efforts, articulation.links[last], !loose, terms);
    for (int s = last; s >= body.first_step; --s) {
      const Step& step = system.steps[s];
      LinkOf<T>& link = articulation.links[s];
      LinkOf<T>* before = link_before(system, body, s, articulation);
      const bool followed = std::visit(
          [&]<class Kind>(const Kind& kind) {
            if (!free_step<Kind, T>(step, parameters.armatures[s], is_loose<Kind>(parameters, step, s),
                                    efforts ? efforts->coordinate.data() + step.u : nullptr,
                                    given && step.drive < 0 ? given + step.u : nullptr,
                                    k.acceleration.data() + step.u, !before,
                                    articulation.pivots.data() + step.u, carried, link))
              return false;
            if (before && !stays(kind, s)) carried = moved<T>(carried, link.motion.r);
            return true;
          },
          parameters.kinds[s]);
      if (!followed) return false;
      if (s > body.first_step || !before) continue;
      if (before->carries)
        add(carried, before->body);
      else
        before->body = carried;
      before->carries = true;
    }
  }
  for (std::size_t b = 1; b < system.bodies.size(); ++b) {
    const Body& body = system.bodies[b];
    for (int s = body.first_step; s < body.first_step + body.step_count; ++s) {
      const Step& step = system.steps[s];
      const LinkOf<T>* before = link_before(system, body, s, articulation);
      std::visit(
          [&]<class Kind>(const Kind& kind) {
            follow<Kind, T>(step, stays(kind, s), is_loose<Kind>(parameters, step, s), before,
                            articulation.pivots.data() + step.u, articulation.links[s], a + step.u,
                            step.drive >= 0 ? drive_efforts + (step.u - system.nv) : nullptr);
          },
          parameters.kinds[s]);
    }
  }
  return true;
}

// Over numbers themselves everything is inlined, and compiled for several processors.
BORELLI_INLINED_FOR_PROCESSOR
void move_numbers(const System& system, const Parameters& parameters, const InertialsOf<double>& inertials,
                  double t, const double* q, const double* v, bool /*for_efforts*/, Kinematics& kinematics,
                  Articulation& articulation) {
  move_all(system, parameters, inertials, t, q, v, true, kinematics, articulation);
}

BORELLI_LANES_FOR_PROCESSOR
void move_numbers(const System& system, const Parameters& parameters, const InertialsOf<Lanes>& inertials,
                  double t, const Lanes* q, const Lanes* v, bool for_efforts, KinematicsOf<Lanes>& kinematics,
                  ArticulationOf<Lanes>& articulation) {
  move_all(system, parameters, inertials, t, q, v, for_efforts, kinematics, articulation);
}

BORELLI_INLINED_FOR_PROCESSOR
bool accelerate_numbers(const System& system, const Parameters& parameters,
                        const InertialsOf<double>& inertials, const Kinematics& kinematics,
                        const EffortSums* efforts, const double* given, Articulation& articulation,
                        LagrangeTerms& terms, double* a, double* drive_efforts) {
  return accelerate_all(system, parameters, inertials, kinematics, efforts, given, articulation, terms, a,
                        drive_efforts);
}

BORELLI_LANES_FOR_PROCESSOR
bool accelerate_numbers(const System& system, const Parameters& parameters,
                        const InertialsOf<Lanes>& inertials, const KinematicsOf<Lanes>& kinematics,
                        const EffortSumsOf<Lanes>* efforts, const Lanes* given,
                        ArticulationOf<Lanes>& articulation, LagrangeTermsOf<Lanes>& terms, Lanes* a,
                        Lanes* drive_efforts) {
  return accelerate_all(system, parameters, inertials, kinematics, efforts, given, articulation, terms, a,
                        drive_efforts);
}

}  // namespace

template <class T>
void move_links(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials, double t,
                const T* q, const T* v, bool for_efforts, KinematicsOf<T>& kinematics,
                ArticulationOf<T>& articulation) {
  if constexpr (std::is_same_v<T, DualNumber>)
    move_all(system, parameters, inertials, t, q, v, for_efforts, kinematics, articulation);
  else
    move_numbers(system, parameters, inertials, t, q, v, for_efforts, kinematics, articulation);
}

template <class T>
bool find_accelerations(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials,
                        const KinematicsOf<T>& kinematics, const EffortSumsOf<T>* efforts, const T* given,
                        ArticulationOf<T>& articulation, LagrangeTermsOf<T>& terms, T* a, T* drive_efforts) {
  if constexpr (std::is_same_v<T, DualNumber>)
    return accelerate_all(system, parameters, inertials, kinematics, efforts, given, articulation, terms, a,
                          drive_efforts);
  else
    return accelerate_numbers(system, parameters, inertials, kinematics, efforts, given, articulation, terms,
                              a, drive_efforts);
}

#define BORELLI_ARTICULATED_OVER(T)                                                                   \
  template struct ArticulationOf<T>;                                                                  \
  template void move_links(const System&, const Parameters&, const InertialsOf<T>&, double, const T*, \
                           const T*, bool, KinematicsOf<T>&, ArticulationOf<T>&);                     \
  template bool find_accelerations(const System&, const Parameters&, const InertialsOf<T>&,           \
                                   const KinematicsOf<T>&, const EffortSumsOf<T>*, const T*,          \
                                   ArticulationOf<T>&, LagrangeTermsOf<T>&, T*, T*);
BORELLI_ARTICULATED_OVER(double)
BORELLI_ARTICULATED_OVER(DualNumber)
BORELLI_ARTICULATED_OVER(Lanes)

}  // namespace borelli
