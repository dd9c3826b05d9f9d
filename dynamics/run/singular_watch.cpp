#include "dynamics/run/singular_watch.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace borelli {

namespace {

constexpr double slowest = 1e-7;  // speeds below count as rest: coordinates' scales per second

/// Message that names the constraints whose rows became dependent, and the rank.
std::string dependent_rows(const System& system, const ConstraintSolver& solver) {
  std::vector<std::string> names;
  for (int k = solver.rank(); k < solver.full_rank(); ++k) {
    const std::string& name = system.constraint_names[system.row_constraint[solver.order()[k]]];
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  return fmt::format("constraint rows, to {}: '{}' depends on others", solver.rank(),
                     fmt::join(names, "', '"));
}

}  // namespace

SingularWatch::SingularWatch(const System& system)
    : system_(system),
      tied_(system.groups, false),
      v_(Eigen::VectorXd::Zero(system.nv)),
      fastest_(Eigen::VectorXd::Zero(system.groups)),
      now_(v_),
      before_(v_) {}

SingularWatch::Reason SingularWatch::observe(const State& state, const Workspace& w,
                                             std::vector<LoggedEvent>& log) {
  if (system_.rows == 0) return {};
  const ConstraintSolver& solver = w.solver;
  if (w.has_rows() && solver.nearness() < nearness_) {
    nearness_ = solver.nearness();
    nearness_time_ = state.t;
  }
  const bool inside = w.has_rows() && solver.rank() < solver.full_rank();
  Reason reason;
  if (inside) {
    if (!inside_) {
      entry_time_ = state.t;
      entry_row_ = solver.order()[solver.rank()];
      std::fill(tied_.begin(), tied_.end(), false);
      if (++passages_ == 1) {
        first_time_ = state.t;
        first_rank_ = solver.rank();
      }
      log.push_back({state.t, "rank_fell", dependent_rows(system_, solver)});
    }
    for (int k = solver.rank(); k < solver.full_rank(); ++k)
      tied_[system_.constraints[system_.row_constraint[solver.order()[k]]].group] = true;
  } else {
    if (inside_) {
      log.push_back({state.t, "rank_regained", fmt::format("constraint rows, to {}", solver.rank())});
      const double turned = turn(state.v, w);
      largest_turn_ = std::max(largest_turn_, turned);
      if (turned > turn_limit)
        reason = fmt::format(
            "the motion changed direction at the singular position at t = {:.6g} s, of row '{}' between {}: "
            "it turned by {:.3g} rad; the equations do not decide which branch follows",
            entry_time_, system_.row_names[entry_row_],
            system_.tied_solids(system_.row_constraint[entry_row_]), turned);
    }
    v_ = state.v;
  }
  inside_ = inside;
  return reason;
}

/// The largest angle between the directions of v_ and v over the affected groups, in the metric of the mass
/// matrix, rad.
double SingularWatch::turn(const Eigen::VectorXd& v, const Workspace& w) {
  double largest = 0;
  const auto A = w.terms.A.topLeftCorner(system_.nv, system_.nv).selfadjointView<Eigen::Lower>();
  now_.noalias() = A * v;
  before_.noalias() = A * v_;
  for (int g = 0; g < system_.groups; ++g) {
    if (!tied_[g]) continue;
    double both = 0, now = 0, before = 0;
    for (int i = 0; i < system_.nv; ++i) {
      if (system_.velocity_groups[i] != g) continue;
      both += v_[i] * now_[i];
      now += v[i] * now_[i];
      before += v_[i] * before_[i];
    }
    if (now > 0 && before > 0)
      largest = std::max(largest, std::acos(std::min(1.0, std::abs(both) / std::sqrt(now * before))));
  }
  return largest;
}

SingularWatch::Reason SingularWatch::observe_projection(double t, const Projection& projection,
                                                        const Workspace& w) {
  Reason reason;
  for (int g = 0; g < system_.groups; ++g) {
    const double kinetic = w.terms.group_kinetic[g];
    fastest_[g] = std::max(fastest_[g], kinetic);
    // If the group stops for a moment, any error is large relative to its velocity; at rest, rounding is.
    double rounding = 0;
    for (int i = 0; i < system_.nv; ++i)
      if (system_.velocity_groups[i] == g)
        rounding += w.terms.A(i, i) * std::pow(slowest * system_.velocity_scale[i], 2) / 2;
    const double part = projection.velocity_change[g] / std::max({kinetic, 1e-6 * fastest_[g], rounding});
    if (!reason && part > jump_limit * jump_limit)
      reason = fmt::format(
          "the velocities of '{}' and the solids tied to it jumped by {:.2g} of their size onto the "
          "constraints at t = {:.6g} s (row '{}' had the largest residual): a step left a singular position "
          "on another branch, or steps are too long",
          system_.group_name(g), std::sqrt(part), t, system_.row_names[projection.worst_row[g]]);
  }
  return reason;
}

}  // namespace borelli
