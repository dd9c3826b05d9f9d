#include "dynamics/methods/motion_flow.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "dynamics/constraints/local_coordinates.hpp"
#include "dynamics/equations/batch.hpp"
#include "dynamics/system/fastest_change.hpp"
#include "dynamics/system/time_functions_of.hpp"

namespace borelli {

namespace {

// Local coordinates become singular when a ball has turned by 2 pi from their centre.
constexpr double largest_turn = 5;  // rad

// Local coordinates that a method keeps over steps are centred anew well before that.
constexpr double recentring_turn = 1;  // rad

/// Whether all prescribed functions are constant in time.
bool same_at_all_times(const System& system) {
  bool same = system.driven_nv == 0;
  each_time_function(system, system.parameters, [&](const std::string&, const TimeFunction& f) {
    const auto* polynomial = std::get_if<Polynomial>(&f);
    if (!polynomial || polynomial->coefficients.size() > 1) same = false;
  });
  return same;
}

/// Whether more than half of the bodies are single pendulums.
bool mostly_swings(const System& system, const Articulation& articulation) {
  std::size_t swinging = 0;
  for (const SideBySide& side : articulation.trees)
    if (side.swings) swinging += std::size_t(side.trees.count);
  return 2 * swinging > system.bodies.size() - 1;
}

std::vector<int> find_groups_with_rows(const System& system) {
  std::vector<int> groups;
  for (const Action& constraint : system.constraints) groups.push_back(constraint.group);
  std::ranges::sort(groups);
  groups.erase(std::unique(groups.begin(), groups.end()), groups.end());
  return groups;
}

}  // namespace

template <class T>
struct MotionFlow::Together {
  explicit Together(const System& system) : w(system), state(system), centre(system.nq) {}
  void set_centre(const Eigen::VectorXd& q0) {
    for (Eigen::Index i = 0; i < q0.size(); ++i) centre[i] = q0[i];
  }
  BatchWorkspaceOf<T> w;
  BatchStateOf<T> state;
  Eigen::VectorX<T> centre;
};

MotionFlow::~MotionFlow() = default;

MotionFlow::MotionFlow(const System& system, const SimulationSettings& settings, Workspace& workspace)
    : system_(system),
      w_(workspace),
      projects_(settings.constraints == ConstraintTreatment::projection),
      groups_with_rows_(find_groups_with_rows(system)),
      apart_groups_(groups_with_rows_.size() > 1 ? groups_with_rows_ : std::vector<int>()),
      scale_(size()),
      q_(system.nq),
      last_v_(system.nv),
      lanes_fit_(workspace.kinematics.equations == Equations::recursive && check_batch_without_rows(system) &&
                 same_at_all_times(system) && !mostly_swings(system, workspace.articulation)) {
  if (settings.constraints == ConstraintTreatment::baumgarte) {
    handling_.alpha = settings.baumgarte_alpha;
    handling_.beta = settings.baumgarte_beta;
  }
  auto counted = groups_of_counted_work(system, system.parameters);
  if (std::find(counted.begin(), counted.end(), 1) != counted.end() && method_is_adaptive(settings.method))
    counted_groups_ = std::move(counted);
  within_step_ = handling_;
  within_step_.decide_rank = false;
}

bool MotionFlow::start(const State& state, const Work& work, Eigen::VectorXd& y, Eigen::VectorXd& dy) {
  // No rows whose rank must be decided, and no other solution in the workspace since.
  const bool known = !w_.has_rows() && solved_ && w_.evaluations == evaluations_ &&
                     std::abs(last_time_ - state.t) <= 1e-15 * std::abs(state.t) && state.q == q_ &&
                     state.v == last_v_;
  q0_ = state.q;
  if (four_) four_->set_centre(q0_);
  if (eight_) eight_->set_centre(q0_);
  y.setZero();
  y.segment(system_.nv, system_.nv) = state.v;
  y.segment<4>(2 * system_.nv) << work.efforts, work.drives, work.constraints, work.violation;
  const Eigen::Index of_groups = 2 * system_.nv + 4, apart = of_groups + system_.groups;
  for (int g = 0; g < system_.groups; ++g) y[of_groups + g] = work.groups[g].moving;
  for (std::size_t i = 0; i < apart_groups_.size(); ++i)
    y[apart + Eigen::Index(i)] = work.groups[apart_groups_[i]].rows;
  set_scale(state);
  if (!known) {
    turned_ = -1;
    if (!counted_groups_.empty() && unit_energy_.size() == 0 && !find_unit_energies(state)) return false;
    fault_ = accelerate(system_, system_.parameters, state.t, state.q.data(), state.v.data(), handling_, w_);
    if (fault_) return false;
    w_.solver.remember();
  } else {
    complete(system_, system_.parameters, w_);
  }
  set_work_scale();
  fill(y, dy);
  return true;
}

bool MotionFlow::go_on(const State& state, const Eigen::VectorXd& y, Eigen::VectorXd& dy) {
  set_scale(state);
  turned_ = -1;
  fault_ = accelerate(system_, system_.parameters, state.t, state.q.data(), state.v.data(), handling_, w_);
  if (fault_) return false;
  set_work_scale();
  fill(y, dy);
  return true;
}

bool MotionFlow::off_centre(const Eigen::VectorXd& y) const {
  for (const CoordinateInfo& info : system_.coordinates)
    if (info.q_size == 4 && y.segment<3>(info.v_index).norm() > recentring_turn) return true;
  return false;
}

bool MotionFlow::derivative(double t, const Eigen::VectorXd& y, Eigen::VectorXd& dy) {
  solved_ = false;
  if (turned_too_far(y)) return false;
  from_local_coordinates(system_, q0_.data(), y.data(), q_.data());
  last_v_ = y.segment(system_.nv, system_.nv);
  fault_ = accelerate(system_, system_.parameters, t, q_.data(), last_v_.data(), within_step_, w_, nullptr,
                      Wanted::accelerations);
  if (fault_) return false;
  fill(y, dy);
  solved_ = !w_.has_rows();
  last_time_ = t;
  evaluations_ = w_.evaluations;
  return true;
}

bool MotionFlow::has_lanes() { return lanes_fit_ && !w_.has_rows(); }

bool MotionFlow::derivatives(const Eigen::VectorX<Quad>& y, int states, Eigen::VectorX<Quad>& dy) {
  return solve_together(four_, y, states, dy);
}
bool MotionFlow::derivatives(const Eigen::VectorX<Lanes>& y, int states, Eigen::VectorX<Lanes>& dy) {
  return solve_together(eight_, y, states, dy);
}

template <class T>
bool MotionFlow::solve_together(std::unique_ptr<Together<T>>& together, const Eigen::VectorX<T>& y,
                                int states, Eigen::VectorX<T>& dy) {
  if (!together) {
    together = std::make_unique<Together<T>>(system_);
    together->set_centre(q0_);
  }
  BatchWorkspaceOf<T>& w = together->w;
  const int n = system_.nv;
  fault_ = {};
  turned_ = -1;
  for (const CoordinateInfo& info : system_.coordinates)
    if (info.q_size == 4 &&
        (y.template segment<3>(info.v_index).squaredNorm() > largest_turn * largest_turn).any())
      turned_ = info.v_index;
  if (turned_ >= 0) return false;
  from_local_coordinates(system_, together->centre.data(), y.data(), together->state.q.data());
  together->state.v = y.segment(n, n);
  w_.evaluations += states;
  const bool solved =
      accelerate(system_, system_.parameters, together->state, w, nullptr, Wanted::accelerations);
  if (!w.together) lanes_fit_ = false;
  if (!solved) {
    fault_ = *std::find_if(w.faults.begin(), w.faults.end(), [](const Fault& fault) { return bool(fault); });
    return false;
  }
  dy.resize(size());
  local_rate(system_, y.data(), y.data() + n, dy.data());
  dy.segment(n, n) = w.a;
  dy.template segment<4>(2 * n) << w.efforts.power, T(0), T(0), T(0);
  dy.segment(2 * n + 4, system_.groups) = w.group_power;
  dy.tail(Eigen::Index(apart_groups_.size())).fill(T(0));  // no row is active
  return true;
}

void MotionFlow::position_rate(const Eigen::VectorXd& y, Eigen::VectorXd& dy) {
  local_rate(system_, y.data(), y.data() + system_.nv, dy.data());
}

void MotionFlow::position_rates(const Eigen::VectorX<Lanes>& y, Eigen::VectorX<Lanes>& dy) {
  local_rate(system_, y.data(), y.data() + system_.nv, dy.data());
}

/// Fills dy at y from the last solution of the equations.
void MotionFlow::fill(const Eigen::VectorXd& y, Eigen::VectorXd& dy) const {
  const int n = system_.nv;
  dy.resize(size());
  local_rate(system_, y.data(), y.data() + n, dy.data());
  dy.segment(n, n) = w_.a;
  dy.segment<4>(2 * n) << w_.power.efforts, w_.power.drives, w_.power.constraints, w_.power.violation;
  dy.segment(2 * n + 4, system_.groups) = w_.group_power;
  for (std::size_t i = 0; i < apart_groups_.size(); ++i)
    dy[2 * n + 4 + system_.groups + Eigen::Index(i)] = w_.group_violation[apart_groups_[i]];
}

bool MotionFlow::turned_too_far(const Eigen::VectorXd& y) {
  turned_ = -1;
  for (const CoordinateInfo& info : system_.coordinates)
    if (info.q_size == 4 && y.segment<3>(info.v_index).norm() > largest_turn) turned_ = info.v_index;
  return turned_ >= 0;
}

void MotionFlow::take(const Eigen::VectorXd& y, State& state, Work& work) const {
  from_local_coordinates(system_, q0_.data(), y.data(), state.q.data());
  state.v = y.segment(system_.nv, system_.nv);
  const auto done = y.segment<4>(2 * system_.nv);
  work.efforts = done[0];
  work.drives = done[1];
  work.constraints = done[2];
  work.violation = done[3];
  const Eigen::Index of_groups = 2 * system_.nv + 4, apart = of_groups + system_.groups;
  for (int g = 0; g < system_.groups; ++g) work.groups[g].moving = y[of_groups + g];
  if (groups_with_rows_.size() == 1) work.groups[groups_with_rows_[0]].rows = work.violation;
  for (std::size_t i = 0; i < apart_groups_.size(); ++i)
    work.groups[apart_groups_[i]].rows = y[apart + Eigen::Index(i)];
}

double MotionFlow::distance(const Eigen::VectorXd& y, const State& state) {
  const int n = system_.nv;
  solved_ = false;  // q_ is scratch here
  from_local_coordinates(system_, q0_.data(), y.data(), q_.data());
  double most = 0;
  for (const CoordinateInfo& info : system_.coordinates) {
    const int i = info.v_index;
    // Rotations: half the angle is about the chord of the quaternions.
    const double moved =
        (state.q - q_).segment(info.q_index, info.q_size).norm() * (info.q_size == 4 ? 2 : 1);
    most = std::max(most, moved / scale_[i]);
    for (int k = n + i; k < n + i + info.v_size; ++k)
      most = std::max(most, std::abs(state.v[k - n] - y[k]) / scale_[k]);
  }
  return most;
}

Error MotionFlow::failure(double t) const {
  if (!fault_ && turned_ < 0)
    return {system_.scene,
            fmt::format("the iterations of a step did not converge at t = {:.6g} s; take a smaller tolerance",
                        t)};
  if (fault_) return describe(system_, fault_, t);
  for (const CoordinateInfo& info : system_.coordinates)
    if (info.v_index == turned_)
      return {
          fmt::format("coordinate '{}'", info.name),
          fmt::format("the ball turns by more than {:g} rad in one step at t = {:.6g} s; take smaller steps",
                      largest_turn, t)};
  return {};
}

std::string MotionFlow::component(int i) const {
  const int n = system_.nv;
  if (i >= 2 * n + 4 && i < 2 * n + 4 + system_.groups)
    return fmt::format("the work of drives and constraints on '{}' and the solids tied to it",
                       system_.group_name(i - 2 * n - 4));
  if (i < 0 || i >= 2 * n) return "the energy balance";
  std::string solid;
  for (const CoordinateInfo& info : system_.coordinates)
    if (i % n >= info.v_index && i % n < info.v_index + info.v_size) solid = info.solid;
  return fmt::format("{} '{}' of '{}'", i < n ? "coordinate" : "the velocity of",
                     system_.velocity_name(i % n), solid);
}

bool MotionFlow::find_unit_energies(const State& state) {
  fault_ = update_terms(system_, system_.parameters, state.t, state.q.data(), state.v.data(), w_);
  if (fault_) return false;
  unit_energy_.setZero(system_.groups);
  largest_energy_.setZero(system_.groups);
  for (int i = 0; i < system_.nv; ++i)
    unit_energy_[system_.velocity_groups[i]] += w_.terms.A(i, i) * std::pow(system_.velocity_scale[i], 2) / 2;
  return true;
}

/// Controlled work is measured against its group's kinetic energy, as velocities are against their own size.
/// The energy balance, which uses this work, is then as accurate as the motion.
void MotionFlow::set_work_scale() {
  for (std::size_t g = 0; g < counted_groups_.size(); ++g) {
    if (!counted_groups_[g]) continue;
    const auto i = Eigen::Index(g);
    largest_energy_[i] = std::max(largest_energy_[i], w_.terms.group_kinetic[i]);
    if (const double energy = unit_energy_[i] + largest_energy_[i]; energy > 0)
      scale_[2 * system_.nv + 4 + i] = energy;
  }
}

/// Scales: 1 rad for angles; the length of what the coordinate carries for lengths; for velocities these per
/// second plus their own size. Work is not controlled, except by set_work_scale().
void MotionFlow::set_scale(const State& state) {
  const int n = system_.nv;
  for (const CoordinateInfo& info : system_.coordinates)
    for (int i = info.v_index; i < info.v_index + info.v_size; ++i) {
      const double unit = system_.velocity_scale[i];
      scale_[i] = info.angle ? unit : std::max(unit, std::abs(state.q[info.q_index]));
      scale_[n + i] = unit + std::abs(state.v[i]);
    }
  scale_.tail(size() - 2 * n).setConstant(std::numeric_limits<double>::infinity());
}

}  // namespace borelli
