// First and second derivatives of a bending switch's unit twists by its coordinates (Bending, switch.hpp), from
// the switch's own formula on dual numbers.
#pragma once

#include <algorithm>
#include <array>

#include "dynamics/equations/inverse_derivatives.hpp"
#include "dynamics/numbers/dual.hpp"

namespace borelli {

/// Of a switch with `nv` coordinates, at its origin; world axes (inverse_derivatives.hpp).
template <class T, int nv>
struct BendsOf {
  SpatialMotion<T> by[nv][nv];  ///< b_ij: the change of S_i by q_j, as seen from the frame behind the switch
  SpatialMotion<T> sum;         ///< sum of b_ij u_i u_j
  SpatialMotion<T> change[nv];  ///< its change by q_j, as seen from there
};

/// The spatial cross product of motions.
template <class T>
SpatialMotion<T> spatial_cross(const SpatialMotion<T>& a, const SpatialMotion<T>& b) {
  return {a.w.cross(b.w), a.w.cross(b.v) + a.v.cross(b.w)};
}

/// Position q with unit derivatives: along q, or along rotations about the axes of B.
template <int nq>
std::array<DualNumber, nq> seeded(const double* q) {
  std::array<DualNumber, nq> out;
  std::copy(q, q + nq, out.begin());
  if constexpr (nq == 1) {
    out[0].d[0] = 1;
  } else {
    const Quaternion turn(q[0], q[1], q[2], q[3]);
    for (int j = 0; j < 3; ++j) {
      Quaternion axis = Quaternion::Zero();
      axis[1 + j] = 0.5;
      const Quaternion change = product(turn, axis);
      for (int i = 0; i < 4; ++i) out[std::size_t(i)].d[std::size_t(j)] = change[i];
    }
  }
  return out;
}

/// `X`: the frame before the switch; q, u: the switch's positions and velocities.
template <class Kind>
BendsOf<double, Kind::nv> find_bend(const Kind& kind, const double* q, const double* u, const Pose& X) {
  constexpr int nv = Kind::nv;
  PoseOf<DualNumber> moved{X.R.cast<DualNumber>(), X.p.cast<DualNumber>()};
  const auto positions = seeded<Kind::nq>(q);
  std::array<DualNumber, nv> velocities;
  std::copy(u, u + nv, velocities.begin());
  Eigen::Vector3<DualNumber> w[nv], l[nv], w_rate, l_rate;
  kind.advance(positions.data(), velocities.data(), moved, w, l, w_rate, l_rate);

  using Vector = Eigen::Vector3<DualNumber>;
  const auto value = [](const Vector& at_w, const Vector& at_l) {
    SpatialMotion<double> out;
    for (int c = 0; c < 3; ++c) out.w[c] = at_w[c].value, out.v[c] = at_l[c].value;
    return out;
  };
  SpatialMotion<double> S[nv];
  for (int i = 0; i < nv; ++i) S[i] = value(w[i], l[i]);
  // by q_j, as seen from the frame behind; at a point that stays while the origin moves by S_j
  const auto change = [&](const Vector& of_w, const Vector& of_l, int j) {
    const SpatialMotion<double> now = value(of_w, of_l), turned = spatial_cross(S[j], now);
    SpatialMotion<double> out;
    for (int c = 0; c < 3; ++c) out.w[c] = of_w[c].d[std::size_t(j)], out.v[c] = of_l[c].d[std::size_t(j)];
    out.v += S[j].v.cross(now.w);
    return SpatialMotion<double>{out.w - turned.w, out.v - turned.v};
  };
  BendsOf<double, nv> out;
  out.sum = value(w_rate, l_rate);
  for (int j = 0; j < nv; ++j) {
    for (int i = 0; i < nv; ++i) out.by[i][j] = change(w[i], l[i], j);
    out.change[j] = change(w_rate, l_rate, j);
  }
  return out;
}

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

/// The bends of a switch, each lane by itself.
template <class T, class Kind>
BendsOf<T, Kind::nv> find_bends(const Kind& kind, const T* q, const T* u, const PoseOf<T>& X) {
  constexpr int nv = Kind::nv;
  BendsOf<T, nv> out;
  constexpr int lanes = [] {
    if constexpr (is_lanes<T>) return T::count;
    return 1;
  }();
  for (int lane = 0; lane < lanes; ++lane) {
    Pose before;
    double positions[Kind::nq], velocities[nv];
    for (int i = 0; i < 9; ++i) before.R.data()[i] = lane_value(X.R.data()[i], lane);
    for (int i = 0; i < 3; ++i) before.p[i] = lane_value(X.p[i], lane);
    for (int i = 0; i < Kind::nq; ++i) positions[i] = lane_value(q[i], lane);
    for (int i = 0; i < nv; ++i) velocities[i] = lane_value(u[i], lane);
    const BendsOf<double, nv> one = find_bend(kind, positions, velocities, before);
    const auto keep = [&](const SpatialMotion<double>& from, SpatialMotion<T>& to) {
      for (int i = 0; i < 3; ++i) {
        set_lane_value(to.w[i], lane, from.w[i]);
        set_lane_value(to.v[i], lane, from.v[i]);
      }
    };
    keep(one.sum, out.sum);
    for (int j = 0; j < nv; ++j) {
      for (int i = 0; i < nv; ++i) keep(one.by[i][j], out.by[i][j]);
      keep(one.change[j], out.change[j]);
    }
  }
  return out;
}

}  // namespace borelli
