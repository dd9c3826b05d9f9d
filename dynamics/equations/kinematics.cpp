// Vectors of three are stored number by number (see articulated.cpp).
#define EIGEN_UNALIGNED_VECTORIZE 0
#include "dynamics/equations/kinematics.hpp"

#include "dynamics/numbers/dual.hpp"
#include "dynamics/numbers/lanes.hpp"
#include "dynamics/numbers/processor.hpp"
#include "dynamics/numbers/rotation_vector.hpp"

namespace borelli {

using Eigen::Vector3;
using Eigen::Vector3d;

namespace {

template <class T>
void update_drives(const System& system, const Parameters& parameters, KinematicsOf<T>& k) {
  for (std::size_t s = 0; s < system.steps.size(); ++s) {
    const SwitchStep& step = system.steps[s];
    if (step.drive < 0) continue;
    const Drive& drive = parameters.drives[step.drive];
    if (step.nv == 1) {
      const TimeValue f = at(drive.functions[0], k.t);
      k.q[step.q] = f.value;
      k.u[step.u] = f.rate;
      k.acceleration[step.u] = f.acceleration;
      continue;
    }
    Vector3d theta, rate, acceleration;  // a ball: the rotation vector from its initial orientation
    for (int i = 0; i < 3; ++i) {
      const TimeValue f = at(drive.functions[i], k.t);
      theta[i] = f.value;
      rate[i] = f.rate;
      acceleration[i] = f.acceleration;
    }
    const auto [w, wdot] = body_velocity(theta, rate, acceleration);
    k.q.template segment<4>(step.q) = product(drive.initial, exponential(theta)).template cast<T>();
    k.u.template segment<3>(step.u) = w.template cast<T>();
    k.acceleration.template segment<3>(step.u) = wdot.template cast<T>();
  }
}

template <class T>
void place(const Placement& placement, PoseOf<T>& X) {
  switch (placement.form) {
    case Placement::Form::identity:
      return;
    case Placement::Form::shift:
      X.p += X.R * placement.X.p;
      return;
    case Placement::Form::general:
      X = X * placement.X;
  }
}

/// A frame on the chain of switches from a body's parent to the body.
template <class T>
struct ChainFrame {
  PoseOf<T> X;
  Vector3<T> w, wdot, v, vdot;  ///< v: velocity of the origin
};

/// Advances a frame by one switch: its pose and, if `moving`, angular velocity and acceleration; if
/// `carried`, also the velocity and acceleration of its origin. Compiled separately for each kind of switch.
template <bool moving, class Kind, class T>
void advance(const Kind& kind, const SwitchStep& step, const Placement& placement, bool carried,
             bool accelerated, KinematicsOf<T>& k, ChainFrame<T>& to) {
  const Vector3<T> before = to.X.p;
  place(placement, to.X);
  Vector3<T> angular[Kind::nv + 1], linear[Kind::nv + 1];
  Vector3<T> angular_rate, linear_rate;  // as seen from the frame behind the switch
  if constexpr (Bending<Kind> && moving)
    kind.advance(k.q.data() + step.q, k.u.data() + step.u, to.X, angular, linear, angular_rate, linear_rate);
  else
    kind.advance(k.q.data() + step.q, to.X, angular, linear);
  for (int i = 0; i < Kind::nv; ++i)
    for (int c = 0; c < 3; ++c) {
      if (Kind::rotates) k.twists(step.u + i, c) = angular[i][c];  // (otherwise zero since construction)
      if (Kind::slides) k.twists(step.u + i, 3 + c) = linear[i][c];
      k.twists(step.u + i, 6 + c) = to.X.p[c];
    }
  if constexpr (!moving) return;
  const T* const speed = k.u.data() + step.u;
  const T* const acceleration = k.acceleration.data() + step.u;
  const bool rates = accelerated || step.drive >= 0;
  Vector3<T> w = Vector3<T>::Zero();
  for (int i = 0; i < Kind::nv && Kind::rotates; ++i) w += speed[i] * angular[i];
  const Vector3<T> convective = 2 * to.w + w;
  if (carried) {
    if (Kind::slides || placement.form != Placement::Form::identity) {
      const Vector3<T> r = to.X.p - before, wr = to.w.cross(r);
      to.v += wr;
      to.vdot += to.wdot.cross(r) + to.w.cross(wr);
    }
    if (Kind::slides) {
      Vector3<T> v = Vector3<T>::Zero();
      for (int i = 0; i < Kind::nv; ++i) {
        v += speed[i] * linear[i];
        if (rates) to.vdot += acceleration[i] * linear[i];
      }
      to.v += v;
      to.vdot += convective.cross(v);
      if constexpr (Bending<Kind>) to.vdot += linear_rate;
    }
  } else {
    for (int i = 0; i < Kind::nv; ++i) k.convective[step.u + i] = convective;
    if constexpr (Bending<Kind>) k.twist_rates[step.u] = {angular_rate, linear_rate};
  }
  if (!Kind::rotates) return;
  to.wdot += to.w.cross(w);
  to.w += w;
  if (rates)
    for (int i = 0; i < Kind::nv; ++i) to.wdot += acceleration[i] * angular[i];
  if constexpr (Bending<Kind>) to.wdot += angular_rate;
}

/// First derivatives of the gravity centre over the support, its velocity and acceleration.
template <class T, class Inertia>
void differentiate(const System& system, const Body& body, const Inertia& inertial, KinematicsOf<T>& k,
                   BodyMotionOf<T>& m) {
  const int count = body.support_count;
  const int* support = system.branches().support.data() + body.first_support;
  T* block = k.derivatives.data() + m.derivatives;
  m.g = m.X * inertial.centre;
  m.v.setZero();
  m.vdot.setZero();
  for (int i = 0; i < count; ++i) {
    const int u = support[i];
    const Vector3<T> W = k.angular(u);
    const Vector3<T> V = k.linear(u) + W.cross(m.g - k.origin(u));
    for (int c = 0; c < 3; ++c) {
      block[c * count + i] = V[c];
      block[(3 + c) * count + i] = W[c];
    }
    const Vector3<T> Vu = k.u[u] * V;
    m.v += Vu;
    m.vdot += k.convective[u].cross(Vu) + k.acceleration[u] * V;
    if (!k.twist_rates.empty()) [[unlikely]]
      m.vdot += k.twist_rates[u].at(m.g - k.origin(u));
  }
}

/// The gravity centre's velocity and acceleration from those of the frame's origin.
template <class T, class Inertia>
void move_centre(const Inertia& inertial, BodyMotionOf<T>& m) {
  const Vector3<T> arm = m.X.R * inertial.centre, w_arm = m.w.cross(arm);
  m.g = m.X.p + arm;
  m.v = m.origin_v + w_arm;
  m.vdot = m.origin_vdot + m.wdot.cross(arm) + m.w.cross(w_arm);
}

}  // namespace

template <class T>
KinematicsOf<T>::KinematicsOf(const System& system, Equations which)
    : equations(which),
      q(Eigen::VectorX<T>::Zero(system.nq + system.driven_nq)),
      u(Eigen::VectorX<T>::Zero(system.size())),
      acceleration(Eigen::VectorX<T>::Zero(system.size())),
      twists(Eigen::Matrix<T, Eigen::Dynamic, 9>::Zero(system.size() + Quad::count, 9)),
      convective(system.size()),
      bodies(system.bodies.size()) {
  if (equations == Equations::recursive) return;
  for (const SwitchKind& kind : system.parameters.kinds)
    if (std::visit([]<class Kind>(const Kind&) { return Bending<Kind>; }, kind))
      twist_rates.resize(system.size());
  int size = 0;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    bodies[b].derivatives = size;
    if (system.bodies[b].touched) size += 6 * system.bodies[b].support_count;
  }
  derivatives.assign(size, 0);
}

namespace {

template <class T>
void set_all(const System& system, const Parameters& parameters, double t, const T* q, const T* v, const T* a,
             KinematicsOf<T>& k) {
  k.t = t;
  std::copy(q, q + system.nq, k.q.data());
  if (v) std::copy(v, v + system.nv, k.u.data());
  if (a)
    std::copy(a, a + system.nv, k.acceleration.data());
  else if (k.accelerated)
    k.acceleration.head(system.nv).setZero();
  k.accelerated = a != nullptr;
  if (system.driven_nv > 0) update_drives(system, parameters, k);
}

}  // namespace

template <class T>
void set_coordinates(const System& system, const Parameters& parameters, double t, const T* q, const T* v,
                     const T* a, KinematicsOf<T>& k) {
  if constexpr (is_lanes<T>)
    in_registers([]<int>(auto&... each) { set_all(each...); }, system, parameters, t, q, v, a, k);
  else
    set_all(system, parameters, t, q, v, a, k);
}

namespace {

template <bool moving, class T>
void update_all(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials, double t,
                const T* q, const T* v, const T* a, KinematicsOf<T>& k) {
  set_coordinates(system, parameters, t, q, v, a, k);
  const bool carried = k.equations == Equations::recursive;
  k.spins.clear();
  for (std::size_t b = 1; b < system.bodies.size(); ++b) {
    const Body& body = system.bodies[b];
    BodyMotionOf<T>& m = k.bodies[b];
    const BodyMotionOf<T>& parent = k.bodies[body.parent];
    ChainFrame<T> to{parent.X};
    if constexpr (moving) {
      to.w = parent.w;
      to.wdot = parent.wdot;
      to.v = parent.origin_v;
      to.vdot = parent.origin_vdot;
    }
    for (int s = body.first_step; s < body.first_step + body.step_count; ++s)
      std::visit(
          [&]<class Kind>(const Kind& kind) {
            advance<moving, Kind, T>(kind, system.steps[s], parameters.placements[s], carried, a != nullptr,
                                     k, to);
          },
          parameters.kinds[s]);
    m.X = to.X;
    if constexpr (!moving) {
      m.g = m.X * inertials[b].centre;
      continue;
    }
    m.w = to.w;
    m.wdot = to.wdot;
    m.origin_v = to.v;
    m.origin_vdot = to.vdot;
    if (!body.touched) continue;
    if (k.equations == Equations::recursive)
      move_centre(inertials[b], m);
    else
      differentiate(system, body, inertials[b], k, m);
  }
}

/// Only poses if v is null. (With nv = 0 null is a valid array.)
template <class T>
void update_what_is_given(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials,
                          double t, const T* q, const T* v, const T* a, KinematicsOf<T>& k) {
  if (v || system.nv == 0)
    update_all<true>(system, parameters, inertials, t, q, v, a, k);
  else
    update_all<false>(system, parameters, inertials, t, q, v, a, k);
}

BORELLI_INLINED_FOR_PROCESSOR
void update_numbers(const System& system, const Parameters& parameters, const InertialsOf<double>& inertials,
                    double t, const double* q, const double* v, const double* a, Kinematics& k) {
  update_what_is_given(system, parameters, inertials, t, q, v, a, k);
}

}  // namespace

template <class T>
void update_kinematics(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials,
                       double t, const T* q, const T* v, const T* a, KinematicsOf<T>& k) {
  if constexpr (std::is_same_v<T, DualNumber>)
    update_what_is_given(system, parameters, inertials, t, q, v, a, k);
  else if constexpr (is_lanes<T>)
    in_registers([]<int>(auto&... each) { update_what_is_given(each...); }, system, parameters, inertials, t,
                 q, v, a, k);
  else
    update_numbers(system, parameters, inertials, t, q, v, a, k);
}

#define BORELLI_KINEMATICS_OVER(T)                                                                           \
  template struct KinematicsOf<T>;                                                                           \
  template void set_coordinates(const System&, const Parameters&, double, const T*, const T*, const T*,      \
                                KinematicsOf<T>&);                                                           \
  template void update_kinematics(const System&, const Parameters&, const InertialsOf<T>&, double, const T*, \
                                  const T*, const T*, KinematicsOf<T>&);
BORELLI_KINEMATICS_OVER(double)
BORELLI_KINEMATICS_OVER(DualNumber)
BORELLI_KINEMATICS_OVER(Lanes)
template struct KinematicsOf<Quad>;
template void set_coordinates(const System&, const Parameters&, double, const Quad*, const Quad*, const Quad*,
                              KinematicsOf<Quad>&);

}  // namespace borelli
