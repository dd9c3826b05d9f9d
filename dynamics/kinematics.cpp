#include "dynamics/kinematics.hpp"

#include "dynamics/rotation_vector.hpp"

namespace borelli {

using Eigen::Vector3d;

namespace {

void update_drives(const System& system, const Parameters& parameters, Kinematics& k) {
  for (std::size_t s = 0; s < system.steps.size(); ++s) {
    const Step& step = system.steps[s];
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
    k.q.segment<4>(step.q) = product(drive.initial, exponential(theta));
    k.u.segment<3>(step.u) = w;
    k.acceleration.segment<3>(step.u) = wdot;
  }
}

void place(const Placement& placement, Pose& X) {
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

/// Moves a body's frame on by one switch, and with it its angular velocity and the rate of that.
void advance(const Step& step, const Placement& placement, const SwitchKind& kind, Kinematics& k,
             BodyMotion& body) {
  place(placement, body.X);
  const int u = step.u;
  std::visit(
      [&](const auto& motion) { motion.advance(k.q.data() + step.q, body.X, &k.angular[u], &k.linear[u]); },
      kind);
  Vector3d w = Vector3d::Zero();
  if (step.rotates)
    for (int i = u; i < u + step.nv; ++i) w += k.u[i] * k.angular[i];
  const Vector3d convective = 2 * body.w + w;
  for (int i = u; i < u + step.nv; ++i) {
    k.origin[i] = body.X.p;
    k.convective[i] = convective;
  }
  if (!step.rotates) return;
  body.wdot += body.w.cross(w);
  body.w += w;
  if (step.drive >= 0)
    for (int i = u; i < u + step.nv; ++i) body.wdot += k.acceleration[i] * k.angular[i];
}

/// First derivatives of the gravity centre over the support, its velocity and acceleration.
void differentiate(const System& system, const Body& body, const Inertial& inertial, Kinematics& k,
                   BodyMotion& m) {
  const int count = body.support_count;
  const int* support = system.support.data() + body.first_support;
  double* block = k.derivatives.data() + m.derivatives;
  m.g = m.X * inertial.centre;
  m.v.setZero();
  m.vdot.setZero();
  for (int i = 0; i < count; ++i) {
    const int u = support[i];
    const Vector3d& W = k.angular[u];
    const Vector3d V = k.linear[u] + W.cross(m.g - k.origin[u]);
    for (int c = 0; c < 3; ++c) {
      block[c * count + i] = V[c];
      block[(3 + c) * count + i] = W[c];
    }
    const Vector3d Vu = k.u[u] * V;
    m.v += Vu;
    m.vdot += k.convective[u].cross(Vu) + k.acceleration[u] * V;
  }
}

}  // namespace

Kinematics::Kinematics(const System& system)
    : q(Eigen::VectorXd::Zero(system.nq + system.driven_nq)),
      u(Eigen::VectorXd::Zero(system.size())),
      acceleration(Eigen::VectorXd::Zero(system.size())),
      angular(system.size()),
      linear(system.size()),
      origin(system.size()),
      convective(system.size()),
      bodies(system.bodies.size()) {
  int size = 0;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    bodies[b].derivatives = size;
    if (system.bodies[b].touched) size += 6 * system.bodies[b].support_count;
  }
  derivatives.assign(size, 0);
}

void update_kinematics(const System& system, const Parameters& parameters, double t, const double* q,
                       const double* v, Kinematics& k) {
  k.t = t;
  std::copy(q, q + system.nq, k.q.data());
  std::copy(v, v + system.nv, k.u.data());
  if (system.driven_nv > 0) update_drives(system, parameters, k);
  for (std::size_t b = 1; b < system.bodies.size(); ++b) {
    const Body& body = system.bodies[b];
    BodyMotion& m = k.bodies[b];
    const BodyMotion& parent = k.bodies[body.parent];
    m.X = parent.X;
    m.w = parent.w;
    m.wdot = parent.wdot;
    for (int s = body.first_step; s < body.first_step + body.step_count; ++s)
      advance(system.steps[s], parameters.placements[s], parameters.kinds[s], k, m);
    if (body.touched) differentiate(system, body, parameters.inertials[b], k, m);
  }
}

SecondDerivative second_derivative(const System& system, const Kinematics& kinematics, int k, int i, int j) {
  const Body& body = system.bodies[k];
  const int* support = system.support.data() + body.first_support;
  const int a = support[i], b = support[j];
  const auto derivative = [&](int c, int n) { return kinematics.row(system, k, c)[n]; };
  const auto V = [&](int n) { return Vector3d(derivative(0, n), derivative(1, n), derivative(2, n)); };
  // the switch of each: one that comes before, or a component of the same ball, carries the other's motion
  // along
  const auto step_of = [&](int u) {
    for (std::size_t s = 0; s < system.steps.size(); ++s)
      if (u >= system.steps[s].u && u < system.steps[s].u + system.steps[s].nv) return int(s);
    return -1;
  };
  const int first = step_of(a), second = step_of(b);
  if (second <= first)
    return {kinematics.angular[b].cross(V(i)), kinematics.angular[b].cross(kinematics.angular[a])};
  return {kinematics.angular[a].cross(V(j)), Vector3d::Zero()};
}

}  // namespace borelli
