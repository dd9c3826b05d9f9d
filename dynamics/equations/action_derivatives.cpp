#include "dynamics/equations/action_derivatives.hpp"

#include <algorithm>

namespace borelli {

using Eigen::Vector3d;

namespace {

constexpr int directions = int(std::tuple_size_v<decltype(DualNumber::d)>);

// Numbers of a body's motion, each of three: rotation and shift of its gravity centre (world axes), angular
// velocity, velocity of the gravity centre, and the rates of both, which only constraints read.
constexpr int effort_inputs = 12, constraint_inputs = 18;

/// Derivatives of a body's motion by a coordinate that moves it.
struct MotionChange {
  Eigen::Matrix<double, constraint_inputs, 1> by_q, by_v;
};

/// The motion that begins at a column of `motions`, at `arm` from the tree's reference point.
SpatialMotion<double> motion_at(const InverseDerivatives& inverse, int u, int column, const Vector3d& arm) {
  SpatialMotion<double> out = inverse.motion(u, column);
  out.v += out.w.cross(arm);
  return out;
}

/// From the columns: what turns and shifts with the coordinate, and what changes beyond that. Velocities are
/// relative to the tree's reference velocity, and accelerations to gravity, as the columns are.
MotionChange change_of(const Parameters& parameters, const Kinematics& k, const InverseDerivatives& inverse,
                       int b, int u, bool constraint) {
  const BodyMotion &m = k.bodies[b], &root = k.bodies[inverse.roots[b]];
  const Vector3d arm = m.g - root.X.p, v = m.v - root.origin_v;
  const auto S = motion_at(inverse, u, inverse.twist, arm), psi = motion_at(inverse, u, inverse.psi, arm);
  MotionChange out;
  out.by_q.head<6>() << S.w, S.v;
  out.by_q.segment<6>(6) << S.w.cross(m.w) + psi.w, S.w.cross(v) + psi.v;
  out.by_v.head<6>().setZero();
  out.by_v.segment<6>(6) << S.w, S.v;
  if (!constraint) return out;
  const auto alpha = motion_at(inverse, u, inverse.alpha, arm);
  const auto gamma = motion_at(inverse, u, inverse.gamma, arm);
  const Vector3d vdot = m.vdot - parameters.gravity;
  out.by_q.tail<6>() << S.w.cross(m.wdot) + alpha.w + psi.w.cross(m.w),
      S.w.cross(vdot) + alpha.v + 2 * psi.w.cross(v);
  out.by_v.tail<6>() << gamma.w + S.w.cross(m.w), gamma.v + 2 * S.w.cross(v);
  return out;
}

void set_plain(const Vector3d& from, Eigen::Vector3<DualNumber>& to) {
  for (int i = 0; i < 3; ++i) to[i] = DualNumber(from[i]);
}

}  // namespace

ActionDerivatives::ActionDerivatives(const System& system)
    : system_(system), kinematics_(system, Equations::recursive), sums_(system) {
  Eigen::Index inputs = 0, outputs = 0, moving = 0;
  const auto add = [&](const Action& action, bool constraint, std::vector<Layout>& to) {
    const Layout& one = to.emplace_back(lay_out(action, constraint));
    inputs = std::max<Eigen::Index>(inputs, one.inputs);
    outputs = std::max<Eigen::Index>(outputs, one.outputs);
    moving = std::max<Eigen::Index>(moving, Eigen::Index(one.moving.size()));
  };
  for (const Action& action : system.efforts) add(action, false, efforts_);
  for (const Action& action : system.constraints) add(action, true, constraints_);
  if (system.rows > 0) rows_.emplace(system);
  values_.setZero(outputs);
  local_.setZero(outputs, inputs);
  change_q_.setZero(outputs, moving);
  change_v_ = change_q_;
}

/// The place of a coordinate among those that move an action, added if it is new.
int ActionDerivatives::place_of(int u, Layout& layout) const {
  const auto found = std::ranges::find(layout.moving, u);
  const int place = int(found - layout.moving.begin());
  if (found == layout.moving.end()) layout.moving.push_back(u);
  return place;
}

auto ActionDerivatives::lay_out(const Action& action, bool constraint) const -> Layout {
  Layout out;
  out.constraint = constraint;
  for (int s = 0; s < action.site_count; ++s) {
    const int b = system_.sites[action.first_site + s].body;
    if (b <= 0 || std::ranges::find(out.read, b) != out.read.end()) continue;
    out.read.push_back(b);
    Layout::MovedBody moved{.body = b, .input = out.inputs, .output = out.outputs, .moves = {}};
    const Body& body = system_.bodies[b];
    const int* support = system_.branches().support.data() + body.first_support;
    for (int i = 0; i < body.support_count; ++i)
      if (support[i] < system_.nv) moved.moves.emplace_back(support[i], place_of(support[i], out));
    if (moved.moves.empty()) continue;
    out.inputs += constraint ? constraint_inputs : effort_inputs;
    out.outputs += 6;
    out.bodies.push_back(std::move(moved));
  }
  for (int i = 0; i < action.coordinate_count; ++i) {
    const CoordinateSite& site = system_.coordinate_sites[action.first_coordinate + i];
    const auto same = [&](const Layout::OwnCoordinate& other) { return other.u == site.u; };
    if (site.u < 0 || std::ranges::any_of(out.coordinates, same)) continue;
    const auto step = std::ranges::find(system_.steps, site.u, &SwitchStep::u);
    Layout::OwnCoordinate own{.q = site.q, .u = site.u, .nq = step->nq, .nv = step->nv};
    if (step->drive < 0) {
      own.input = out.inputs;
      own.output = out.outputs;
      own.place = place_of(site.u, out);
      for (int k = 1; k < own.nv; ++k) place_of(site.u + k, out);
      out.inputs += 2 * own.nv;
      out.outputs += own.nv;
    }
    out.coordinates.push_back(own);
  }
  if (constraint) out.outputs += action.row_count;
  return out;
}

/// Sets what the action reads to plain values, and clears what it adds to.
void ActionDerivatives::load(const Action& action, const Layout& layout, const Kinematics& k) {
  kinematics_.t = k.t;
  for (const int b : layout.read) {
    const BodyMotion& from = k.bodies[b];
    BodyMotionOf<DualNumber>& to = kinematics_.bodies[b];
    for (int i = 0; i < 9; ++i) to.X.R.data()[i] = DualNumber(from.X.R.data()[i]);
    set_plain(from.X.p, to.X.p);
    set_plain(from.g, to.g);
    set_plain(from.w, to.w);
    set_plain(from.v, to.v);
    sums_.force[b].setZero();
    sums_.moment[b].setZero();
    if (!layout.constraint) continue;
    set_plain(from.wdot, to.wdot);
    set_plain(from.vdot, to.vdot);
  }
  for (const Layout::OwnCoordinate& own : layout.coordinates) {
    for (int i = 0; i < own.nq; ++i) kinematics_.q[own.q + i] = DualNumber(k.q[own.q + i]);
    for (int i = own.u; i < own.u + own.nv; ++i) {
      kinematics_.u[i] = DualNumber(k.u[i]);
      kinematics_.acceleration[i] = DualNumber(k.acceleration[i]);
      sums_.coordinate[i] = DualNumber(0);
    }
  }
  sums_.potential = sums_.power = DualNumber(0);
  sums_.group_potential[action.group] = sums_.group_power[action.group] = DualNumber(0);
  if (layout.constraint) rows_->E.segment(action.first_row, action.row_count).setZero();
}

/// Makes an input the given direction of the dual numbers.
void ActionDerivatives::seed(const Layout& layout, int input, int direction) {
  for (const Layout::MovedBody& moved : layout.bodies) {
    const int i = input - moved.input;
    if (i < 0 || i >= (layout.constraint ? constraint_inputs : effort_inputs)) continue;
    BodyMotionOf<DualNumber>& m = kinematics_.bodies[moved.body];
    const Vector3d unit = Vector3d::Unit(i % 3);
    if (i < 3) {
      for (int c = 0; c < 4; ++c) {
        Vector3d arm;
        for (int r = 0; r < 3; ++r) arm[r] = c < 3 ? m.X.R(r, c).value : m.X.p[r].value - m.g[r].value;
        const Vector3d rate = unit.cross(arm);
        for (int r = 0; r < 3; ++r) (c < 3 ? m.X.R(r, c) : m.X.p[r]).d[direction] = rate[r];
      }
      return;
    }
    if (i < 6) m.X.p[i % 3].d[direction] = 1;
    Eigen::Vector3<DualNumber>* const numbers[] = {&m.g, &m.w, &m.v, &m.wdot, &m.vdot};
    (*numbers[i / 3 - 1])[i % 3].d[direction] = 1;
    return;
  }
  for (const Layout::OwnCoordinate& own : layout.coordinates) {
    const int i = input - own.input;
    if (own.input < 0 || i < 0 || i >= 2 * own.nv) continue;
    if (i >= own.nv) {
      kinematics_.u[own.u + i - own.nv].d[direction] = 1;
    } else if (own.nq == 1) {
      kinematics_.q[own.q].d[direction] = 1;
    } else {
      Quaternion turn = Quaternion::Zero(), q;  // d exp(x) / dx_i at x = 0
      turn[1 + i] = 0.5;
      for (int n = 0; n < 4; ++n) q[n] = kinematics_.q[own.q + n].value;
      const Quaternion rate = product(q, turn);
      for (int n = 0; n < 4; ++n) kinematics_.q[own.q + n].d[direction] = rate[n];
    }
    return;
  }
}

/// Reads the outputs and their derivatives by the inputs from `first` on.
void ActionDerivatives::keep(const Action& action, const Layout& layout, int first, int count) {
  const auto keep_one = [&](int output, const DualNumber& x) {
    values_[output] = x.value;
    for (int i = 0; i < count; ++i) local_(output, first + i) = x.d[i];
  };
  for (const Layout::MovedBody& moved : layout.bodies)
    for (int i = 0; i < 3; ++i) {
      keep_one(moved.output + i, sums_.moment[moved.body][i]);
      keep_one(moved.output + 3 + i, sums_.force[moved.body][i]);
    }
  for (const Layout::OwnCoordinate& own : layout.coordinates)
    for (int i = 0; i < own.nv && own.input >= 0; ++i) keep_one(own.output + i, sums_.coordinate[own.u + i]);
  if (!layout.constraint) return;
  for (int r = 0; r < action.row_count; ++r)
    keep_one(layout.outputs - action.row_count + r, rows_->E[action.first_row + r]);
}

/// Derivatives of the outputs by the inputs, as many at a time as a dual number carries.
template <class Apply>
void ActionDerivatives::differentiate(const Action& action, const Layout& layout, const Kinematics& k,
                                      Apply&& apply) {
  for (int first = 0; first < layout.inputs; first += directions) {
    const int count = std::min(directions, layout.inputs - first);
    load(action, layout, k);
    for (int i = 0; i < count; ++i) seed(layout, first + i, i);
    apply();
    keep(action, layout, first, count);
  }
}

/// Derivatives of the outputs by the coordinates that move the action; of a wrench as seen from its body,
/// since find_inverse_derivatives turns and shifts it with the body.
void ActionDerivatives::chain(const Layout& layout, const Parameters& parameters, const Kinematics& k,
                              const InverseDerivatives& inverse) {
  const int outputs = layout.outputs, moving = int(layout.moving.size());
  auto by_q = change_q_.topLeftCorner(outputs, moving), by_v = change_v_.topLeftCorner(outputs, moving);
  by_q.setZero();
  by_v.setZero();
  for (const Layout::MovedBody& moved : layout.bodies)
    for (const auto& [u, place] : moved.moves) {
      const MotionChange change = change_of(parameters, k, inverse, moved.body, u, layout.constraint);
      const int count = layout.constraint ? constraint_inputs : effort_inputs;
      const auto local = local_.block(0, moved.input, outputs, count);
      by_q.col(place).noalias() += local.lazyProduct(change.by_q.head(count));
      by_v.col(place).noalias() += local.lazyProduct(change.by_v.head(count));
      const Vector3d moment = values_.segment<3>(moved.output), force = values_.segment<3>(moved.output + 3);
      const Vector3d turn = change.by_q.head<3>();
      by_q.col(place).segment<3>(moved.output) -= turn.cross(moment);
      by_q.col(place).segment<3>(moved.output + 3) -= turn.cross(force);
    }
  for (const Layout::OwnCoordinate& own : layout.coordinates)
    for (int i = 0; i < own.nv && own.input >= 0; ++i) {
      by_q.col(own.place + i) += local_.col(own.input + i).head(outputs);
      by_v.col(own.place + i) += local_.col(own.input + own.nv + i).head(outputs);
    }
}

/// Subtracts the generalised forces of the outputs' derivatives.
void ActionDerivatives::subtract(const Layout& layout, const Kinematics& k,
                                 InverseDerivatives& inverse) const {
  const int moving = int(layout.moving.size());
  auto by_q = inverse.by_state.leftCols(system_.nv),
       by_v = inverse.by_state.middleCols(inverse.half, system_.nv);
  for (const Layout::MovedBody& moved : layout.bodies) {
    const BodyMotion &m = k.bodies[moved.body], &root = k.bodies[inverse.roots[moved.body]];
    for (const auto& [u, place] : moved.moves) {
      const auto S = motion_at(inverse, u, inverse.twist, m.g - root.X.p);
      Eigen::Matrix<double, 6, 1> twist;
      twist << S.w, S.v;
      for (int j = 0; j < moving; ++j) {
        by_q(u, layout.moving[j]) -= twist.dot(change_q_.col(j).segment<6>(moved.output));
        by_v(u, layout.moving[j]) -= twist.dot(change_v_.col(j).segment<6>(moved.output));
      }
    }
  }
  for (const Layout::OwnCoordinate& own : layout.coordinates)
    for (int i = 0; i < own.nv && own.input >= 0; ++i)
      for (int j = 0; j < moving; ++j) {
        by_q(own.u + i, layout.moving[j]) -= change_q_(own.output + i, j);
        by_v(own.u + i, layout.moving[j]) -= change_v_(own.output + i, j);
      }
}

void ActionDerivatives::add_pattern(RowPattern& pattern) const {
  for (const std::vector<Layout>* layouts : {&efforts_, &constraints_})
    for (const Layout& layout : *layouts)
      for (const int j : layout.moving) {
        for (const Layout::MovedBody& moved : layout.bodies)
          for (const auto& [u, place] : moved.moves) pattern.add(system_, u, j);
        for (const Layout::OwnCoordinate& own : layout.coordinates)
          for (int i = 0; i < own.nv && own.input >= 0; ++i) pattern.add(system_, own.u + i, j);
      }
}

void ActionDerivatives::subtract_efforts(const Parameters& parameters, const Kinematics& k,
                                         InverseDerivatives& inverse) {
  EffortPass<DualNumber> pass(system_, parameters, kinematics_, sums_);
  for (std::size_t e = 0; e < efforts_.size(); ++e) {
    const Action& action = system_.efforts[e];
    pass.turn_to(action);
    differentiate(action, efforts_[e], k, [&] {
      std::visit([&](const auto& effort) { effort.apply(pass); }, parameters.efforts[e].kind);
    });
    chain(efforts_[e], parameters, k, inverse);
    subtract(efforts_[e], k, inverse);
  }
}

void ActionDerivatives::subtract_constraints(const Parameters& parameters, const Kinematics& k,
                                             const Eigen::VectorXd& multipliers, InverseDerivatives& inverse,
                                             Rows& c_by_state) {
  c_by_state.setZero();
  if (!rows_) return;
  rows_->loads = {&multipliers, &sums_};
  ConstraintPass<DualNumber> pass(system_, parameters, kinematics_, *rows_);
  for (std::size_t c = 0; c < constraints_.size(); ++c) {
    const Action& action = system_.constraints[c];
    const Layout& layout = constraints_[c];
    const ConstraintKind& kind = parameters.constraints[c].kind;
    if (std::visit([]<class Kind>(const Kind&) { return Unilateral<Kind>; }, kind)) continue;
    pass.turn_to(action);
    differentiate(action, layout, k, [&] {
      pass.clear();
      std::visit([&](const auto& constraint) { constraint.evaluate(pass); }, kind);
      // The dual kinematics have no twists, so L holds only the coordinates' own entries.
      for (const Layout::OwnCoordinate& own : layout.coordinates)
        for (int i = own.u; i < own.u + own.nv; ++i)
          for (int r = action.first_row; r < action.first_row + action.row_count; ++r)
            sums_.coordinate[i] += multipliers[r] * rows_->L(r, i);
    });
    chain(layout, parameters, k, inverse);
    subtract(layout, k, inverse);
    for (int r = 0; r < action.row_count; ++r)
      for (int j = 0; j < int(layout.moving.size()); ++j) {
        const int output = layout.outputs - action.row_count + r;
        c_by_state(action.first_row + r, layout.moving[j]) = change_q_(output, j);
        c_by_state(action.first_row + r, inverse.half + layout.moving[j]) = change_v_(output, j);
      }
  }
  rows_->loads = {};
}

}  // namespace borelli
