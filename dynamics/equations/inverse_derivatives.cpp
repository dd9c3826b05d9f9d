// Vectors of three are stored number by number (see articulated.cpp).
#define EIGEN_UNALIGNED_VECTORIZE 0
#include "dynamics/equations/inverse_derivatives.hpp"

#include <span>

#include "dynamics/equations/entries.hpp"
#include "dynamics/numbers/dual.hpp"
#include "dynamics/numbers/processor.hpp"

namespace borelli {

using Eigen::Matrix3;
using Eigen::Vector3;

template <class T>
MovingComposite<T>& MovingComposite<T>::operator+=(const MovingComposite& other) {
  inertia += other.inertia;
  momentum += other.momentum;
  gyration += other.gyration;
  force.n += other.force.n;
  force.f += other.force.f;
  return *this;
}

// The moment of B psi gains r x (2 psi_w x p) = 2 ((r.p) psi_w - (r.psi_w) p).
template <class T>
void MovingComposite<T>::move(const Vector3<T>& r) {
  inertia.move(r);
  const Vector3<T> twice = 2 * momentum;
  const T along = r.dot(twice);
  for (int j = 0; j < 3; ++j) {
    gyration.col(j) -= r[j] * twice;
    gyration(j, j) += along;
  }
  force.n += r.cross(force.f);
}

namespace {

/// The next whole number of the widest registers.
int padded(int count) { return (count + Lanes::count - 1) / Lanes::count * Lanes::count; }

}  // namespace

template <class T>
InverseDerivativesOf<T>::InverseDerivativesOf(const System& system)
    : needed(Eigen::VectorX<T>::Zero(system.nv)),
      by_state(RowsOf<T>::Zero(system.nv, 2 * padded(system.nv))),
      half(padded(system.nv)),
      A(RowsOf<T>::Zero(system.nv, system.nv)),
      columns(system.size()),
      table(Eigen::Matrix<T, Eigen::Dynamic, 24>::Zero(system.size() + Quad::count, 24)),
      composites(system.bodies.size()),
      carries(composites.size(), false),
      roots(composites.size(), 0),
      first_ranges{0} {
  std::vector<std::vector<Range>> chains(system.bodies.size());
  for (std::size_t b = 1; b < system.bodies.size(); ++b) {
    const Body& body = system.bodies[b];
    roots[b] = body.parent == 0 ? int(b) : roots[body.parent];
    std::vector<Range>& chain = chains[b] = chains[body.parent];
    for (int s = body.first_step; s < body.first_step + body.step_count; ++s) {
      if (const SwitchStep& step = system.steps[s]; step.drive < 0) {
        if (chain.empty() || chain.back().first + chain.back().count != step.u) chain.push_back({step.u, 0});
        chain.back().count += step.nv;
      }
      ranges.insert(ranges.end(), chain.begin(), chain.end());
      first_ranges.push_back(int(ranges.size()));
    }
  }
}

namespace {

/// Change of a bending coordinate's unit twist with it (b and db/dq above), at its origin.
template <class T>
struct BendOf {
  SpatialMotion<T> bend, rate;
};

template <class Kind>
BendOf<double> find_bend(const Kind& kind, double q, const Pose& X) {
  PoseOf<DualNumber> moved{X.R.cast<DualNumber>(), X.p.cast<DualNumber>()};
  DualNumber along(q);
  along.d[0] = 1;
  Vector3<DualNumber> angular, linear, angular_bend, linear_bend;
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

template <class T>
PoseOf<T> pose_before(const System& system, const Parameters& parameters, const KinematicsOf<T>& k,
                      const Body& body, int step) {
  PoseOf<T> X = k.bodies[body.parent].X;
  Vector3<T> angular[3], linear[3];
  for (int s = body.first_step; s < step; ++s) {
    X = X * parameters.placements[s];
    std::visit([&](const auto& kind) { kind.advance(k.q.data() + system.steps[s].q, X, angular, linear); },
               parameters.kinds[s]);
  }
  return X * parameters.placements[step];
}

template <class T>
T lane_value(const T& x, int) {
  return x;
}
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

/// The frame before a step, at its tree's reference velocity: w, v of its origin, and their rates, with
/// gravity subtracted.
template <class T>
struct FrameBefore {
  Vector3<T> p, w, v, wdot, vdot;

  void move_to(const Vector3<T>& origin) {
    const Vector3<T> r = origin - p, wr = w.cross(r);
    v += wr;
    vdot += wdot.cross(r) + w.cross(wr);
    p = origin;
  }
};

template <class T>
void keep_motion(const SpatialMotion<T>& motion, const Vector3<T>& arm, int u, int column,
                 InverseDerivativesOf<T>& out) {
  const Vector3<T> v = motion.v + arm.cross(motion.w);  // at the reference point, arm before the origin
  for (int i = 0; i < 3; ++i) {
    out.table(u, column + i) = motion.w[i];
    out.table(u, column + 3 + i) = v[i];
  }
}

/// Columns of a step's coordinates (see the head of the header), and its frame's motion. `arm`: from the
/// tree's reference point to the step's origin.
template <class Kind, class T>
void find_columns(const SwitchStep& step, const KinematicsOf<T>& k, const BendOf<T>& bends,
                  const Vector3<T>& reference, FrameBefore<T>& before, InverseDerivativesOf<T>& out) {
  const Vector3<T> zero = Vector3<T>::Zero();
  before.move_to(k.origin(step.u));
  const Vector3<T> w = before.w, v = before.v, arm = before.p - reference;
  Vector3<T> turn = zero, slide = zero;
  for (int i = 0; i < Kind::nv; ++i) {
    if (Kind::rotates) turn += k.u[step.u + i] * k.angular(step.u + i);
    if (Kind::slides) slide += k.u[step.u + i] * k.linear(step.u + i);
  }
  Vector3<T> wdot = before.wdot + w.cross(turn), vdot = before.vdot + 2 * w.cross(slide) + turn.cross(slide);
  for (int u = step.u; u < step.u + Kind::nv; ++u) {
    typename InverseDerivativesOf<T>::Column& to = out.columns[u];
    to.twist = {zero, zero};
    to.psi = to.alpha = to.gamma = to.twist;
    if constexpr (Kind::rotates) {
      const Vector3<T> s = k.angular(u), ws = w.cross(s);
      to.twist.w = s;
      to.psi = {ws, v.cross(s)};
      to.alpha = {before.wdot.cross(s) + w.cross(ws), before.vdot.cross(s) + 2 * v.cross(ws)};
      wdot += k.acceleration[u] * s;
    }
    if constexpr (Kind::slides) {
      const Vector3<T> l = k.linear(u), wl = w.cross(l);
      to.twist.v = l;
      to.psi.v += wl;
      to.alpha.v += before.wdot.cross(l) + w.cross(wl);
      vdot += k.acceleration[u] * l;
    }
    if constexpr (Bending<Kind>) {
      const T rate = k.u[u], square = rate * rate, acceleration = k.acceleration[u];
      const SpatialMotion<T>&b = bends.bend, &c = bends.rate;
      to.bend = b;
      to.psi.w += rate * b.w;
      to.psi.v += rate * b.v;
      to.alpha.w += 2 * rate * w.cross(b.w) + acceleration * b.w + square * c.w;
      to.alpha.v += 2 * rate * (w.cross(b.v) + v.cross(b.w)) + acceleration * b.v + square * c.v;
      wdot += square * b.w;
      vdot += square * b.v;
    }
    to.gamma = {2 * to.psi.w, 2 * to.psi.v};
    if constexpr (Kind::nv > 1) to.gamma.w += turn.cross(to.twist.w);
    if (step.drive >= 0) continue;
    keep_motion(to.twist, arm, u, out.twist, out);
    keep_motion(to.alpha, arm, u, out.alpha, out);
    keep_motion(to.gamma, arm, u, out.gamma, out);
    keep_motion(to.psi, arm, u, out.psi, out);
  }
  before.w += turn;
  before.v += slide;
  before.wdot = wdot;
  before.vdot = vdot;
}

/// Outward pass.
template <class T>
void find_all_columns(const System& system, const Parameters& parameters, const KinematicsOf<T>& k,
                      InverseDerivativesOf<T>& out) {
  for (std::size_t b = 1; b < system.bodies.size(); ++b) {
    const Body& body = system.bodies[b];
    const BodyMotionOf<T>&parent = k.bodies[body.parent], &root = k.bodies[out.roots[b]];
    FrameBefore<T> before{parent.X.p, parent.w, parent.origin_v - root.origin_v, parent.wdot,
                          parent.origin_vdot - parameters.gravity};
    for (int s = body.first_step; s < body.first_step + body.step_count; ++s) {
      const SwitchStep& step = system.steps[s];
      std::visit(
          [&]<class Kind>(const Kind& kind) {
            BendOf<T> bends;
            if constexpr (Bending<Kind>)
              bends = find_bends(kind, k.q[step.q], pose_before(system, parameters, k, body, s));
            find_columns<Kind, T>(step, k, bends, root.X.p, before, out);
          },
          parameters.kinds[s]);
    }
  }
}

/// One body about its frame's origin; velocities relative to `reference`.
template <class T, class Inertia>
MovingComposite<T> moving_body(const Inertia& inertial, const BodyMotionOf<T>& m,
                               const Eigen::Vector3d& gravity, const Vector3<T>& reference) {
  const Symmetric3<T> J = central_tensor(inertial, m);
  const Vector3<T> d = m.g - m.X.p, w = m.w;
  MovingComposite<T> out;
  out.inertia = rigid_body<T>(inertial.mass, J, m);
  out.momentum = T(inertial.mass) * (m.v - reference);
  const T half = 0.5 * J.trace();
  const Vector3<T> E[3] = {
      {half - J.xx, -J.xy, -J.xz}, {-J.xy, half - J.yy, -J.yz}, {-J.xz, -J.yz, half - J.zz}};
  const Vector3<T> twice = 2 * out.momentum;
  const T along = d.dot(twice);
  for (int j = 0; j < 3; ++j) {
    out.gyration.col(j) = -2 * w.cross(E[j]) - d[j] * twice;
    out.gyration(j, j) += along;
  }
  out.force.f = T(inertial.mass) * (m.vdot - gravity);
  out.force.n = J * m.wdot + w.cross(J * w) + d.cross(out.force.f);
  return out;
}

/// What a coordinate multiplies, at its tree's reference point: rows of dtau/dq, dtau/dv and A by columns
/// before it, and columns of them by rows before it.
template <class T>
struct Factors {
  Wrench<T> row;    ///< I S
  Vector3<T> turn;  ///< B^T S
  Wrench<T> q, v;   ///< S x* f + I alpha + B psi; I gamma + B S
};

/// The wrench that a composite needs for a motion.
template <class T>
Wrench<T> times(const CompositeBody<T>& body, const SpatialMotion<T>& motion) {
  return {body.second * motion.w + body.first.cross(motion.v),
          body.mass * motion.v + motion.w.cross(body.first)};
}

template <class T>
Wrench<T> at_reference(const Wrench<T>& wrench, const Vector3<T>& arm) {
  return {wrench.n + arm.cross(wrench.f), wrench.f};
}

template <class Kind, class T>
Factors<T> find_factors(const typename InverseDerivativesOf<T>::Column& column,
                        const MovingComposite<T>& body, const Vector3<T>& arm) {
  const SpatialMotion<T>& S = column.twist;
  const Vector3<T> twice = 2 * body.momentum;
  const auto add_velocity_part = [&](const Vector3<T>& w, Wrench<T>& to) {
    to.n += body.gyration * w;
    to.f += w.cross(twice);
  };
  Factors<T> out;
  Wrench<T> row = times(body.inertia, S);
  Wrench<T> q = times(body.inertia, column.alpha), v = times(body.inertia, column.gamma);
  add_velocity_part(column.psi.w, q);
  out.turn.setZero();
  if constexpr (Kind::rotates) {
    add_velocity_part(S.w, v);
    q.n += S.w.cross(body.force.n);
    q.f += S.w.cross(body.force.f);
    out.turn = body.gyration.transpose() * S.w;
  }
  if constexpr (Kind::slides) {
    q.n += S.v.cross(body.force.f);
    out.turn += twice.cross(S.v);
  }
  out.row = at_reference(row, arm);
  out.q = at_reference(q, arm);
  out.v = at_reference(v, arm);
  return out;
}

/// Entries of a coordinate with all before it on its chain, and with those of its own switch.
template <class T>
void find_entries(int u, int own, const Factors<T>& by,
                  std::span<const typename InverseDerivativesOf<T>::Range> chain,
                  InverseDerivativesOf<T>& out) {
  using Entries = EntriesOf<T>;
  using Pack = typename Entries::Type;
  const Eigen::Index height = out.table.rows();
  for (const auto& range : chain)
    for (int begin = 0; begin < range.count; begin += Entries::count) {
      // the last pack overlaps the one before
      const int first = range.first + std::max(0, std::min(begin, range.count - Entries::count));
      const int count = std::min(Entries::count, range.count);
      const T* const from = out.table.data() + first;
      const auto number = [&](int c) { return Entries::load(from + c * height); };
      const auto product = [&](const Wrench<T>& wrench, int c) {
        Pack sum = number(c) * Pack(wrench.n[0]);
        sum += number(c + 1) * Pack(wrench.n[1]);
        sum += number(c + 2) * Pack(wrench.n[2]);
        sum += number(c + 3) * Pack(wrench.f[0]);
        sum += number(c + 4) * Pack(wrench.f[1]);
        sum += number(c + 5) * Pack(wrench.f[2]);
        return sum;
      };
      const auto turn = [&](int c) {
        Pack sum = number(c) * Pack(by.turn[0]);
        sum += number(c + 1) * Pack(by.turn[1]);
        sum += number(c + 2) * Pack(by.turn[2]);
        return sum;
      };
      const Pack a = product(by.row, out.twist);
      const Pack q = product(by.row, out.alpha) + turn(out.psi);
      const Pack v = product(by.row, out.gamma) + turn(out.twist);
      const Pack column_q = product(by.q, out.twist), column_v = product(by.v, out.twist);
      const auto store = [&](const Pack& entries, RowsOf<T>& to, int column) {
        T* const row = to.data() + u * to.cols() + column + first;
        if (count == Entries::count)
          Entries::store(entries, row);
        else
          for (int e = 0; e < count; ++e) row[e] = Entries::get(entries, e);
      };
      store(a, out.A, 0);
      store(q, out.by_state, 0);
      store(v, out.by_state, out.half);
      for (int e = 0; e < count && first + e < own; ++e) {
        out.by_state(first + e, u) = Entries::get(column_q, e);
        out.by_state(first + e, out.half + u) = Entries::get(column_v, e);
      }
    }
}

/// Inward pass.
template <class T>
void find_all_entries(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials,
                      const KinematicsOf<T>& k, const EffortSumsOf<T>* efforts,
                      InverseDerivativesOf<T>& out) {
  for (int b = int(system.bodies.size()) - 1; b > 0; --b) {
    const Body& body = system.bodies[b];
    const BodyMotionOf<T>&m = k.bodies[b], &root = k.bodies[out.roots[b]];
    MovingComposite<T> composite;
    if (body.massive) composite = moving_body(inertials[b], m, parameters.gravity, root.origin_v);
    if (efforts && body.touched) {
      composite.force.n -= efforts->moment[b] + (m.g - m.X.p).cross(efforts->force[b]);
      composite.force.f -= efforts->force[b];
    }
    if (out.carries[b]) composite += out.composites[b];
    out.carries[b] = false;
    for (int s = body.first_step + body.step_count - 1; s >= body.first_step; --s) {
      const SwitchStep& step = system.steps[s];
      const Vector3<T> origin = k.origin(step.u), arm = origin - root.X.p;
      const int begin = out.first_ranges[s], end = out.first_ranges[s + 1];
      if (step.drive < 0)
        std::visit(
            [&]<class Kind>(const Kind&) {
              for (int u = step.u; u < step.u + Kind::nv; ++u) {
                const auto& column = out.columns[u];
                find_entries<T>(u, step.u, find_factors<Kind, T>(column, composite, arm),
                                {&out.ranges[begin], std::size_t(end - begin)}, out);
                out.A(u, u) += parameters.armatures[s];
                out.needed[u] = column.twist.w.dot(composite.force.n) +
                                column.twist.v.dot(composite.force.f) +
                                parameters.armatures[s] * k.acceleration[u];
                if (efforts) out.needed[u] -= efforts->coordinate[u];
                if constexpr (Bending<Kind>)
                  out.by_state(u, u) +=
                      column.bend.w.dot(composite.force.n) + column.bend.v.dot(composite.force.f);
              }
            },
            parameters.kinds[s]);
      if (s > body.first_step)
        composite.move(origin - k.origin(system.steps[s - 1].u));
      else if (body.parent != 0)
        composite.move(origin - k.bodies[body.parent].X.p);
    }
    if (body.parent == 0) continue;
    if (out.carries[body.parent])
      out.composites[body.parent] += composite;
    else
      out.composites[body.parent] = composite;
    out.carries[body.parent] = true;
  }
}

template <class T>
void find_inverse_derivatives_of(const System& system, const Parameters& parameters,
                                 const InertialsOf<T>& inertials, const KinematicsOf<T>& k,
                                 const EffortSumsOf<T>* efforts, InverseDerivativesOf<T>& out) {
  find_all_columns(system, parameters, k, out);
  find_all_entries(system, parameters, inertials, k, efforts, out);
}

// For double everything is inlined and compiled for several processors.
BORELLI_INLINED_FOR_PROCESSOR
void find_inverse_derivatives_of_numbers(const System& system, const Parameters& parameters,
                                         const InertialsOf<double>& inertials, const Kinematics& k,
                                         const EffortSums* efforts, InverseDerivatives& out) {
  find_inverse_derivatives_of(system, parameters, inertials, k, efforts, out);
}

}  // namespace

template <class T>
void find_inverse_derivatives(const System& system, const Parameters& parameters,
                              const InertialsOf<T>& inertials, const KinematicsOf<T>& k,
                              const EffortSumsOf<T>* efforts, InverseDerivativesOf<T>& out) {
  if constexpr (is_lanes<T>)
    in_registers([]<int>(auto&... each) { find_inverse_derivatives_of(each...); }, system, parameters,
                 inertials, k, efforts, out);
  else
    find_inverse_derivatives_of_numbers(system, parameters, inertials, k, efforts, out);
}

template struct InverseDerivativesOf<double>;
template void find_inverse_derivatives(const System&, const Parameters&, const InertialsOf<double>&,
                                       const Kinematics&, const EffortSums*, InverseDerivatives&);

}  // namespace borelli
