// The residuals r = A a + B - Q - L^T lambda and c = L a + E of the whole engine on dual numbers, ten
// directions at a time: slow, but independent of the derivatives' recursions.
#pragma once

#include "dynamics/equations/recursive.hpp"
#include "dynamics/numbers/dual.hpp"

namespace borelli::test {

class DualResiduals {
 public:
  DualResiduals(const System& system, const State& state, const Eigen::VectorXd& a,
                const Eigen::VectorXd& lambda)
      : system_(system),
        state_(state),
        a_(a.cast<DualNumber>()),
        lambda_(lambda),
        kinematics_(system, Equations::recursive),
        efforts_(system),
        recursion_(system),
        terms_(system, false),
        rows_(system) {
    for (const Inertial& given : system.parameters.inertials)
      inertials_.push_back({given.mass, given.centre.cast<DualNumber>(), given.tensor.cast<DualNumber>()});
    rest();
  }

  /// Derivatives of r and c by positions (or by velocities): nv columns in each.
  void differentiate(bool by_q, Eigen::MatrixXd& dr, Eigen::MatrixXd& dc) {
    dr.setZero(system_.nv, system_.nv);
    dc.setZero(system_.rows, system_.nv);
    for (int first = 0; first < system_.nv; first += width) {
      const int count = std::min(width, system_.nv - first);
      for (const CoordinateInfo& info : system_.coordinates)
        for (int i = 0; i < info.v_size; ++i)
          if (const int at = info.v_index + i - first; at >= 0 && at < count) {
            if (by_q)
              seed(info, i, at);
            else
              v_[info.v_index + i].d[std::size_t(at)] = 1;
          }
      update();
      for (int d = 0; d < count; ++d) {
        for (int i = 0; i < system_.nv; ++i) dr(i, first + d) = r_[i].d[std::size_t(d)];
        for (int i = 0; i < system_.rows; ++i) dc(i, first + d) = rows_.E[i].d[std::size_t(d)];
      }
      rest();
    }
  }

 private:
  using Numbers = Eigen::VectorX<DualNumber>;
  static constexpr int width = 10;

  void rest() {
    q_ = state_.q.cast<DualNumber>();
    v_ = state_.v.cast<DualNumber>();
  }

  /// Sets dual direction `at` to the i-th velocity of a coordinate.
  void seed(const CoordinateInfo& info, int i, int at) {
    if (info.q_size == 1) {
      q_[info.q_index].d[std::size_t(at)] = 1;
      return;
    }
    Quaternion turn = Quaternion::Zero();  // d exp(x) / dx_i at x = 0
    turn[1 + i] = 0.5;
    const Quaternion rate = product(state_.q.segment<4>(info.q_index), turn);
    for (int k = 0; k < 4; ++k) q_[info.q_index + k].d[std::size_t(at)] = rate[k];
  }

  void update() {
    const Parameters& p = system_.parameters;
    update_kinematics(system_, p, inertials_, state_.t, q_.data(), v_.data(), a_.data(), kinematics_);
    scan_efforts(system_, p, kinematics_, efforts_);
    find_own_forces(system_, p, inertials_, kinematics_, efforts_, recursion_, terms_);
    find_efforts(system_, p, kinematics_, efforts_, recursion_, terms_);
    scan_constraints(system_, p, kinematics_, rows_);  // E includes L a, because the kinematics were given a
    r_ = (terms_.B - terms_.Q).head(system_.nv);
    for (int row = 0; row < system_.rows; ++row)
      for (int i = 0; i < system_.nv; ++i) r_[i] -= lambda_[row] * rows_.L(row, i);
  }

  const System& system_;
  const State& state_;
  Numbers a_;
  Eigen::VectorXd lambda_;
  KinematicsOf<DualNumber> kinematics_;
  EffortSumsOf<DualNumber> efforts_;
  RecursionOf<DualNumber> recursion_;
  LagrangeTermsOf<DualNumber> terms_;
  ConstraintRowsOf<DualNumber> rows_;
  InertialsOf<DualNumber> inertials_;
  Numbers q_, v_, r_;
};

}  // namespace borelli::test
