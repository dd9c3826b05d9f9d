#include "dynamics/scan.hpp"

namespace borelli {

using Eigen::Vector3d;

Pose SiteReader::frame(int site) const {
  const Site& s = at_site(site);
  const Pose& X_WB = kinematics_.bodies[s.body].X;
  return s.solid < 0 ? X_WB : X_WB * parameters_.solid_poses[s.solid];
}

MovingPoint SiteReader::point(int site, const Vector3d& p_S) const {
  const Site& s = at_site(site);
  const Vector3d p_B = s.solid < 0 ? p_S : parameters_.solid_poses[s.solid] * p_S;
  const Vector3d p_W = kinematics_.bodies[s.body].X * p_B;
  return {p_W, velocity(site, p_W)};
}

Vector3d SiteReader::velocity(int site, const Vector3d& p_W) const {
  const BodyMotion& body = kinematics_.bodies[at_site(site).body];
  return body.v + body.w.cross(p_W - body.g);
}

double SiteReader::position(int coordinate) const {
  const CoordinateSite& c = at_coordinate(coordinate);
  return c.u < 0 ? c.value : kinematics_.q[c.q];
}

double SiteReader::rate(int coordinate) const {
  const CoordinateSite& c = at_coordinate(coordinate);
  return c.u < 0 ? 0 : kinematics_.u[c.u];
}

// ---- efforts ----

EffortSums::EffortSums(const System& system)
    : force(system.bodies.size(), Vector3d::Zero()),
      moment(system.bodies.size(), Vector3d::Zero()),
      coordinate(Eigen::VectorXd::Zero(system.size())),
      group_potential(Eigen::VectorXd::Zero(system.groups)),
      group_power(group_potential) {}

void EffortScan::force(int site, const Vector3d& p_W, const Vector3d& f) {
  const int body = at_site(site).body;
  sums_.force[body] += f;
  sums_.moment[body] += (p_W - kinematics_.bodies[body].g).cross(f);
}

void EffortScan::torque(int site, const Vector3d& m) { sums_.moment[at_site(site).body] += m; }

void EffortScan::coordinate(int i, double effort) {
  if (const CoordinateSite& c = at_coordinate(i); c.u >= 0) sums_.coordinate[c.u] += effort;
}

void scan_efforts(const System& system, const Parameters& parameters, const Kinematics& kinematics,
                  EffortSums& sums) {
  for (Vector3d& f : sums.force) f.setZero();
  for (Vector3d& m : sums.moment) m.setZero();
  sums.coordinate.setZero();
  sums.potential = sums.power = 0;
  sums.group_potential.setZero();
  sums.group_power.setZero();
  EffortScan scan(system, parameters, kinematics, sums);
  for (std::size_t i = 0; i < system.efforts.size(); ++i) {
    scan.turn_to(system.efforts[i]);
    std::visit([&](const auto& effort) { effort.apply(scan); }, parameters.efforts[i].kind);
  }
}

// ---- constraints ----

ConstraintRows::ConstraintRows(const System& system)
    : L(Rows::Zero(system.rows, system.size())),
      E(Eigen::VectorXd::Zero(system.rows)),
      h(E),
      rate(E),
      partial_rate(E),
      functions(system.constraints.size()) {
  for (std::size_t i = 0; i < functions.size(); ++i) {
    const auto* f = std::get_if<FunctionConstraint>(&system.parameters.constraints[i].kind);
    if (!f) continue;
    const auto n = Eigen::Index(f->coordinates.size() + 3 * f->points.size());
    functions[i].x = functions[i].rate = Eigen::VectorXd::Zero(n);
    functions[i].derivatives.gradient = functions[i].derivatives.gradient_rate = Eigen::VectorXd::Zero(n);
    functions[i].derivatives.hessian = Eigen::MatrixXd::Zero(n, n);
  }
}

void ConstraintScan::along(int r, int site, const Vector3d& p_W, const Vector3d& f) {
  const BodyMotion& body = kinematics_.bodies[at_site(site).body];
  const Vector3d arm = p_W - body.g;
  rows_.E[action_->first_row + r] +=
      f.dot(body.vdot + body.wdot.cross(arm) + body.w.cross(body.w.cross(arm)));
  const Body& structure = system_.bodies[at_site(site).body];
  const int* support = system_.support.data() + structure.first_support;
  const Vector3d m = arm.cross(f);
  const double* derivative = kinematics_.derivatives.data() + body.derivatives;
  double* row = rows_.L.row(action_->first_row + r).data();
  for (int i = 0, n = structure.support_count; i < n; ++i)
    row[support[i]] += f[0] * derivative[i] + f[1] * derivative[n + i] + f[2] * derivative[2 * n + i] +
                       m[0] * derivative[3 * n + i] + m[1] * derivative[4 * n + i] +
                       m[2] * derivative[5 * n + i];
}

void ConstraintScan::about(int r, int site, const Vector3d& m) {
  const BodyMotion& body = kinematics_.bodies[at_site(site).body];
  rows_.E[action_->first_row + r] += m.dot(body.wdot);
  const Body& structure = system_.bodies[at_site(site).body];
  const int* support = system_.support.data() + structure.first_support;
  double* row = rows_.L.row(action_->first_row + r).data();
  for (int i = 0; i < structure.support_count; ++i) row[support[i]] += m.dot(kinematics_.angular[support[i]]);
}

void ConstraintScan::coordinate(int r, int i, double c) {
  const CoordinateSite& site = at_coordinate(i);
  if (site.u < 0) return;
  rows_.L(action_->first_row + r, site.u) += c;
  rows_.E[action_->first_row + r] += c * kinematics_.acceleration[site.u];
}

void ConstraintScan::residual(int r, double h, double partial_rate, double bias) {
  const int row = action_->first_row + r;
  rows_.h[row] = h;
  rows_.partial_rate[row] = partial_rate;
  rows_.E[row] += bias;
}

void scan_constraints(const System& system, const Parameters& parameters, const Kinematics& kinematics,
                      ConstraintRows& rows) {
  rows.L.setZero();
  rows.E.setZero();
  rows.degenerate = -1;
  ConstraintScan scan(system, parameters, kinematics, rows);
  for (std::size_t i = 0; i < system.constraints.size(); ++i) {
    scan.turn_to(system.constraints[i]);
    std::visit([&](const auto& constraint) { constraint.evaluate(scan); }, parameters.constraints[i].kind);
  }
  rows.rate.noalias() = rows.L * kinematics.u;
  rows.rate += rows.partial_rate;
}

}  // namespace borelli
