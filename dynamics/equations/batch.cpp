#include "dynamics/equations/batch.hpp"

#include <fmt/format.h>

#include <limits>

#include "dynamics/equations/inverse_dynamics.hpp"
#include "dynamics/numbers/processor.hpp"

namespace borelli {

Result<void> check_batch(const System& system) {
  if (system.rows > 0)
    return bad_use(fmt::format("constraint '{}'", system.constraint_names[0]),
                   "batches need a scene without constraints and contacts; evaluate its states one by one");
  return check_batch_without_rows(system);
}

Result<void> check_batch_without_rows(const System& system) {
  for (const Effort& effort : system.parameters.efforts)
    if (std::holds_alternative<OwnEffort>(effort.kind))
      return bad_use(fmt::format("effort '{}'", effort.name),
                     "is C++ code, which batches cannot compute; evaluate its states one by one");
  for (std::size_t b = 1; b < system.bodies.size(); ++b)
    if (system.bodies[b].step_count == 0)
      return bad_use(system.scene, "batches need a scene compiled with welds merged");
  return {};
}

template <class T>
BatchStateOf<T>::BatchStateOf(const System& system) : t(system.initial.t), q(system.nq), v(system.nv) {
  for (int lane = 0; lane < T::count; ++lane) set(lane, system.initial);
}

template <class T>
void BatchStateOf<T>::set(int lane, const State& state) {
  for (Eigen::Index i = 0; i < q.size(); ++i) q[i].set(lane, state.q[i]);
  for (Eigen::Index i = 0; i < v.size(); ++i) v[i].set(lane, state.v[i]);
}

template <class T>
State BatchStateOf<T>::state(int lane) const {
  State out{t, Eigen::VectorXd(q.size()), Eigen::VectorXd(v.size())};
  for (Eigen::Index i = 0; i < q.size(); ++i) out.q[i] = q[i][lane];
  for (Eigen::Index i = 0; i < v.size(); ++i) out.v[i] = v[i][lane];
  return out;
}

template <class T>
BatchWorkspaceOf<T>::BatchWorkspaceOf(const System& system, bool mass_matrix)
    : inertials(system.bodies.size()),
      kinematics(system, Equations::recursive),
      efforts(system),
      terms(system, mass_matrix),
      articulation(system),
      a(Eigen::VectorX<T>::Zero(system.nv)),
      drive_efforts(Eigen::VectorX<T>::Zero(system.driven_nv)),
      group_power(Eigen::VectorX<T>::Zero(system.groups)) {
  if (mass_matrix) recursion.emplace(system);
  for (std::size_t b = 0; b < inertials.size(); ++b) {
    for (int lane = 0; lane < T::count; ++lane) inertials[b].set(lane, system.parameters.inertials[b]);
    inertials[b].settle();
  }
}

template <class T>
void BatchWorkspaceOf<T>::set_inertial(int lane, int body, const Inertial& inertial) {
  inertials[body].set(lane, inertial);
  inertials[body].settle();
}

namespace {

template <class T>
bool finite_sums(const T* numbers, Eigen::Index count) {
  T sums[4] = {0, 0, 0, 0};  // zero unless a number is not finite
  Eigen::Index i = 0;
  for (; i + 4 <= count; i += 4)
    for (int n = 0; n < 4; ++n) sums[n] += 0 * numbers[i + n];
  for (; i < count; ++i) sums[0] += 0 * numbers[i];
  return everywhere((sums[0] + sums[1]) + (sums[2] + sums[3]) == 0);
}
template <class T>
bool all_finite(const Eigen::VectorX<T>& numbers) {
  return in_registers([]<int>(auto&... each) { return finite_sums(each...); }, numbers.data(),
                      numbers.size());
}

/// Solves one lane alone and stores its results in the batch.
template <class T>
Fault accelerate_alone(const System& system, const Parameters& parameters, const BatchStateOf<T>& state,
                       int lane, const T* applied, BatchWorkspaceOf<T>& w) {
  if (!w.alone)
    w.alone.emplace(typename BatchWorkspaceOf<T>::Alone{Workspace(system, Equations::recursive), parameters,
                                                        Eigen::VectorXd::Zero(system.nv)});
  auto& [single, numbers, given] = *w.alone;
  numbers = parameters;
  for (std::size_t b = 0; b < w.inertials.size(); ++b) numbers.inertials[b] = w.inertials[b].lane(lane);
  if (applied)
    for (int i = 0; i < system.nv; ++i) given[i] = applied[i][lane];
  const State one = state.state(lane);
  const Fault fault = accelerate(system, numbers, one.t, one.q.data(), one.v.data(), {}, single,
                                 applied ? given.data() : nullptr, Wanted::accelerations);
  // (An unsolved lane gets NaN, not the numbers of another lane.)
  const double whole = fault ? std::numeric_limits<double>::quiet_NaN() : 0;
  for (int i = 0; i < system.nv; ++i) w.a[i].set(lane, single.a[i] + whole);
  for (int d = 0; d < system.driven_nv; ++d) w.drive_efforts[d].set(lane, single.drive_efforts[d]);
  for (int g = 0; g < system.groups; ++g) w.group_power[g].set(lane, single.group_power[g]);
  return fault;
}

}  // namespace

template <class T>
bool accelerate(const System& system, const Parameters& parameters, const BatchStateOf<T>& state,
                BatchWorkspaceOf<T>& w, const std::type_identity_t<T>* applied, Wanted wanted) {
  const bool acted = !system.efforts.empty();
  w.coordinates_set = acted || wanted == Wanted::all || system.driven_nv > 0;
  if (w.coordinates_set)
    move_links<T>(system, parameters, w.inertials, state.t, state.q.data(), state.v.data(), nullptr,
                  w.kinematics, w.articulation);
  else
    move_links_alone<T>(parameters, w.inertials, state.q.data(), state.v.data(), w.articulation);
  if (acted) {
    find_bodies<T>(system, parameters, w.inertials, w.kinematics, w.articulation);
    scan_efforts(system, parameters, w.kinematics, w.efforts);
  }
  w.faults.fill({});
  w.together = find_accelerations(system, parameters, w.inertials, w.kinematics, acted ? &w.efforts : nullptr,
                                  applied, w.articulation, w.a.data(), w.drive_efforts.data());
  if (wanted == Wanted::all) find_energies(system, parameters, state, w);
  if (w.together) {
    w.group_power = w.efforts.group_power;
    for (int d = 0; d < system.driven_nv; ++d)
      w.group_power[system.velocity_groups[system.nv + d]] +=
          w.drive_efforts[d] * w.kinematics.u[system.nv + d];
    w.together = all_finite(w.a);
  }
  if (w.together) return true;
  bool solved = true;
  for (int lane = 0; lane < T::count; ++lane) {
    w.faults[lane] = accelerate_alone(system, parameters, state, lane, applied, w);
    if (w.faults[lane]) solved = false;
  }
  return solved;
}

template <class T>
void find_energies(const System& system, const Parameters& parameters, const BatchStateOf<T>& state,
                   BatchWorkspaceOf<T>& w) {
  if (!w.coordinates_set)
    set_coordinates<T>(system, parameters, state.t, state.q.data(), state.v.data(), nullptr, w.kinematics);
  w.coordinates_set = true;
  find_energies(system, parameters, w.inertials, w.kinematics, system.efforts.empty() ? nullptr : &w.efforts,
                w.articulation, w.terms);
}

void inverse_dynamics(const System& system, const Parameters& parameters, const BatchState& state,
                      const Eigen::VectorX<Lanes>& a, BatchWorkspace& w, Eigen::VectorX<Lanes>& efforts) {
  inverse_dynamics(system, parameters, w.inertials, state.t, state.q.data(), state.v.data(), a.data(),
                   w.kinematics, w.efforts, w.articulation, efforts.data());
}

void find_inverse_derivatives(const System& system, const Parameters& parameters, const BatchState& state,
                              const Eigen::VectorX<Lanes>& a, BatchWorkspace& w,
                              InverseDerivativesOf<Lanes>& out) {
  update_kinematics<Lanes>(system, parameters, w.inertials, state.t, state.q.data(), state.v.data(), a.data(),
                           w.kinematics);
  find_inverse_derivatives<Lanes>(system, parameters, w.inertials, w.kinematics, nullptr, out);
}

void find_mass_matrix(const System& system, const Parameters& parameters, const BatchState& state,
                      BatchWorkspace& w) {
  update_kinematics<Lanes>(system, parameters, w.inertials, state.t, state.q.data(), nullptr, nullptr,
                           w.kinematics);
  find_mass_matrix(system, parameters, w.inertials, w.kinematics, *w.recursion, w.terms);
}

#define BORELLI_BATCH_OVER(T)                                                                              \
  template struct BatchStateOf<T>;                                                                         \
  template struct BatchWorkspaceOf<T>;                                                                     \
  template bool accelerate(const System&, const Parameters&, const BatchStateOf<T>&, BatchWorkspaceOf<T>&, \
                           const T*, Wanted);                                                              \
  template void find_energies(const System&, const Parameters&, const BatchStateOf<T>&, BatchWorkspaceOf<T>&);
BORELLI_BATCH_OVER(Lanes)
BORELLI_BATCH_OVER(Quad)

}  // namespace borelli
