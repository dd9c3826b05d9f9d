// Vectors of three are stored number by number (see articulated.cpp).
#define EIGEN_UNALIGNED_VECTORIZE 0
#include "dynamics/equations/inverse_dynamics.hpp"

#include "dynamics/equations/articulated_side.hpp"
#include "dynamics/equations/articulated_step.hpp"
#include "dynamics/numbers/lanes.hpp"
#include "dynamics/numbers/processor.hpp"

namespace borelli {

using Eigen::Matrix3;
using Eigen::Vector3;
using namespace articulated;

namespace {

/// Inertial force of a body minus its weight, at the origin of its frame. The moment is summed in the body's
/// axes, in which its tensor is given.
template <class T, class Inertia>
Wrench<T> needed_by_body(const Inertia& inertial, const Eigen::Vector3d& gravity,
                         const LinkMotion<T>& motion) {
  const Matrix3<T>& R = motion.R;
  const Vector3<T> w = motion.w, wdot = motion.wdot;
  const Vector3<T> d = R * inertial.centre;
  const Vector3<T> turn = R.transpose() * w, turn_rate = R.transpose() * wdot;
  const bool principal = has_principal_axes(inertial);
  const Vector3<T> momentum = times(inertial.tensor, principal, turn);
  const Vector3<T> moment = times(inertial.tensor, principal, turn_rate) + turn.cross(momentum);
  Wrench<T> out;
  out.f = T(inertial.mass) * (motion.vdot - gravity + wdot.cross(d) + w.cross(w.cross(d)));
  out.n = R * moment + d.cross(out.f);
  return out;
}

template <class T>
void add(const Wrench<T>& wrench, LinkOf<T>& to) {
  if (to.carries) {
    to.body.bias.n += wrench.n;
    to.body.bias.f += wrench.f;
  } else {
    to.body.bias = wrench;
  }
  to.carries = true;
}

/// Subtracts an applied force through the gravity centre (`arm` from the frame's origin) and a moment.
template <class T>
void spare(const Vector3<T>& arm, const Vector3<T>& force, const Vector3<T>& moment, Wrench<T>& wrench) {
  wrench.n -= moment + arm.cross(force);
  wrench.f -= force;
}

/// Projects a wrench at the step's frame onto the step's coordinates.
template <class Kind, class T>
void find_powers(const LinkMotion<T>& motion, const PivotOf<T>* pivots, const Wrench<T>& wrench, T* powers) {
  if constexpr (turns_freely<Kind>) {
    const Vector3<T> turning = motion.R.transpose() * wrench.n;
    for (int i = 0; i < Kind::nv; ++i) powers[i] = turning[i];
  } else {
    for (int i = 0; i < Kind::nv; ++i) powers[i] = power<Kind>(pivots[i], wrench);
  }
}

template <class T>
void hold_bodies(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials,
                 const KinematicsOf<T>& k, const EffortSumsOf<T>* efforts, ArticulationOf<T>& articulation,
                 T* needed) {
  for (auto at = articulation.alone.rbegin(); at != articulation.alone.rend(); ++at) {
    const int b = *at;
    const Body& body = system.bodies[b];
    LinkOf<T>* frame = articulation.link(b);
    if (!frame) continue;
    Wrench<T> own;
    if (body.massive) own = needed_by_body<T>(inertials[b], parameters.gravity, frame->motion);
    if (efforts && body.touched)
      spare<T>(k.bodies[b].g - k.bodies[b].X.p, efforts->force[b], efforts->moment[b], own);
    add(own, *frame);
    for (int s = body.first_step + body.step_count - 1; s >= body.first_step; --s) {
      const SwitchStep& step = system.steps[s];
      const LinkOf<T>& link = articulation.links[s];
      Wrench<T> carried = link.body.bias;
      LinkOf<T>* before = s > body.first_step ? &articulation.links[s - 1] : articulation.link(body.parent);
      std::visit(
          [&]<class Kind>(const Kind&) {
            if (step.drive < 0) {
              T* const to = needed + step.u;
              find_powers<Kind>(link.motion, articulation.pivots.data() + step.u, carried, to);
              for (int i = 0; i < Kind::nv; ++i) {
                to[i] += parameters.armatures[s] * k.acceleration[step.u + i];
                if (efforts) to[i] -= efforts->coordinate[step.u + i];
              }
            }
            if (before && (Kind::slides || parameters.placements[s].form != Placement::Form::identity))
              carried.n += link.motion.r.cross(carried.f);
          },
          parameters.kinds[s]);
      if (before) add(carried, *before);
    }
  }
}

/// Inward pass over the trees: adds their wrenches to the links that carry them.
void hold_side(const System& system, const Parameters& parameters, const Kinematics& k,
               const EffortSums* efforts, Articulation& articulation, SideBySide& side, double* needed) {
  for (int b = int(side.trees.bodies.size()) - 1; b >= 0; --b) {
    const SideBySide::BodyOf& body = side.bodies[b];
    const Each& each = side.trees.bodies[b];
    const int last = side.bodies[b + 1].first_step - 1;
    const LinkOf<Quad>& frame = side.steps[last].link;
    Wrench<Quad> carried;
    if (system.bodies[each[0]].massive)
      carried = needed_by_body<Quad>(body.inertial, parameters.gravity, frame.motion);
    if (frame.carries) {
      carried.n += frame.body.bias.n;
      carried.f += frame.body.bias.f;
    }
    if (efforts && system.bodies[each[0]].touched) {
      Vector3<Quad> force, moment;
      gather(
          [&](int lane) -> auto& { return efforts->force[each[lane]]; }, force);
      gather(
          [&](int lane) -> auto& { return efforts->moment[each[lane]]; }, moment);
      spare<Quad>(body.arm, force, moment, carried);
    }
    for (int s = last; s >= body.first_step; --s) {
      SideBySide::StepOf& step = side.steps[s];
      LinkOf<Quad>* before = before_in(side, step);
      std::visit(
          [&]<class Kind>(const Kind&) {
            Quad powers[Kind::nv + 1];
            find_powers<Kind>(step.link.motion, side.pivots.data() + step.first_pivot, carried, powers);
            for (int lane = 0; lane < Quad::count; ++lane) {
              const double armature = parameters.armatures[step.steps[lane]];
              for (int i = 0; i < Kind::nv; ++i) {
                const int u = step.u[lane] + i;
                needed[u] = powers[i][lane] + armature * k.acceleration[u];
                if (efforts) needed[u] -= efforts->coordinate[u];
              }
            }
          },
          parameters.kinds[step.steps[0]]);
      if (before && !step.stays) carried.n += step.link.motion.r.cross(carried.f);
      if (s > body.first_step || !before) continue;
      if (b > 0) {
        add(carried, *before);
        continue;
      }
      for (int lane = 0; lane < side.trees.count; ++lane) {
        Wrench<double> one;
        lane_of(carried.n, lane, one.n);
        lane_of(carried.f, lane, one.f);
        add(one, carrying_link(system, side, lane, articulation));
      }
    }
  }
}

BORELLI_INLINED_FOR_PROCESSOR
void hold_trees(const System& system, const Parameters& parameters, const Kinematics& k,
                const EffortSums* efforts, Articulation& articulation, double* needed) {
  for (SideBySide& side : articulation.trees)
    hold_side(system, parameters, k, efforts, articulation, side, needed);
}

BORELLI_INLINED_FOR_PROCESSOR
void hold_numbers(const System& system, const Parameters& parameters, const InertialsOf<double>& inertials,
                  const Kinematics& k, const EffortSums* efforts, Articulation& articulation,
                  double* needed) {
  hold_bodies(system, parameters, inertials, k, efforts, articulation, needed);
}

}  // namespace

template <class T>
void inverse_dynamics(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials,
                      double t, const T* q, const T* v, const T* a, KinematicsOf<T>& kinematics,
                      EffortSumsOf<T>& efforts, ArticulationOf<T>& articulation, T* needed) {
  const bool acted = !system.efforts.empty();
  move_links(system, parameters, inertials, t, q, v, a, kinematics, articulation);
  if (acted) {
    find_bodies(system, parameters, inertials, kinematics, articulation);
    scan_efforts(system, parameters, kinematics, efforts);
  }
  const EffortSumsOf<T>* const acting = acted ? &efforts : nullptr;
  if constexpr (std::is_same_v<T, double>)
    if (!articulation.trees.empty()) hold_trees(system, parameters, kinematics, acting, articulation, needed);
  if constexpr (is_lanes<T>)
    in_registers([]<int>(auto&... each) { hold_bodies(each...); }, system, parameters, inertials, kinematics,
                 acting, articulation, needed);
  else
    hold_numbers(system, parameters, inertials, kinematics, acting, articulation, needed);
}

#define BORELLI_INVERSE_OVER(T)                                                                              \
  template void inverse_dynamics(const System&, const Parameters&, const InertialsOf<T>&, double, const T*,  \
                                 const T*, const T*, KinematicsOf<T>&, EffortSumsOf<T>&, ArticulationOf<T>&, \
                                 T*);
BORELLI_INVERSE_OVER(double)
BORELLI_INVERSE_OVER(Lanes)

}  // namespace borelli
