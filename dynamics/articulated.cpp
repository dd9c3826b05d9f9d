// Vectors of three numbers are written one by one: half of one in a register of two, read again number by
// number or the other way round, has to wait for memory.
#define EIGEN_UNALIGNED_VECTORIZE 0
#include "dynamics/articulated.hpp"

#include "dynamics/armature.hpp"
#include "dynamics/articulated_step.hpp"
#include "dynamics/dual.hpp"

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
              const T* q, const T* v, KinematicsOf<T>& k, ArticulationOf<T>& articulation,
              LagrangeTermsOf<T>& terms) {
  set_coordinates<T>(system, parameters, t, q, v, nullptr, k);
  terms.kinetic = terms.potential = 0;
  terms.group_kinetic.setZero();
  terms.group_potential.setZero();
  for (std::size_t b = 1; b < system.bodies.size(); ++b) {
    const Body& body = system.bodies[b];
    const int end = body.first_step + body.step_count;
    BodyMotionOf<T>& m = k.bodies[b];
    for (int s = body.first_step; s < end; ++s) {
      const Step& step = system.steps[s];
      LinkOf<T>& link = articulation.links[s];
      const LinkOf<T>* before = link_before(system, body, s, articulation);
      std::visit(
          [&]<class Kind>(const Kind& kind) {
            const bool loose = is_loose<Kind>(parameters, step, s);
            const LinkMotion<T> motion =
                move<Kind, T>(kind, step, parameters.placements[s], loose, before ? &before->motion : nullptr,
                              k, articulation.pivots.data() + step.u, link.turning);
            link.motion = motion;
            if (s < end - 1) {
              link.body = {};
              return;
            }
            m.X = motion.X;
            m.w = motion.w;
            if (body.massive) {
              begin_body<T>(inertials[b], parameters.gravity, body.group, motion, !loose, m, link.body,
                            terms);
              return;
            }
            link.body = {};
            m.g = motion.X.p;
            m.v = motion.v;
          },
          parameters.kinds[s]);
    }
  }
  add_armature_energy(system, parameters, k, terms);
}

template <class T>
bool accelerate_all(const System& system, const Parameters& parameters, const KinematicsOf<T>& k,
                    const EffortSumsOf<T>* efforts, const T* given, ArticulationOf<T>& articulation, T* a,
                    T* drive_efforts) {
  const auto stays = [&]<class Kind>(const Kind&, int s) {
    return !Kind::slides && parameters.placements[s].form == Placement::Form::identity;
  };
  for (int b = int(system.bodies.size()) - 1; b > 0; --b) {
    const Body& body = system.bodies[b];
    if (efforts && body.touched) {
      LinkOf<T>& link = articulation.links[body.first_step + body.step_count - 1];
      const Vector3<T> d = k.bodies[b].g - link.motion.X.p;
      link.body.bias.n -= efforts->moment[b] + d.cross(efforts->force[b]);
      link.body.bias.f -= efforts->force[b];
      link.body.extended = true;
    }
    for (int s = body.first_step + body.step_count - 1; s >= body.first_step; --s) {
      const Step& step = system.steps[s];
      LinkOf<T>& link = articulation.links[s];
      LinkOf<T>* before = link_before(system, body, s, articulation);
      const bool followed = std::visit(
          [&]<class Kind>(const Kind& kind) {
            ArticulatedBody<T>& carried = link.body;
            if (!free_step<Kind, T>(step, parameters.armatures[s], is_loose<Kind>(parameters, step, s),
                                    efforts ? efforts->coordinate.data() + step.u : nullptr,
                                    given && step.drive < 0 ? given + step.u : nullptr,
                                    k.acceleration.data() + step.u, !before,
                                    articulation.pivots.data() + step.u, carried, link))
              return false;
            if (before) pass_on(carried, link.motion.r, stays(kind, s), before->body);
            return true;
          },
          parameters.kinds[s]);
      if (!followed) return false;
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

// Over doubles everything is inlined, and compiled twice: for processors with fused multiply-add, which the
// program finds out as it starts, and for any.
#if defined(__x86_64__) && defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__)
#define BORELLI_INLINED_FOR_PROCESSOR [[gnu::flatten, gnu::target_clones("arch=x86-64-v3", "default")]]
#else
#define BORELLI_INLINED_FOR_PROCESSOR
#endif

BORELLI_INLINED_FOR_PROCESSOR
void move_doubles(const System& system, const Parameters& parameters, const InertialsOf<double>& inertials,
                  double t, const double* q, const double* v, Kinematics& kinematics,
                  Articulation& articulation, LagrangeTerms& terms) {
  move_all(system, parameters, inertials, t, q, v, kinematics, articulation, terms);
}

BORELLI_INLINED_FOR_PROCESSOR
bool accelerate_doubles(const System& system, const Parameters& parameters, const Kinematics& kinematics,
                        const EffortSums* efforts, const double* given, Articulation& articulation, double* a,
                        double* drive_efforts) {
  return accelerate_all(system, parameters, kinematics, efforts, given, articulation, a, drive_efforts);
}

}  // namespace

template <class T>
void move_links(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials, double t,
                const T* q, const T* v, KinematicsOf<T>& kinematics, ArticulationOf<T>& articulation,
                LagrangeTermsOf<T>& terms) {
  if constexpr (std::is_same_v<T, double>)
    move_doubles(system, parameters, inertials, t, q, v, kinematics, articulation, terms);
  else
    move_all(system, parameters, inertials, t, q, v, kinematics, articulation, terms);
}

template <class T>
bool find_accelerations(const System& system, const Parameters& parameters, const KinematicsOf<T>& kinematics,
                        const EffortSumsOf<T>* efforts, const T* given, ArticulationOf<T>& articulation, T* a,
                        T* drive_efforts) {
  if constexpr (std::is_same_v<T, double>)
    return accelerate_doubles(system, parameters, kinematics, efforts, given, articulation, a, drive_efforts);
  else
    return accelerate_all(system, parameters, kinematics, efforts, given, articulation, a, drive_efforts);
}

#define BORELLI_ARTICULATED_OVER(T)                                                                   \
  template struct ArticulationOf<T>;                                                                  \
  template void move_links(const System&, const Parameters&, const InertialsOf<T>&, double, const T*, \
                           const T*, KinematicsOf<T>&, ArticulationOf<T>&, LagrangeTermsOf<T>&);      \
  template bool find_accelerations(const System&, const Parameters&, const KinematicsOf<T>&,          \
                                   const EffortSumsOf<T>*, const T*, ArticulationOf<T>&, T*, T*);
BORELLI_ARTICULATED_OVER(double)
BORELLI_ARTICULATED_OVER(DualNumber)

}  // namespace borelli
