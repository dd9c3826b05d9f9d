// First and second derivatives of a bending switch's unit twists by its coordinates (Bending, switch.hpp), from
// the switch's own formula on dual numbers.
#pragma once

#include "dynamics/equations/inverse_derivatives.hpp"

namespace borelli {

/// Of a switch with up to three coordinates, at its origin; world axes (inverse_derivatives.hpp).
template <class T>
struct BendsOf {
  SpatialMotion<T> by[3][3];   ///< b_ij: the change of S_i by q_j, as seen from the frame behind the switch
  SpatialMotion<T> sum;        ///< sum of b_ij u_i u_j
  SpatialMotion<T> change[3];  ///< its change by q_j, as seen from there
};

/// The spatial cross product of motions.
template <class T>
SpatialMotion<T> spatial_cross(const SpatialMotion<T>& a, const SpatialMotion<T>& b) {
  return {a.w.cross(b.w), a.w.cross(b.v) + a.v.cross(b.w)};
}

/// `X`: the frame before the switch; q, u: the switch's positions and velocities. Only for kinds that bend.
BendsOf<double> find_bends(const SwitchKind& kind, const double* q, const double* u, const Pose& X);

/// The frame before a step of a body, with the step's placement.
template <class T>
PoseOf<T> pose_before(const System& system, const Parameters& parameters, const KinematicsOf<T>& k,
                      const Body& body, int step) {
  PoseOf<T> X = k.bodies[body.parent].X;
  Eigen::Vector3<T> angular[3], linear[3];
  for (int s = body.first_step; s < step; ++s) {
    X = X * parameters.placements[s];
    std::visit([&](const auto& kind) { kind.advance(k.q.data() + system.steps[s].q, X, angular, linear); },
               parameters.kinds[s]);
  }
  return X * parameters.placements[step];
}

inline double lane_value(double x, int) { return x; }
template <int N, int width>
double lane_value(const LanesOf<N, width>& x, int lane) {
  return x[lane];
}
inline void set_lane_value(double& to, int, double x) { to = x; }
template <int N, int width>
void set_lane_value(LanesOf<N, width>& to, int lane, double x) {
  to.set(lane, x);
}

/// The same at the state of a step, each lane by itself. `X`: the frame before the step, with its placement.
template <class T>
BendsOf<T> find_bends(const SwitchKind& kind, const SwitchStep& step, const KinematicsOf<T>& k,
                      const PoseOf<T>& X) {
  BendsOf<T> out;
  constexpr int lanes = [] {
    if constexpr (is_lanes<T>) return T::count;
    return 1;
  }();
  for (int lane = 0; lane < lanes; ++lane) {
    Pose before;
    double q[4], u[3];
    for (int i = 0; i < 9; ++i) before.R.data()[i] = lane_value(X.R.data()[i], lane);
    for (int i = 0; i < 3; ++i) before.p[i] = lane_value(X.p[i], lane);
    for (int i = 0; i < step.nq; ++i) q[i] = lane_value(k.q[step.q + i], lane);
    for (int i = 0; i < step.nv; ++i) u[i] = lane_value(k.u[step.u + i], lane);
    const BendsOf<double> one = find_bends(kind, q, u, before);
    const auto keep = [&](const SpatialMotion<double>& from, SpatialMotion<T>& to) {
      for (int i = 0; i < 3; ++i) {
        set_lane_value(to.w[i], lane, from.w[i]);
        set_lane_value(to.v[i], lane, from.v[i]);
      }
    };
    keep(one.sum, out.sum);
    for (int j = 0; j < step.nv; ++j) {
      for (int i = 0; i < step.nv; ++i) keep(one.by[i][j], out.by[i][j]);
      keep(one.change[j], out.change[j]);
    }
  }
  return out;
}

}  // namespace borelli
