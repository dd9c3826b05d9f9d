#include "dynamics/equations/sliding_friction.hpp"

#include <algorithm>

#include "dynamics/equations/branch_sparse.hpp"
#include "dynamics/equations/equations.hpp"
#include "dynamics/numbers/elimination.hpp"

namespace borelli {

namespace {

void make_room(const System& system, SlidingFriction& f) {
  const auto count = Eigen::Index(system.contacts.size());
  f.sliding.reserve(system.contacts.size());
  f.force = f.speed = f.gain = f.normal = Eigen::VectorXd::Zero(count);
  f.response = Rows::Zero(count, system.nv);
  f.multipliers = Rows::Zero(count, system.rows);
  f.D = Rows::Zero(count, count);
  f.row = Eigen::VectorXd::Zero(system.rows);
}

}  // namespace

void add_sliding_friction(const System& system, const Parameters& parameters, Workspace& w) {
  SlidingFriction& f = w.friction;
  f.sliding.clear();
  const auto friction_of = [&](int i) {
    return surface_of(parameters.constraints[system.contacts[i].constraint].kind).friction;
  };
  for (std::size_t i = 0; i < system.contacts.size(); ++i)
    if (w.rows.modes[i].touch == Touch::sliding && system.contacts[i].tangents && friction_of(int(i)) > 0) {
      if (f.force.size() == 0) make_room(system, f);
      f.sliding.push_back(int(i));
    }
  const int count = int(f.sliding.size());
  for (int k = 0; k < count; ++k) {
    const int i = f.sliding[k];
    w.correction = -friction_of(i) * w.rows.slip.row(i).head(system.nv).transpose();
    solve_transposed(system, w.factor, w.correction.data());
    solve_lower(system, w.factor, w.correction.data());
    f.response.row(k) = w.correction;
    w.wanted.noalias() = -w.rows.L.leftCols(system.nv) * f.response.row(k).transpose();
    w.solver.correct(w.factor, w.wanted, w.correction);
    f.response.row(k) += w.correction;
    w.solver.multipliers(f.row);
    f.multipliers.row(k) = f.row;
  }
  for (int k = 0; k < count; ++k) {
    const int normal = system.contacts[f.sliding[k]].row;
    f.normal[k] = w.multipliers[normal];
    for (int j = 0; j < count; ++j) f.D(k, j) = (k == j) - f.multipliers(j, normal);
    f.gain[f.sliding[k]] = f.multipliers(k, normal);
  }
  eliminate(f.D, f.normal, count);
  for (int k = 0; k < count; ++k) {
    const int i = f.sliding[k], row = system.contacts[i].row;
    w.a += f.normal[k] * f.response.row(k).transpose();
    w.multipliers += f.normal[k] * f.multipliers.row(k).transpose();
    f.force[i] = friction_of(i) * f.normal[k];
    f.speed[i] = w.rows.slip.row(i).dot(w.kinematics.u);
    for (int c = 0; c < 2; ++c) w.multipliers[row + 1 + c] = -f.force[i] * w.rows.slip_along[i][c];
  }
}

}  // namespace borelli
