#include "dynamics/constraints/assembly.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "dynamics/constraints/local_coordinates.hpp"
#include "dynamics/system/border.hpp"

namespace borelli {

namespace {

// Residuals are relative to the size of what the constraint ties (rows that are lengths) or to 1 (angles,
// couplings).
constexpr double reached = 1e-13;   // the limit of double precision
constexpr double satisfied = 1e-9;  // accepted residual; allows for rounding in scenes far from their origin
constexpr double largest_turn = 0.3;  // per Newton step, rad or scene sizes; linearisation fails beyond

// Least residual scale, in parts of the scene's length: with it `satisfied` never asks for less than 1e-14 of
// that length, which is rounding.
constexpr double rounding_share = 1e-5;

double residual(const System& system, const Workspace& w, int row) {
  // Far from the origin, rounding alone exceeds `reached` for a small object.
  const double scale = std::max(system.row_scale[row], rounding_share * system.length);
  return std::abs(w.rows.h[row]) / scale;
}

/// Per independent group, the row with the largest residual.
void find_worst_rows(const System& system, const Workspace& w, Eigen::VectorXi& rows) {
  rows.setConstant(system.groups, -1);
  for (int row = 0; row < system.rows; ++row) {
    int& worst = rows[system.constraints[system.row_constraint[row]].group];
    if (worst < 0 || residual(system, w, row) > residual(system, w, worst)) worst = row;
  }
}

/// The largest residual among the independent rows, and its row.
std::pair<double, int> worst_independent(const System& system, const Workspace& w) {
  std::pair<double, int> worst{0, -1};
  for (int k = 0; k < w.solver.rank(); ++k) {
    const int row = w.solver.order()[k];
    if (const double r = residual(system, w, row); !(r <= worst.first)) worst = {r, row};
  }
  return worst;
}

/// The largest residual of all rows, and the sum of their squares.
std::pair<double, double> total_residual(const System& system, const Workspace& w) {
  double largest = 0, sum = 0;
  for (int row = 0; row < system.rows; ++row) {
    const double r = residual(system, w, row);
    if (!(r <= largest)) largest = r;
    sum += r * r;
  }
  return {largest, sum};
}

}  // namespace

// Assembly ends at the least sum of squares, where sum_i h_i grad h_i = 0. The rows with a residual are
// dependent there, and each residual shows the row's part in the contradiction.
std::string contradiction(const System& system, const Workspace& w, int row) {
  std::vector<std::string> names = w.solver.rows_behind(row);
  const double own = residual(system, w, row);
  for (int other = 0; other < system.rows; ++other) {
    const std::string& name = system.row_names[other];
    if (other == row || system.row_constraint[other] == system.row_constraint[row]) continue;
    // Residuals below a thousandth of this row's are only unfinished convergence.
    if (residual(system, w, other) > std::max(satisfied, 1e-3 * own) &&
        std::find(names.begin(), names.end(), name) == names.end())
      names.push_back(name);
  }
  return names.empty() ? "" : fmt::format("; it contradicts '{}'", fmt::join(names, "', '"));
}

namespace {

class Assembler {
 public:
  Assembler(const System& system, const Parameters& parameters, State& state, Workspace& workspace)
      : system_(system), parameters_(parameters), state_(state), w_(workspace), trial_(state.q) {}

  Result<Assembly> run() {
    for (int iteration = 0; iteration < 200; ++iteration) {
      if (const Fault fault = update(state_.q)) return tl::unexpected(describe(system_, fault, state_.t));
      w_.solver.prepare(w_.rows.L, w_.factor, true, RowSet::positions);
      if (total_residual(system_, w_).first <= reached || !improve()) break;
    }
    if (const Fault fault = update(state_.q)) return tl::unexpected(describe(system_, fault, state_.t));
    w_.solver.prepare(w_.rows.L, w_.factor, true, RowSet::positions);
    for (int k = system_.rows - 1; k >= 0; --k)  // dependent rows first: these contradict others
      if (const int row = w_.solver.order()[k]; !(residual(system_, w_, row) <= satisfied))
        return tl::unexpected(unsatisfied(row));
    if (auto done = assemble_velocities(); !done) return tl::unexpected(done.error());
    Assembly assembly{.rank = w_.solver.rank(), .redundant = {}, .position = {}, .velocity = {}};
    for (int k = w_.solver.rank(); k < system_.rows; ++k)
      if (const int row = w_.solver.order()[k]; !rests(row))
        assembly.redundant.push_back(system_.row_names[row]);
    return assembly;
  }

 private:
  /// Whether the row belongs to a contact; contacts hold nothing yet.
  bool rests(int row) const {
    const auto& contacts = system_.contacts;
    return std::any_of(contacts.begin(), contacts.end(),
                       [&](const Contact& c) { return c.row <= row && row < c.row + (c.tangents ? 3 : 1); });
  }

  Fault update(const Eigen::VectorXd& q) {
    return update_terms(system_, parameters_, state_.t, q.data(), state_.v.data(), w_);
  }

  /// One Gauss-Newton step with the best of several dampings. Returns false if no step lowers the residual.
  bool improve() {
    const double before = total_residual(system_, w_).second;
    w_.wanted = -w_.rows.h;
    std::vector<Eigen::VectorXd> steps(1);
    w_.solver.correct(w_.factor, w_.wanted, steps[0]);
    for (double damping : {0.0, 1e-4, 1e-3, 1e-2, 1e-1, 1.0})
      w_.solver.compromise(w_.factor, w_.wanted, damping, steps.emplace_back());
    double best = before;
    Eigen::VectorXd reached_q;
    for (const Eigen::VectorXd& step : steps) {
      if (const double after = residual_after(step); after < best) {
        best = after;
        reached_q = trial_;
      }
      if (best < 0.1 * before) break;  // a tenfold reduction is good enough
    }
    if (best < before) state_.q = reached_q;
    return best < before;
  }

  /// Sum of squared residuals of all rows after the step, which is shortened to `largest_turn` if longer.
  double residual_after(const Eigen::VectorXd& step) {
    double largest = 0;
    for (const CoordinateInfo& info : system_.coordinates)
      for (int i = info.v_index; i < info.v_index + info.v_size; ++i)
        largest = std::max(largest, std::abs(step[i]) / system_.velocity_scale[i]);
    if (!std::isfinite(largest)) return std::numeric_limits<double>::infinity();
    const Eigen::VectorXd move =
        largest > largest_turn ? Eigen::VectorXd(step * (largest_turn / largest)) : step;
    from_local_coordinates(system_, state_.q.data(), move.data(), trial_.data());
    return update(trial_) ? std::numeric_limits<double>::infinity() : total_residual(system_, w_).second;
  }

  Result<void> assemble_velocities() {
    w_.solver.prepare(w_.rows.L, w_.factor, true);
    w_.wanted = -w_.rows.rate;
    w_.solver.correct(w_.factor, w_.wanted, w_.correction);
    state_.v += w_.correction;
    if (const Fault fault = update(state_.q)) return tl::unexpected(describe(system_, fault, state_.t));
    const double speed = std::max(state_.v.size() ? state_.v.cwiseAbs().maxCoeff() : 0, 1.0);
    for (int row = 0; row < system_.rows; ++row) {
      const double left = std::abs(w_.rows.rate[row]) / system_.row_scale[row];
      if (left <= satisfied * speed) continue;
      return failure(system_.row_place(row),
                     fmt::format("its rate cannot be zero at the start: {:.6g} per second remains{}",
                                 w_.rows.rate[row], contradiction(system_, w_, row)));
    }
    w_.solver.prepare(w_.rows.L, w_.factor, true);
    return {};
  }

  Error unsatisfied(int row) const {
    const std::string where = system_.row_place(row);
    const std::string left = fmt::format("a residual of {:.6g} remains", w_.rows.h[row]);
    if (w_.solver.is_empty(row))
      return {where, fmt::format("no free coordinate moves it from the position reached, and {}; check its "
                                 "points and the initial positions",
                                 left)};
    if (const std::string with = contradiction(system_, w_, row); !with.empty())
      return {where, fmt::format("cannot hold at the start: {}{}", left, with)};
    return {where,
            fmt::format("cannot be reached from the initial positions: {}; check its points, or start closer",
                        left)};
  }

  const System& system_;
  const Parameters& parameters_;
  State& state_;
  Workspace& w_;
  Eigen::VectorXd trial_;
};

}  // namespace

Assembly::Move largest_move(const System& system, const State& before, const State& after, bool positions) {
  Assembly::Move most;
  for (const CoordinateInfo& info : system.coordinates) {
    double size;
    if (!positions) {
      size = (after.v - before.v).segment(info.v_index, info.v_size).norm();
    } else if (info.q_size == 4) {  // angle between two orientations, from the chord of their quaternions
      const Quaternion a = before.q.segment<4>(info.q_index), b = after.q.segment<4>(info.q_index);
      size = 4 * std::asin(std::min(1.0, 0.5 * std::min((a - b).norm(), (a + b).norm())));
    } else {
      size = std::abs(after.q[info.q_index] - before.q[info.q_index]);
    }
    const double relative = size / system.velocity_scale[info.v_index];
    if (relative > most.relative) most = {size, relative, info.angle, info.name};
  }
  return most;
}

Result<Assembly> assemble(const System& system, const Parameters& parameters, State& state,
                          Workspace& workspace) {
  for (const CoordinateInfo& info : system.coordinates)
    if (info.q_size == 4) state.q.segment<4>(info.q_index).normalize();
  if (!workspace.has_rows()) return Assembly{};
  const State before = state;
  workspace.solver.forget();
  auto assembly = Assembler(system, parameters, state, workspace).run();
  if (!assembly) return assembly;
  assembly->position = largest_move(system, before, state, true);
  assembly->velocity = largest_move(system, before, state, false);
  return assembly;
}

Result<Assembly> assemble(const System& system, State& state) {
  return at_border(system, [&]() -> Result<Assembly> {
    if (auto fits = admit_workspaces(system, system.settings.equations, 1, false); !fits)
      return tl::unexpected(fits.error());
    Workspace workspace(system);
    return assemble(system, system.parameters, state, workspace);
  });
}

void project(const System& system, const Parameters& parameters, State& state, Workspace& w,
             Projection& out) {
  out.unreached = -1;
  double before = std::numeric_limits<double>::infinity();
  for (int iteration = 0;; ++iteration) {
    out.fault = update_terms(system, parameters, state.t, state.q.data(), state.v.data(), w);
    if (out.fault) return;
    if (iteration == 0) {
      out.energy_before = w.terms.group_kinetic + w.terms.group_potential;
      find_worst_rows(system, w, out.worst_row);
    }
    w.solver.prepare(w.rows.L, w.factor, true, RowSet::positions);
    const auto [worst, row] = worst_independent(system, w);
    // Quadratic convergence ends at `reached`, or far from the origin when the residual stops falling.
    if (worst <= reached || (worst <= satisfied && worst > 0.5 * before)) break;
    if (iteration == 20 || !std::isfinite(worst)) {
      out.unreached = row;
      return;
    }
    before = worst;
    w.wanted = -w.rows.h;
    w.solver.correct(w.factor, w.wanted, w.correction);
    from_local_coordinates(system, state.q.data(), w.correction.data(), state.q.data());
  }
  if (system.has_kinematic_rows()) w.solver.prepare(w.rows.L, w.factor, true);
  w.wanted = -w.rows.rate;
  w.solver.correct(w.factor, w.wanted, w.correction);
  state.v += w.correction;
  out.velocity_change.setZero(system.groups);
  for (int i = 0; i < system.nv; ++i) {
    const double part = w.solver.measured()[i];
    out.velocity_change[system.velocity_groups[i]] += part * part / 2;
  }
}

}  // namespace borelli
