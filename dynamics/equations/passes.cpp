#include "dynamics/equations/passes.hpp"

#include "dynamics/numbers/dual.hpp"
#include "dynamics/numbers/lanes.hpp"
#include "dynamics/numbers/processor.hpp"

namespace borelli {

using Eigen::Vector3;
using Eigen::Vector3d;

template <class T>
T SiteReader<T>::position(int coordinate) const {
  const CoordinateSite& c = at_coordinate(coordinate);
  return c.u < 0 ? T(c.value) : kinematics_.q[c.q];
}

template <class T>
T SiteReader<T>::rate(int coordinate) const {
  const CoordinateSite& c = at_coordinate(coordinate);
  return c.u < 0 ? T(0) : kinematics_.u[c.u];
}

template <class T>
QuaternionOf<T> SiteReader<T>::turn(int coordinate) const {
  const CoordinateSite& c = at_coordinate(coordinate);
  return c.u < 0 ? QuaternionOf<T>(c.turn.cast<T>())
                 : QuaternionOf<T>(kinematics_.q.template segment<4>(c.q));
}

template <class T>
Vector3<T> SiteReader<T>::turn_rate(int coordinate) const {
  const CoordinateSite& c = at_coordinate(coordinate);
  return c.u < 0 ? Vector3<T>(Vector3<T>::Zero()) : Vector3<T>(kinematics_.u.template segment<3>(c.u));
}

// ---- efforts ----

template <class T>
EffortSumsOf<T>::EffortSumsOf(const System& system)
    : force(system.bodies.size(), Vector3<T>::Zero()),
      moment(system.bodies.size(), Vector3<T>::Zero()),
      coordinate(Eigen::VectorX<T>::Zero(system.size())),
      group_potential(Eigen::VectorX<T>::Zero(system.groups)),
      group_power(group_potential) {}

template <class T>
void EffortPass<T>::force(int site, const Vector3<T>& p_W, const Vector3<T>& f) {
  const int body = this->at_site(site).body;
  sums_.force[body] += f;
  sums_.moment[body] += (p_W - this->kinematics_.bodies[body].g).cross(f);
}

template <class T>
void EffortPass<T>::torque(int site, const Vector3<T>& m) {
  sums_.moment[this->at_site(site).body] += m;
}

template <class T>
void EffortPass<T>::coordinate(int i, const T& effort) {
  if (const CoordinateSite& c = this->at_coordinate(i); c.u >= 0) sums_.coordinate[c.u] += effort;
}

template <class T>
void EffortPass<T>::turning(int i, const Vector3<T>& torque) {
  if (const CoordinateSite& c = this->at_coordinate(i); c.u >= 0)
    sums_.coordinate.template segment<3>(c.u) += torque;
}

namespace {

template <class T>
void scan_all(const System& system, const Parameters& parameters, const KinematicsOf<T>& kinematics,
              EffortSumsOf<T>& sums) {
  for (Vector3<T>& f : sums.force) f.setZero();
  for (Vector3<T>& m : sums.moment) m.setZero();
  sums.coordinate.setZero();
  sums.potential = sums.power = 0;
  sums.group_potential.setZero();
  sums.group_power.setZero();
  EffortPass<T> pass(system, parameters, kinematics, sums);
  for (std::size_t i = 0; i < system.efforts.size(); ++i) {
    pass.turn_to(system.efforts[i]);
    std::visit([&](const auto& effort) { effort.apply(pass); }, parameters.efforts[i].kind);
  }
}

}  // namespace

template <class T>
void scan_efforts(const System& system, const Parameters& parameters, const KinematicsOf<T>& kinematics,
                  EffortSumsOf<T>& sums) {
  if constexpr (is_lanes<T>)
    in_registers([]<int>(auto&... each) { scan_all(each...); }, system, parameters, kinematics, sums);
  else
    scan_all(system, parameters, kinematics, sums);
}

// ---- constraints ----

template <class T>
ConstraintRowsOf<T>::ConstraintRowsOf(const System& system)
    : L(RowsOf<T>::Zero(system.rows, system.size())),
      E(Eigen::VectorX<T>::Zero(system.rows)),
      h(E),
      rate(E),
      partial_rate(E),
      speed(Eigen::VectorXd::Zero(system.rows)),
      modes(system.contacts.size()),
      slip(RowsOf<T>::Zero(Eigen::Index(system.contacts.size()), system.size())),
      slip_along(system.contacts.size(), {T(0), T(0)}),
      functions(system.constraints.size()) {
  for (std::size_t i = 0; i < functions.size(); ++i) {
    const auto* f = std::get_if<FunctionConstraint>(&system.parameters.constraints[i].kind);
    if (!f) continue;
    const auto n = Eigen::Index(f->coordinates.size() + 3 * f->points.size());
    functions[i].x = functions[i].rate = functions[i].gradient = Eigen::VectorX<T>::Zero(n);
    functions[i].at = functions[i].moved = Eigen::VectorXd::Zero(n);
    FunctionDerivatives& sized = functions[i].h;
    sized.gradient = sized.gradient_rate = Eigen::VectorXd::Zero(n);
    sized.hessian = Eigen::MatrixXd::Zero(n, n);
    functions[i].ahead = functions[i].behind = sized;
  }
}

template <class T>
void ConstraintRowsOf<T>::empty() {
  L.setZero();
  slip.setZero();
  for (Eigen::VectorX<T>* each : {&E, &h, &rate, &partial_rate}) each->setZero();
  degenerate = -1;
}

template <class T>
template <int N>
void ConstraintPass<T>::along_each(int r, int site, const Vector3<T>& p_W, const Eigen::Matrix<T, 3, N>& f) {
  const int first = this->action_->first_row + r, at = this->at_site(site).body;
  if (rows_.detail != Detail::rows) {
    if (rows_.detail == Detail::values) return;
    const Vector3<T> v = this->velocity(site, p_W);
    for (int c = 0; c < N; ++c) rows_.rate[first + c] += f.col(c).dot(v);
    return;
  }
  const BodyMotionOf<T>& body = this->kinematics_.bodies[at];
  const Vector3<T> arm = p_W - body.g;
  const Vector3<T> vdot = body.vdot + body.wdot.cross(arm) + body.w.cross(body.w.cross(arm));
  for (int c = 0; c < N; ++c) rows_.E[first + c] += f.col(c).dot(vdot);
  if (rows_.loads.bodies)
    for (int c = 0; c < N; ++c) {
      const Vector3<T> force = (*rows_.loads.multipliers)[first + c] * f.col(c);
      rows_.loads.bodies->force[at] += force;
      rows_.loads.bodies->moment[at] += arm.cross(force);
    }
  const Body& structure = this->system_.bodies[at];
  const int* support = this->system_.branches().support.data() + structure.first_support;
  T* const row = rows_.L.row(first).data();
  for (int i = 0; i < structure.support_count; ++i) {
    const int u = support[i];
    const Vector3<T> w = this->kinematics_.angular(u);
    const Vector3<T> v = this->kinematics_.linear(u) + w.cross(p_W - this->kinematics_.origin(u));
    for (int c = 0; c < N; ++c) row[c * rows_.L.cols() + u] += f.col(c).dot(v);
  }
}

template <class T>
void ConstraintPass<T>::about(int r, int site, const Vector3<T>& m) {
  if (rows_.detail != Detail::rows) {
    if (rows_.detail == Detail::values) return;
    rows_.rate[this->action_->first_row + r] += m.dot(this->angular_velocity(site));
    return;
  }
  const BodyMotionOf<T>& body = this->kinematics_.bodies[this->at_site(site).body];
  rows_.E[this->action_->first_row + r] += m.dot(body.wdot);
  const Body& structure = this->system_.bodies[this->at_site(site).body];
  const int* support = this->system_.branches().support.data() + structure.first_support;
  T* row = rows_.L.row(this->action_->first_row + r).data();
  if (rows_.loads.bodies)
    rows_.loads.bodies->moment[this->at_site(site).body] +=
        (*rows_.loads.multipliers)[this->action_->first_row + r] * m;
  for (int i = 0; i < structure.support_count; ++i)
    row[support[i]] += m.dot(this->kinematics_.angular(support[i]));
}

template <class T>
void ConstraintPass<T>::coordinate(int r, int i, const T& c) {
  const CoordinateSite& site = this->at_coordinate(i);
  if (site.u < 0) return;
  if (rows_.detail != Detail::rows) {
    rows_.rate[this->action_->first_row + r] += c * this->kinematics_.u[site.u];
    return;
  }
  rows_.L(this->action_->first_row + r, site.u) += c;
  rows_.E[this->action_->first_row + r] += c * this->kinematics_.acceleration[site.u];
}

template <class T>
void ConstraintPass<T>::residual(int r, const T& h, const T& partial_rate, const T& bias) {
  const int row = this->action_->first_row + r;
  rows_.h[row] = h;
  rows_.partial_rate[row] = partial_rate;
  if (rows_.detail != Detail::rows)
    rows_.rate[row] += partial_rate;
  else
    rows_.E[row] += bias;
}

/// Range of the columns that along, about and coordinate may write.
template <class T>
auto ConstraintPass<T>::clear() -> Columns {
  const Action& action = *this->action_;
  int first = int(rows_.L.cols()), last = -1;
  const auto hold = [&](int u) {
    first = std::min(first, u);
    last = std::max(last, u);
  };
  for (int s = 0; s < action.site_count; ++s) {
    const int at = this->at_site(s).body;
    if (at < 0) continue;
    const Body& structure = this->system_.bodies[at];
    const int* support = this->system_.branches().support.data() + structure.first_support;
    for (int i = 0; i < structure.support_count; ++i) hold(support[i]);
  }
  for (int i = 0; i < action.coordinate_count; ++i)
    if (const int u = this->at_coordinate(i).u; u >= 0) hold(u);
  for (int r = action.first_row; r < action.first_row + action.row_count; ++r)
    for (int u = first; u <= last; ++u) rows_.L(r, u) = T(0);
  return last < 0 ? Columns{0, 0} : Columns{first, last + 1 - first};
}

/// Rows and rates of the constraint to which the pass is turned.
template <class T>
void find_rows(ConstraintPass<T>& pass, const Action& action, const ConstraintKind& kind,
               const KinematicsOf<T>& kinematics, ConstraintRowsOf<T>& rows) {
  const auto [first, count] = pass.clear();
  std::visit([&](const auto& constraint) { constraint.evaluate(pass); }, kind);
  const auto u = kinematics.u.segment(first, count);
  for (int r = action.first_row; r < action.first_row + action.row_count; ++r)
    rows.rate[r] = rows.L.row(r).segment(first, count).dot(u) + rows.partial_rate[r];
}

/// Clears the rows that contact i does not use in its mode.
template <class T>
void mask_contact(const System& system, int i, ConstraintRowsOf<T>& rows) {
  const Contact& contact = system.contacts[i];
  const ContactMode& mode = rows.modes[i];
  if (mode.touch == Touch::sticking) return;
  if (mode.touch == Touch::sliding && contact.tangents) {
    const T slip[2] = {rows.rate[contact.row + 1], rows.rate[contact.row + 2]};
    T along[2];
    slip_direction(mode, slip, along);
    rows.slip_along[i] = {along[0], along[1]};
    rows.slip.row(i) = along[0] * rows.L.row(contact.row + 1) + along[1] * rows.L.row(contact.row + 2);
  }
  const int kept = mode.touch == Touch::sliding ? 1 : 0;
  if (kept == 0 && rows.degenerate == contact.row) rows.degenerate = -1;  // open: needs no direction
  for (int r = contact.row + kept; r < contact.row + (contact.tangents ? 3 : 1); ++r) {
    rows.L.row(r).setZero();
    rows.E[r] = rows.h[r] = rows.rate[r] = rows.partial_rate[r] = T(0);
  }
}

template <class T>
void scan_constraints(const System& system, const Parameters& parameters, const KinematicsOf<T>& kinematics,
                      ConstraintRowsOf<T>& rows) {
  using Detail = typename ConstraintRowsOf<T>::Detail;
  const bool whole = rows.detail == Detail::rows, some_far = !whole && !rows.far.empty();
  (whole ? rows.E : rows.rate).setZero();
  rows.degenerate = -1;
  ConstraintPass<T> pass(system, parameters, kinematics, rows);
  for (std::size_t i = 0; i < system.constraints.size(); ++i) {
    if (some_far && rows.far[i]) continue;
    const ConstraintKind& kind = parameters.constraints[i].kind;
    pass.turn_to(system.constraints[i]);
    if (whole)
      find_rows(pass, system.constraints[i], kind, kinematics, rows);
    else
      std::visit([&](const auto& constraint) { constraint.evaluate(pass); }, kind);
  }
  if (whole && !rows.every_row)
    for (std::size_t i = 0; i < system.contacts.size(); ++i) mask_contact(system, int(i), rows);
}

void scan_constraint(const System& system, const Parameters& parameters, const Kinematics& kinematics,
                     int constraint, ConstraintRows& rows) {
  const Action& action = system.constraints[constraint];
  rows.E.segment(action.first_row, action.row_count).setZero();
  ConstraintPass<double> pass(system, parameters, kinematics, rows);
  pass.turn_to(action);
  find_rows(pass, action, parameters.constraints[constraint].kind, kinematics, rows);
}

#define BORELLI_EFFORTS_OVER(T)    \
  template class SiteReader<T>;    \
  template class EffortPass<T>;    \
  template struct EffortSumsOf<T>; \
  template void scan_efforts(const System&, const Parameters&, const KinematicsOf<T>&, EffortSumsOf<T>&);
#define BORELLI_SCAN_OVER(T)                                                                               \
  BORELLI_EFFORTS_OVER(T)                                                                                  \
  template class ConstraintPass<T>;                                                                        \
  template void ConstraintPass<T>::along_each(int, int, const Vector3<T>&, const Eigen::Matrix<T, 3, 1>&); \
  template struct ConstraintRowsOf<T>;                                                                     \
  template void scan_constraints(const System&, const Parameters&, const KinematicsOf<T>&,                 \
                                 ConstraintRowsOf<T>&);
BORELLI_SCAN_OVER(double)
BORELLI_SCAN_OVER(DualNumber)
BORELLI_EFFORTS_OVER(Lanes)
BORELLI_EFFORTS_OVER(Quad)

}  // namespace borelli
