// Detects fixed steps that are too long for the motion. Example: a step that samples every swing at the same
// phase balances the energy but is wrong.
//
// Three tests. First, the change of the accelerations over a step estimates the phase angle b per step,
//   b^2 = h |a1 - a0| / |v|.
// Gauss methods of order 2, 4, 6 miss the fractions b^2 / 12, b^4 / 720, b^6 / 100800 of it; other methods of
// these orders miss no less. Second, the end of a step is compared with Hermite's quadrature of the rates at
// both ends,
//     x1 = x0 + h (v0 + v1) / 2 - h^2 (a1 - a0) / 12 + O(h^5)
// (for a ball the rotation vector of the Magnus expansion, with the additional term h^2 (w0 x w1) / 12:
// Iserles et al., Lie-group methods, Acta Numerica 2000, section 4). It shows errors of any origin for
// methods of lower order.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dynamics/system/system.hpp"

namespace borelli {

class StepWatch {
 public:
  /// Largest trusted fraction of a step that is missed: with order 2, that of eight steps per swing, (pi /
  /// 4)^2 / 12.
  static constexpr double limit = 0.05;

  explicit StepWatch(const System& system);

  /// A state between the last observed one and `state`, if the step between them turns a coordinate by more
  /// than half a turn.
  std::optional<State> within_turn(const State& state) const;

  /// Observes a state with accelerations `a` (nv). `joined`: exactly one step without velocity jumps leads
  /// from the previous state to this one. `within`: the accelerations (nv) at the state that
  /// within_turn(state) gives; null if it gives none.
  void observe(const State& state, const Eigen::VectorXd& a, bool joined,
               const Eigen::VectorXd* within = nullptr);

  /// The worst step of a method of this order: the missed fraction of the step at the coordinate's largest
  /// speed in the run.
  struct Finding {
    double part = 0;
    double time = 0, step = 0;  ///< s: end and length of the step
    int coordinate = -1;        ///< index in System::coordinates; -1: none
  };
  Finding worst(int order) const;

  /// The reason for distrust, for a finding above the limit.
  std::string reason(const Finding& finding) const;

  template <class Keeper>
  void keep(Keeper& k) {
    k(started_, t_, q_, v_, a_, coordinates_);
  }

 private:
  /// The maximum of a quantity over the steps; in the coordinate's scale per second.
  struct Largest {
    double size = 0;
    double time = 0, step = 0;  ///< s: end and length of the step
    void take(double now, double t, double h);
    template <class Keeper>
    void keep(Keeper& k) {
      k(size, time, step);
    }
  };
  /// Per coordinate.
  struct Followed {
    double fastest = 0;  ///< largest speed
    Largest defect;      ///< step minus quadrature, over the step's length
    Largest change;      ///< change of the acceleration over a step, times the step's length
    Largest unseen;      ///< difference of the acceleration within a step to the nearer end, times the length
    double all_unseen = 0;  ///< sum of that over the steps
    template <class Keeper>
    void keep(Keeper& k) {
      k(fastest, defect, change, unseen, all_unseen);
    }
  };
  double defect(const CoordinateInfo& info, const State& state, const Eigen::VectorXd& a, double h) const;

  const System& system_;
  bool started_ = false;
  double t_ = 0;  ///< time of the last observed state, s
  Eigen::VectorXd q_, v_, a_;
  std::vector<Followed> coordinates_;
};

}  // namespace borelli
