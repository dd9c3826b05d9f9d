#include "dynamics/equations/twist_bends.hpp"

#include <algorithm>
#include <array>

#include "dynamics/numbers/dual.hpp"

namespace borelli {

namespace {

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

template <class Kind>
BendsOf<double> bends_of(const Kind& kind, const double* q, const double* u, const Pose& X) {
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
  BendsOf<double> out;
  out.sum = value(w_rate, l_rate);
  for (int j = 0; j < nv; ++j) {
    for (int i = 0; i < nv; ++i) out.by[i][j] = change(w[i], l[i], j);
    out.change[j] = change(w_rate, l_rate, j);
  }
  return out;
}

}  // namespace

BendsOf<double> find_bends(const SwitchKind& kind, const double* q, const double* u, const Pose& X) {
  return std::visit(
      [&]<class Kind>(const Kind& k) {
        if constexpr (Bending<Kind>)
          return bends_of(k, q, u, X);
        else
          return BendsOf<double>();
      },
      kind);
}

}  // namespace borelli
