// First and second derivatives of a bending coordinate's unit twist by that coordinate (Bending,
// switch_guided.hpp), from the switch's own formula on dual numbers.
#pragma once

#include "dynamics/equations/inverse_derivatives.hpp"
#include "dynamics/numbers/dual.hpp"

namespace borelli {

/// b and db/dq of inverse_derivatives.hpp, at the coordinate's origin; world axes.
template <class T>
struct BendOf {
  SpatialMotion<T> bend, rate;
};

/// `X`: the frame before the switch.
template <class Kind>
BendOf<double> find_bend(const Kind& kind, double q, const Pose& X) {
  PoseOf<DualNumber> moved{X.R.cast<DualNumber>(), X.p.cast<DualNumber>()};
  DualNumber along(q);
  along.d[0] = 1;
  Eigen::Vector3<DualNumber> angular, linear, angular_bend, linear_bend;
  kind.advance(&along, moved, &angular, &linear, angular_bend, linear_bend);
  BendOf<double> out;
  Eigen::Vector3d l;
  for (int i = 0; i < 3; ++i) {
    l[i] = linear[i].value;
    out.bend.w[i] = angular_bend[i].value;
    out.bend.v[i] = linear_bend[i].value;
    out.rate.w[i] = angular_bend[i].d[0];
    out.rate.v[i] = linear_bend[i].d[0];
  }
  out.rate.v += l.cross(out.bend.w);  // at a point that stays, while the origin moves by l
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

/// The bend of a coordinate, each lane by itself.
template <class T, class Kind>
BendOf<T> find_bends(const Kind& kind, const T& q, const PoseOf<T>& X) {
  BendOf<T> out;
  constexpr int lanes = [] {
    if constexpr (is_lanes<T>) return T::count;
    return 1;
  }();
  for (int lane = 0; lane < lanes; ++lane) {
    Pose one;
    for (int i = 0; i < 9; ++i) one.R.data()[i] = lane_value(X.R.data()[i], lane);
    for (int i = 0; i < 3; ++i) one.p[i] = lane_value(X.p[i], lane);
    const BendOf<double> bend = find_bend(kind, lane_value(q, lane), one);
    for (int i = 0; i < 3; ++i) {
      set_lane_value(out.bend.w[i], lane, bend.bend.w[i]);
      set_lane_value(out.bend.v[i], lane, bend.bend.v[i]);
      set_lane_value(out.rate.w[i], lane, bend.rate.w[i]);
      set_lane_value(out.rate.v[i], lane, bend.rate.v[i]);
    }
  }
  return out;
}

}  // namespace borelli
