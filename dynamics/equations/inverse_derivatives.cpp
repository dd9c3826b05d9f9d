// Vectors of three are stored number by number (see articulated.cpp).
#define EIGEN_UNALIGNED_VECTORIZE 0
#include "dynamics/equations/inverse_derivatives.hpp"

#include <span>

#include "dynamics/equations/entries.hpp"
#include "dynamics/equations/twist_bends.hpp"
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
      bending(system.steps.size(), -1),
      composites(system.bodies.size()),
      carries(composites.size(), false),
      roots(composites.size(), 0),
      first_ranges{0} {
  for (std::size_t s = 0; s < system.steps.size(); ++s)
    if (std::visit([]<class Kind>(const Kind&) { return Bending<Kind>; }, system.parameters.kinds[s])) {
      bending[s] = int(bends.size());
      bends.resize(bends.size() + std::size_t(system.steps[s].nv * system.steps[s].nv));
    }
  const int height = system.size() + Quad::count;
  motions.setZero(height, 24);
  frames.setZero(height, 18);
  carried.setZero(height, 28);
  factors.setZero(height, 21);
  bent.setZero(bends.empty() ? 0 : height, 18);
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

/// Writes vectors into successive columns of a table's row.
template <class Table, class... Vector>
void keep_row(Table& table, int u, int column, const Vector&... vectors) {
  const auto keep = [&](const auto& vector) {
    for (int i = 0; i < 3; ++i) table(u, column++) = vector[i];
  };
  (keep(vectors), ...);
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

/// Keeps what a bending switch adds to psi, alpha and gamma of its coordinates, at its origin. `before`: the
/// frame before it, at its origin.
template <class T>
void keep_bends(const SwitchStep& step, const KinematicsOf<T>& k, const BendsOf<T>& bends,
                const FrameBefore<T>& before, SpatialMotion<T>* rows, InverseDerivativesOf<T>& out) {
  const auto zero = [] { return SpatialMotion<T>{Vector3<T>::Zero(), Vector3<T>::Zero()}; };
  const auto add = [](const SpatialMotion<T>& what, const T& factor, SpatialMotion<T>& to) {
    to.w += factor * what.w;
    to.v += factor * what.v;
  };
  SpatialMotion<T> own = zero();  // v_s
  for (int i = 0; i < step.nv; ++i) add({k.angular(step.u + i), k.linear(step.u + i)}, k.u[step.u + i], own);
  const T one(1), two(2);
  for (int j = 0; j < step.nv; ++j) {
    SpatialMotion<T> p = zero(), rate = zero(), alpha = bends.change[j];
    for (int i = 0; i < step.nv; ++i) {
      rows[i * step.nv + j] = bends.by[i][j];
      add(bends.by[i][j], k.u[step.u + i], p);
      add(bends.by[j][i], k.u[step.u + i], rate);
      add(bends.by[i][j], k.acceleration[step.u + i], alpha);
    }
    add(spatial_cross(SpatialMotion<T>{before.w, before.v}, p), two, alpha);
    add(spatial_cross(own, p), one, alpha);
    // find_factors counts p twice in gamma, and of v_s x S_j only the angular part
    SpatialMotion<T> gamma =
        spatial_cross(own, SpatialMotion<T>{k.angular(step.u + j), k.linear(step.u + j)});
    gamma.w.setZero();
    add(rate, one, gamma);
    add(p, T(-1), gamma);
    keep_row(out.bent, step.u + j, 0, p.w, p.v, alpha.w, alpha.v, gamma.w, gamma.v);
  }
}

/// Advances a frame by a step, and keeps the frame before it, at the step's origin: w, v, their rates, the
/// angular velocity of a ball's own switch, and the arm from the tree's reference point.
template <class T>
void keep_frame(const SwitchStep& step, const KinematicsOf<T>& k, const Vector3<T>& reference,
                FrameBefore<T>& before, InverseDerivativesOf<T>& out) {
  before.move_to(k.origin(step.u));
  Vector3<T> turn = Vector3<T>::Zero(), slide = turn, turn_rate = turn, slide_rate = turn;
  for (int u = step.u; u < step.u + step.nv; ++u) {
    if (step.rotates) {
      turn += k.u[u] * k.angular(u);
      turn_rate += k.acceleration[u] * k.angular(u);
    }
    if (step.slides) {
      slide += k.u[u] * k.linear(u);
      slide_rate += k.acceleration[u] * k.linear(u);
    }
  }
  const Vector3<T> own = step.nv > 1 ? turn : Vector3<T>(Vector3<T>::Zero());
  for (int u = step.u; u < step.u + step.nv; ++u)
    keep_row(out.frames, u, 0, before.w, before.v, before.wdot, before.vdot, own,
             Vector3<T>(before.p - reference));
  before.wdot += turn_rate + before.w.cross(turn);
  before.vdot += slide_rate + 2 * before.w.cross(slide) + turn.cross(slide);
  before.w += turn;
  before.v += slide;
}

/// Outward pass.
template <class T>
void keep_frames(const System& system, const Parameters& parameters, const KinematicsOf<T>& k,
                 InverseDerivativesOf<T>& out) {
  for (std::size_t b = 1; b < system.bodies.size(); ++b) {
    const Body& body = system.bodies[b];
    const BodyMotionOf<T>&parent = k.bodies[body.parent], &root = k.bodies[out.roots[b]];
    FrameBefore<T> before{parent.X.p, parent.w, parent.origin_v - root.origin_v, parent.wdot,
                          parent.origin_vdot - parameters.gravity};
    for (int s = body.first_step; s < body.first_step + body.step_count; ++s) {
      const SwitchStep& step = system.steps[s];
      if (out.bending[s] < 0) {
        keep_frame(step, k, root.X.p, before, out);
        continue;
      }
      const BendsOf<T> bends =
          find_bends(parameters.kinds[s], step, k, pose_before(system, parameters, k, body, s));
      before.move_to(k.origin(step.u));
      keep_bends(step, k, bends, before, &out.bends[std::size_t(out.bending[s])], out);
      keep_frame(step, k, root.X.p, before, out);
      before.wdot += bends.sum.w;
      before.vdot += bends.sum.v;
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

/// Mass (column 0), first and second moments, momentum, gyration, moment and force of what a coordinate
/// carries.
template <class T>
void keep_composite(const MovingComposite<T>& from, int u, InverseDerivativesOf<T>& out) {
  const Symmetric3<T>& I = from.inertia.second;
  out.carried(u, 0) = from.inertia.mass;
  keep_row(out.carried, u, 1, from.inertia.first, Vector3<T>(I.xx, I.xy, I.xz), Vector3<T>(I.yy, I.yz, I.zz),
           from.momentum, from.gyration.col(0), from.gyration.col(1), from.gyration.col(2), from.force.n,
           from.force.f);
}

/// Inward pass.
template <class T>
void keep_composites(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials,
                     const KinematicsOf<T>& k, const EffortSumsOf<T>* efforts, InverseDerivativesOf<T>& out) {
  for (int b = int(system.bodies.size()) - 1; b > 0; --b) {
    const Body& body = system.bodies[b];
    const BodyMotionOf<T>& m = k.bodies[b];
    MovingComposite<T> composite;
    if (body.massive)
      composite = moving_body(inertials[b], m, parameters.gravity, k.bodies[out.roots[b]].origin_v);
    if (efforts && body.touched) {
      composite.force.n -= efforts->moment[b] + (m.g - m.X.p).cross(efforts->force[b]);
      composite.force.f -= efforts->force[b];
    }
    if (out.carries[b]) composite += out.composites[b];
    out.carries[b] = false;
    for (int s = body.first_step + body.step_count - 1; s >= body.first_step; --s) {
      const SwitchStep& step = system.steps[s];
      const Vector3<T> origin = k.origin(step.u);
      for (int u = step.u; u < step.u + step.nv; ++u) keep_composite(composite, u, out);
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

/// Motions of several successive coordinates at the tree's reference point, and the factors of their entries.
/// Factors of a coordinate's rows of A, dtau/dq and dtau/dv: I S (columns 0 to 5), B^T S (6 to 8). Factors of
/// its columns: S x* f + I alpha + B psi (9 to 14), I gamma + B S (15 to 20).
template <class T>
void find_factors(const KinematicsOf<T>& k, int first, InverseDerivativesOf<T>& out) {
  using Entries = EntriesOf<T>;
  using Pack = typename Entries::Type;
  using Vector = Vector3<Pack>;
  const auto vector = [&](const auto& table, int column) {
    return Vector(Entries::load(&table(first, column)), Entries::load(&table(first, column + 1)),
                  Entries::load(&table(first, column + 2)));
  };
  const auto keep = [&](const Vector& from, auto& table, int column) {
    for (int i = 0; i < 3; ++i) Entries::store(from[i], &table(first, column + i));
  };
  const Vector s = vector(k.twists, 0), l = vector(k.twists, 3);
  const Vector w = vector(out.frames, 0), v = vector(out.frames, 3), arm = vector(out.frames, 15);
  const Vector wdot = vector(out.frames, 6), vdot = vector(out.frames, 9);
  const auto keep_motion = [&](const Vector& turn, const Vector& shift, int column) {
    keep(turn, out.motions, column);
    keep(shift + arm.cross(turn), out.motions, column + 3);
  };
  Vector psi_w = w.cross(s), psi_v = w.cross(l);
  Vector alpha_w = wdot.cross(s) + w.cross(psi_w);
  Vector alpha_v = vdot.cross(s) + Pack(2) * v.cross(psi_w) + wdot.cross(l) + w.cross(psi_v);
  psi_v += v.cross(s);
  if (!out.bends.empty()) [[unlikely]] {
    psi_w += vector(out.bent, 0), psi_v += vector(out.bent, 3);
    alpha_w += vector(out.bent, 6), alpha_v += vector(out.bent, 9);
  }
  Vector gamma_w = Pack(2) * psi_w + vector(out.frames, 12).cross(s), gamma_v = Pack(2) * psi_v;
  if (!out.bends.empty()) [[unlikely]]
    gamma_w += vector(out.bent, 12), gamma_v += vector(out.bent, 15);
  keep_motion(s, l, out.twist);
  keep_motion(alpha_w, alpha_v, out.alpha);
  keep_motion(gamma_w, gamma_v, out.gamma);
  keep_motion(psi_w, psi_v, out.psi);

  const auto number = [&](int column) { return Entries::load(&out.carried(first, column)); };
  const Pack mass = number(0);
  const Symmetric3<Pack> second{number(4), number(5), number(6), number(7), number(8), number(9)};
  const Vector moment = vector(out.carried, 1), twice = Pack(2) * vector(out.carried, 10);
  const Vector G[3] = {vector(out.carried, 13), vector(out.carried, 16), vector(out.carried, 19)};
  const Vector n = vector(out.carried, 22), f = vector(out.carried, 25);
  const auto needed = [&](const Vector& turn, const Vector& shift) {
    return Wrench<Pack>{second * turn + moment.cross(shift), mass * shift + turn.cross(moment)};
  };
  const auto keep_wrench = [&](const Wrench<Pack>& wrench, int column) {
    keep(wrench.n + arm.cross(wrench.f), out.factors, column);
    keep(wrench.f, out.factors, column + 3);
  };
  keep_wrench(needed(s, l), 0);
  keep(Vector(G[0].dot(s), G[1].dot(s), G[2].dot(s)) + twice.cross(l), out.factors, 6);
  Wrench<Pack> by_q = needed(alpha_w, alpha_v), by_v = needed(gamma_w, gamma_v);
  by_q.n += G[0] * psi_w[0] + G[1] * psi_w[1] + G[2] * psi_w[2] + s.cross(n) + l.cross(f);
  by_q.f += psi_w.cross(twice) + s.cross(f);
  by_v.n += G[0] * s[0] + G[1] * s[1] + G[2] * s[2];
  by_v.f += s.cross(twice);
  keep_wrench(by_q, 9);
  keep_wrench(by_v, 15);
}

/// Entries of a switch's N coordinates, from u on, with every coordinate on their chain from the root to
/// themselves. (Sums side by side hide the latency of an addition.)
template <int N, class T>
void find_entries(int u, std::span<const typename InverseDerivativesOf<T>::Range> chain,
                  InverseDerivativesOf<T>& out) {
  using Entries = EntriesOf<T>;
  using Pack = typename Entries::Type;
  const Eigen::Index height = out.motions.rows();
  T by[N][21];
  for (int n = 0; n < N; ++n)
    for (int i = 0; i < 21; ++i) by[n][i] = out.factors(u + n, i);
  for (const auto& range : chain)
    for (int begin = 0; begin < range.count; begin += Entries::count) {
      // the last pack overlaps the one before
      const int first = range.first + std::max(0, std::min(begin, range.count - Entries::count));
      const int count = std::min(Entries::count, range.count);
      const T* const from = out.motions.data() + first;
      Pack a[N], q[N], v[N], column_q[N], column_v[N];
      for (int n = 0; n < N; ++n) a[n] = q[n] = v[n] = column_q[n] = column_v[n] = Pack(0);
      for (int i = 0; i < 6; ++i) {
        const Pack twist = Entries::load(from + (out.twist + i) * height),
                   alpha = Entries::load(from + (out.alpha + i) * height),
                   gamma = Entries::load(from + (out.gamma + i) * height);
        for (int n = 0; n < N; ++n) {
          const Pack row = by[n][i];
          a[n] += row * twist;
          q[n] += row * alpha;
          v[n] += row * gamma;
          column_q[n] += Pack(by[n][9 + i]) * twist;
          column_v[n] += Pack(by[n][15 + i]) * twist;
        }
      }
      for (int i = 0; i < 3; ++i) {
        const Pack turn = Entries::load(from + (out.twist + i) * height),
                   psi = Entries::load(from + (out.psi + i) * height);
        for (int n = 0; n < N; ++n) {
          const Pack factor = by[n][6 + i];
          q[n] += factor * psi;
          v[n] += factor * turn;
        }
      }
      for (int n = 0; n < N; ++n) {
        const auto store = [&](const Pack& entries, RowsOf<T>& to, int column) {
          T* const row = to.data() + (u + n) * to.cols() + column + first;
          if (count == Entries::count)
            Entries::store(entries, row);
          else
            for (int e = 0; e < count; ++e) row[e] = Entries::get(entries, e);
        };
        store(a[n], out.A, 0);
        store(q[n], out.by_state, 0);
        store(v[n], out.by_state, out.half);
        for (int e = 0; e < count && first + e < u; ++e) {
          T* const row = out.by_state.data() + (first + e) * out.by_state.cols() + u + n;
          row[0] = Entries::get(column_q[n], e);
          row[out.half] = Entries::get(column_v[n], e);
        }
      }
    }
}

/// The entries of all free coordinates, and the forces that they need.
template <class T>
void find_all_entries(const System& system, const Parameters& parameters, const KinematicsOf<T>& k,
                      const EffortSumsOf<T>* efforts, InverseDerivativesOf<T>& out) {
  for (std::size_t s = 0; s < system.steps.size(); ++s) {
    const SwitchStep& step = system.steps[s];
    if (step.drive >= 0) continue;
    const int begin = out.first_ranges[s], end = out.first_ranges[s + 1];
    const std::span<const typename InverseDerivativesOf<T>::Range> chain(&out.ranges[begin],
                                                                         std::size_t(end - begin));
    if (step.nv == 3)
      find_entries<3, T>(step.u, chain, out);
    else
      find_entries<1, T>(step.u, chain, out);
    for (int u = step.u; u < step.u + step.nv; ++u) {
      const auto vector = [&](int c) {
        return Vector3<T>(out.carried(u, c), out.carried(u, c + 1), out.carried(u, c + 2));
      };
      const Vector3<T> n = vector(22), f = vector(25);
      out.A(u, u) += parameters.armatures[s];
      out.needed[u] = k.angular(u).dot(n) + k.linear(u).dot(f) + parameters.armatures[s] * k.acceleration[u];
      if (efforts) out.needed[u] -= efforts->coordinate[u];
      if (out.bending[s] < 0) continue;
      const SpatialMotion<T>* const row = &out.bends[std::size_t(out.bending[s] + (u - step.u) * step.nv)];
      for (int j = 0; j < step.nv; ++j) out.by_state(u, step.u + j) += row[j].w.dot(n) + row[j].v.dot(f);
    }
  }
}

template <class T>
void find_inverse_derivatives_of(const System& system, const Parameters& parameters,
                                 const InertialsOf<T>& inertials, const KinematicsOf<T>& k,
                                 const EffortSumsOf<T>* efforts, InverseDerivativesOf<T>& out) {
  keep_frames(system, parameters, k, out);
  keep_composites(system, parameters, inertials, k, efforts, out);
  for (int u = 0; u < system.size(); u += EntriesOf<T>::count) find_factors(k, u, out);
  find_all_entries(system, parameters, k, efforts, out);
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

#define BORELLI_INVERSE_DERIVATIVES_OVER(T)                                                       \
  template struct InverseDerivativesOf<T>;                                                        \
  template void find_inverse_derivatives(const System&, const Parameters&, const InertialsOf<T>&, \
                                         const KinematicsOf<T>&, const EffortSumsOf<T>*,          \
                                         InverseDerivativesOf<T>&);
BORELLI_INVERSE_DERIVATIVES_OVER(double)
BORELLI_INVERSE_DERIVATIVES_OVER(Lanes)

}  // namespace borelli
