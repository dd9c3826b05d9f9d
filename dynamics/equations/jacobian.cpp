#include "dynamics/equations/jacobian.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "dynamics/equations/evaluate.hpp"

namespace borelli {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Calls visit(column, angular, linear) for every free coordinate that moves body b: the angular velocity of
/// the body and the velocity of its point at p per unit velocity.
template <class Visit>
void for_each_column(const System& system, const Kinematics& k, std::size_t b, const Vector3d& p,
                     Visit&& visit) {
  for (std::size_t at = b; at > 0; at = std::size_t(system.bodies[at].parent)) {
    const Body& body = system.bodies[at];
    for (int s = body.first_step; s < body.first_step + body.step_count; ++s) {
      if (system.steps[s].drive >= 0) continue;
      for (int u = system.steps[s].u; u < system.steps[s].u + system.steps[s].nv; ++u)
        visit(u, k.angular(u), Vector3d(k.linear(u) + k.angular(u).cross(p - k.origin(u))));
    }
  }
}

}  // namespace

CentroidalMomentum centroidal_momentum(const System& system, const Parameters& parameters, Kinematics& k) {
  CentroidalMomentum out;
  out.matrix.setZero(6, system.nv);
  out.bias.setZero();
  const Vector3d centre = momenta(system, parameters, k).centre;
  for (std::size_t b = 1; b < system.bodies.size(); ++b) {
    if (!system.bodies[b].massive) continue;
    const BodyMotion& m = k.bodies[b];
    const double mass = parameters.inertials[b].mass;
    const Vector3d arm = m.g - centre;
    const Matrix3d I = m.X.R * parameters.inertials[b].tensor * m.X.R.transpose();
    for_each_column(system, k, b, m.g, [&](int u, const Vector3d& w, const Vector3d& v) {
      out.matrix.col(u).head<3>() += I * w + mass * arm.cross(v);
      out.matrix.col(u).tail<3>() += mass * v;
    });
    out.bias.head<3>() += I * m.wdot + m.w.cross(I * m.w) + mass * arm.cross(m.vdot);
    out.bias.tail<3>() += mass * m.vdot;
  }
  return out;
}

Result<PointMotion> point_motion(const System& system, const State& state, const SolidPoint& at) {
  const auto found = std::find(system.solids.begin(), system.solids.end(), at.solid);
  if (found == system.solids.end())
    return bad_use(fmt::format("point of '{}'", at.solid), "the scene has no solid of this name");
  if (!at.point.allFinite())
    return bad_use(fmt::format("point of '{}'", at.solid), "its coordinates are not finite numbers");
  if (auto fits = check_state(system, state); !fits) return tl::unexpected(fits.error());
  const auto solid = std::size_t(found - system.solids.begin());
  const auto b = std::size_t(system.solid_bodies[solid]);
  Kinematics k(system, Equations::recursive);
  update_kinematics(system, system.parameters, state.t, state.q.data(), state.v.data(), k);
  const BodyMotion& m = k.bodies[b];
  PointMotion out;
  out.position = m.X * (system.parameters.solid_places[solid] * at.point);
  const Vector3d arm = out.position - m.X.p, w_arm = m.w.cross(arm);
  out.velocity = m.origin_v + w_arm;
  out.angular_velocity = m.w;
  out.bias = m.origin_vdot + m.wdot.cross(arm) + m.w.cross(w_arm);
  out.angular_bias = m.wdot;
  out.jacobian.setZero(3, system.nv);
  out.angular_jacobian.setZero(3, system.nv);
  for_each_column(system, k, b, out.position, [&](int u, const Vector3d& w, const Vector3d& v) {
    out.jacobian.col(u) = v;
    out.angular_jacobian.col(u) = w;
  });
  return out;
}

}  // namespace borelli
