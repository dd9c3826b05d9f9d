// Eight motions of one System, one per lane of a batch (batch.hpp), as one differential equation for the
// methods of integrator.hpp.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "dynamics/constraints/local_coordinates.hpp"
#include "dynamics/equations/batch.hpp"
#include "dynamics/equations/evaluate.hpp"
#include "dynamics/methods/integrator.hpp"

namespace borelli {

/// y holds local coordinates, velocities and the work on each independent group, number by number and, within
/// each, lane by lane.
class BatchFlow : public Flow {
 public:
  static constexpr int lanes = Lanes::count;

  /// `controlled`: per group, whether the method controls the error of its work (see MotionFlow); empty: no
  /// group. If any is set, the workspace must have room for mass matrices.
  BatchFlow(const System& system, BatchWorkspace& workspace, const std::vector<char>& controlled)
      : system_(system),
        w_(workspace),
        controlled_(controlled),
        unit_energy_(controlled_.size(), Lanes(0)),
        largest_energy_(unit_energy_),
        state_(system),
        centre_(state_.q),
        x_(system.nv),
        rate_(system.nv),
        own_efforts_(Eigen::VectorX<Lanes>::Zero(system.nv)),
        scale_(size()) {
    scale_.setConstant(std::numeric_limits<double>::infinity());
  }

  Eigen::Index size() const override { return lanes * (2 * system_.nv + system_.groups); }
  const Eigen::VectorXd& error_scale() const override { return scale_; }
  Eigen::Index positions() const override { return lanes * system_.nv; }
  void position_rate(const Eigen::VectorXd& y, Eigen::VectorXd& dy) override {
    load(y);
    local_rate(system_, x_.data(), state_.v.data(), rate_.data());
    for (int i = 0; i < system_.nv; ++i) rate_[i].store(dy.data() + lanes * i);
  }
  /// y holds eight states of each motion; the rates are found motion by motion.
  void position_rates(const Eigen::VectorX<Lanes>& y, Eigen::VectorX<Lanes>& dy) override {
    const int n = system_.nv;
    solved_ = false;
    for (int motion = 0; motion < lanes; ++motion) {
      for (int i = 0; i < n; ++i) {
        x_[i] = y[lanes * i + motion];
        state_.v[i] = y[lanes * (n + i) + motion];
      }
      local_rate(system_, x_.data(), state_.v.data(), rate_.data());
      for (int i = 0; i < n; ++i) dy[lanes * i + motion] = rate_[i];
    }
  }

  /// Centres the local coordinates on `state`. Solves the equations there unless the last solution is for
  /// this state. Fills dy, and y except for the works. Returns false if the equations of some lane cannot be
  /// solved.
  bool start(const BatchState& state, Eigen::VectorXd& y, Eigen::VectorXd& dy) {
    centre_ = state.q;
    for (int i = 0; i < system_.nv; ++i) {
      Lanes(0).store(y.data() + lanes * i);
      state.v[i].store(y.data() + lanes * (system_.nv + i));
    }
    set_scale(state);
    if (!solved_ || state.t != state_.t || !same(state.q, state_.q) || !same(state.v, state_.v))
      return derivative(state.t, y, dy);
    x_.setZero();
    fill(dy);
    return true;
  }

  bool derivative(double t, const Eigen::VectorXd& y, Eigen::VectorXd& dy) override {
    const int n = system_.nv;
    load(y);
    if (turned_too_far()) return false;
    from_local_coordinates(system_, centre_.data(), x_.data(), state_.q.data());
    state_.t = t;
    if (!accelerate(system_, system_.parameters, state_, w_, has_own_efforts_ ? own_efforts_.data() : nullptr,
                    Wanted::accelerations)) {
      for (int lane = 0; lane < lanes; ++lane) failed_[lane] = bool(w_.faults[lane]);
      return false;
    }
    if (has_own_efforts_)
      for (int i = 0; i < n; ++i) w_.group_power[system_.velocity_groups[i]] += own_efforts_[i] * state_.v[i];
    fill(dy);
    return solved_ = true;
  }

  /// Sets positions and velocities of `state` from y.
  void take(const Eigen::VectorXd& y, BatchState& state) {
    for (int i = 0; i < system_.nv; ++i) {
      x_[i] = Lanes::load(y.data() + lanes * i);
      state.v[i] = Lanes::load(y.data() + lanes * (system_.nv + i));
    }
    from_local_coordinates(system_, centre_.data(), x_.data(), state.q.data());
  }

  /// Prepares for new motions with the inertial elements in the workspace; clears the own efforts of each lane.
  void begin(const BatchState& state) {
    solved_ = has_own_efforts_ = false;
    own_efforts_.setZero();
    if (controlled_.empty()) return;
    find_mass_matrix(system_, system_.parameters, state, w_);
    std::fill(largest_energy_.begin(), largest_energy_.end(), Lanes(0));
    unit_energy_ = largest_energy_;
    for (int i = 0; i < system_.nv; ++i)
      unit_energy_[system_.velocity_groups[i]] +=
          w_.terms.A(i, i) * (0.5 * system_.velocity_scale[i] * system_.velocity_scale[i]);
    scale_.tail(lanes * system_.groups).setConstant(std::numeric_limits<double>::infinity());
  }

  /// As in MotionFlow. Call after find_energies.
  void set_work_scale() {
    for (std::size_t g = 0; g < controlled_.size(); ++g) {
      if (!controlled_[g]) continue;
      const Lanes kinetic = w_.terms.group_kinetic[Eigen::Index(g)];
      largest_energy_[g] = choose(largest_energy_[g] < kinetic, kinetic, largest_energy_[g]);
      const Lanes energy = unit_energy_[g] + largest_energy_[g];
      for (int lane = 0; lane < lanes; ++lane)
        if (energy[lane] > 0) scale_[lanes * (2 * system_.nv + Eigen::Index(g)) + lane] = energy[lane];
    }
  }

  /// From now on the lane holds constant generalised efforts (nv, or empty: none).
  void hold(int lane, const Eigen::VectorXd& efforts) {
    for (Eigen::Index i = 0; i < efforts.size(); ++i) own_efforts_[i].set(lane, efforts[i]);
    has_own_efforts_ = has_own_efforts_ || efforts.size() > 0;
  }
  /// The lane continues as a copy of lane `other`.
  void copy_lane(int lane, int other) {
    for (Lanes& effort : own_efforts_) effort.set(lane, effort[other]);
    for (auto* energies : {&unit_energy_, &largest_energy_})
      for (Lanes& energy : *energies) energy.set(lane, energy[other]);
  }

  /// The lanes whose last derivative could not be evaluated.
  const std::array<bool, lanes>& failed() const { return failed_; }

 private:
  // Local coordinates become singular when a ball has turned by 2 pi from their centre.
  static constexpr double largest_turn = 5;  // rad

  static bool same(const Eigen::VectorX<Lanes>& a, const Eigen::VectorX<Lanes>& b) {
    for (Eigen::Index i = 0; i < a.size(); ++i)
      if (!everywhere(a[i] == b[i])) return false;
    return true;
  }

  /// Loads x_ and the velocities of state_ from y.
  void load(const Eigen::VectorXd& y) {
    solved_ = false;
    for (int i = 0; i < system_.nv; ++i) {
      x_[i] = Lanes::load(y.data() + lanes * i);
      state_.v[i] = Lanes::load(y.data() + lanes * (system_.nv + i));
    }
  }

  /// Fills dy from the last solution of the equations.
  void fill(Eigen::VectorXd& dy) {
    const int n = system_.nv;
    dy.resize(size());
    local_rate(system_, x_.data(), state_.v.data(), rate_.data());
    for (int i = 0; i < n; ++i) {
      rate_[i].store(dy.data() + lanes * i);
      w_.a[i].store(dy.data() + lanes * (n + i));
    }
    for (int g = 0; g < system_.groups; ++g) w_.group_power[g].store(dy.data() + lanes * (2 * n + g));
  }

  bool turned_too_far() {
    failed_.fill(false);
    bool any = false;
    for (const CoordinateInfo& info : system_.coordinates) {
      if (info.q_size != 4) continue;
      const Lanes::Mask far = x_.segment<3>(info.v_index).squaredNorm() > largest_turn * largest_turn;
      if (!far.any()) continue;
      any = true;
      for (int lane = 0; lane < lanes; ++lane) failed_[lane] = failed_[lane] || far[lane];
    }
    return any;
  }

  /// As in MotionFlow.
  void set_scale(const BatchState& state) {
    const int n = system_.nv;
    for (const CoordinateInfo& info : system_.coordinates)
      for (int i = info.v_index; i < info.v_index + info.v_size; ++i) {
        const double unit = system_.velocity_scale[i];
        for (int lane = 0; lane < lanes; ++lane) {
          scale_[lanes * i + lane] =
              info.angle ? unit : std::max(unit, std::abs(state.q[info.q_index][lane]));
          scale_[lanes * (n + i) + lane] = unit + std::abs(state.v[i][lane]);
        }
      }
  }

  const System& system_;
  BatchWorkspace& w_;
  const std::vector<char>& controlled_;
  /// Per group, J (see MotionFlow); sized only if some group's work is controlled.
  std::vector<Lanes> unit_energy_, largest_energy_;
  BatchState state_;
  Eigen::VectorX<Lanes> centre_, x_, rate_;
  Eigen::VectorX<Lanes> own_efforts_;  ///< generalised efforts per velocity; used if has_own_efforts_
  bool has_own_efforts_ = false;
  Eigen::VectorXd scale_;
  std::array<bool, lanes> failed_{};
  bool solved_ = false;  ///< the workspace holds the solution at state_
};

}  // namespace borelli
