#include "dynamics/batch.hpp"

#include <fmt/format.h>

#include "dynamics/inverse_dynamics.hpp"
#include "dynamics/processor.hpp"

namespace borelli {

Result<void> check_batch(const System& system) {
  if (system.rows > 0)
    return bad_use(fmt::format("constraint '{}'", system.constraint_names[0]),
                   "batches are for scenes without constraints and contacts; take its states one by one");
  for (const Effort& effort : system.parameters.efforts)
    if (std::holds_alternative<OwnEffort>(effort.kind))
      return bad_use(fmt::format("effort '{}'", effort.name),
                     "is a program's own, which batches cannot compute; take its states one by one");
  for (std::size_t b = 1; b < system.bodies.size(); ++b)
    if (system.bodies[b].step_count == 0)
      return bad_use(system.scene, "batches are for scenes compiled with welds merged");
  return {};
}

BatchState::BatchState(const System& system) : t(system.initial.t), q(system.nq), v(system.nv) {
  for (int lane = 0; lane < Lanes::count; ++lane) set(lane, system.initial);
}

void BatchState::set(int lane, const State& state) {
  for (Eigen::Index i = 0; i < q.size(); ++i) q[i].set(lane, state.q[i]);
  for (Eigen::Index i = 0; i < v.size(); ++i) v[i].set(lane, state.v[i]);
}

State BatchState::state(int lane) const {
  State out{t, Eigen::VectorXd(q.size()), Eigen::VectorXd(v.size())};
  for (Eigen::Index i = 0; i < q.size(); ++i) out.q[i] = q[i][lane];
  for (Eigen::Index i = 0; i < v.size(); ++i) out.v[i] = v[i][lane];
  return out;
}

BatchWorkspace::BatchWorkspace(const System& system, bool mass_matrix)
    : inertials(system.bodies.size()),
      kinematics(system, Equations::recursive),
      efforts(system),
      terms(system, mass_matrix),
      articulation(system),
      recursion(system),
      a(Eigen::VectorX<Lanes>::Zero(system.nv)),
      drive_efforts(Eigen::VectorX<Lanes>::Zero(system.driven_nv)),
      group_power(Eigen::VectorX<Lanes>::Zero(system.groups)),
      numbers(system.parameters),
      given(Eigen::VectorXd::Zero(system.nv)) {
  for (std::size_t b = 0; b < inertials.size(); ++b)
    for (int lane = 0; lane < Lanes::count; ++lane)
      set_inertial(lane, int(b), system.parameters.inertials[b]);
}

void BatchWorkspace::set_inertial(int lane, int body, const Inertial& inertial) {
  VariedInertial<Lanes>& to = inertials[body];
  to.mass.set(lane, inertial.mass);
  for (int i = 0; i < 3; ++i) {
    to.centre[i].set(lane, inertial.centre[i]);
    for (int j = 0; j < 3; ++j) to.tensor(i, j).set(lane, inertial.tensor(i, j));
  }
  to.principal = has_principal_axes(to.tensor);
}

namespace {

BORELLI_LANES_FOR_PROCESSOR
bool all_finite(const Eigen::VectorX<Lanes>& numbers) {
  Lanes sums[4] = {0, 0, 0, 0};  // zero, but where a number is none
  for (Eigen::Index i = 0; i < numbers.size(); ++i) sums[i % 4] += 0 * numbers[i];
  return everywhere(sums[0] + sums[1] + (sums[2] + sums[3]) == 0);
}

/// Solves one lane by itself, and puts what came of it in its place.
Fault accelerate_alone(const System& system, const Parameters& parameters, const BatchState& state, int lane,
                       const Lanes* applied, BatchWorkspace& w) {
  w.numbers = parameters;
  for (std::size_t b = 0; b < w.inertials.size(); ++b) {
    const VariedInertial<Lanes>& from = w.inertials[b];
    Inertial& to = w.numbers.inertials[b];
    to.mass = from.mass[lane];
    for (int i = 0; i < 3; ++i) {
      to.centre[i] = from.centre[i][lane];
      for (int j = 0; j < 3; ++j) to.tensor(i, j) = from.tensor(i, j)[lane];
    }
  }
  if (!w.single) w.single.emplace(system, Equations::recursive);
  if (applied)
    for (int i = 0; i < system.nv; ++i) w.given[i] = applied[i][lane];
  const State one = state.state(lane);
  const Fault fault = accelerate(system, w.numbers, one.t, one.q.data(), one.v.data(), {}, *w.single,
                                 applied ? w.given.data() : nullptr, Wanted::accelerations);
  for (int i = 0; i < system.nv; ++i) w.a[i].set(lane, w.single->a[i]);
  for (int d = 0; d < system.driven_nv; ++d) w.drive_efforts[d].set(lane, w.single->drive_efforts[d]);
  for (int g = 0; g < system.groups; ++g) w.group_power[g].set(lane, w.single->group_power[g]);
  return fault;
}

}  // namespace

bool accelerate(const System& system, const Parameters& parameters, const BatchState& state,
                BatchWorkspace& w, const Lanes* applied, Wanted wanted) {
  const bool acted = !system.efforts.empty();
  move_links<Lanes>(system, parameters, w.inertials, state.t, state.q.data(), state.v.data(), nullptr,
                    w.kinematics, w.articulation);
  if (acted) {
    find_bodies<Lanes>(system, parameters, w.inertials, w.kinematics, w.articulation);
    scan_efforts(system, parameters, w.kinematics, w.efforts);
  }
  w.faults.fill({});
  w.together = find_accelerations(system, parameters, w.inertials, w.kinematics, acted ? &w.efforts : nullptr,
                                  applied, w.articulation, w.a.data(), w.drive_efforts.data());
  if (wanted == Wanted::all) find_energies(system, parameters, w);
  if (w.together) {
    w.group_power = w.efforts.group_power;
    for (int d = 0; d < system.driven_nv; ++d)
      w.group_power[system.velocity_groups[system.nv + d]] +=
          w.drive_efforts[d] * w.kinematics.u[system.nv + d];
    w.together = all_finite(w.a);
  }
  if (w.together) return true;
  bool solved = true;
  for (int lane = 0; lane < Lanes::count; ++lane) {
    w.faults[lane] = accelerate_alone(system, parameters, state, lane, applied, w);
    if (w.faults[lane]) solved = false;
  }
  return solved;
}

void find_energies(const System& system, const Parameters& parameters, BatchWorkspace& w) {
  find_energies(system, parameters, w.inertials, w.kinematics, system.efforts.empty() ? nullptr : &w.efforts,
                w.articulation, w.terms);
}

void inverse_dynamics(const System& system, const Parameters& parameters, const BatchState& state,
                      const Eigen::VectorX<Lanes>& a, BatchWorkspace& w, Eigen::VectorX<Lanes>& efforts) {
  inverse_dynamics(system, parameters, w.inertials, state.t, state.q.data(), state.v.data(), a.data(),
                   w.kinematics, w.efforts, w.articulation, efforts.data());
}

void find_mass_matrix(const System& system, const Parameters& parameters, const BatchState& state,
                      BatchWorkspace& w) {
  update_kinematics<Lanes>(system, parameters, w.inertials, state.t, state.q.data(), nullptr, nullptr,
                           w.kinematics);
  find_mass_matrix(system, parameters, w.inertials, w.kinematics, w.recursion, w.terms);
}

}  // namespace borelli
