// Tells when steps of one length do not follow the motion that they make: a swing of which every step sees
// one place alike balances its energy and is wrong all the same.
//
// Two things are looked at. How the accelerations change over a step says how far it swings: by the angle b,
// b^2 = h |a1 - a0| / |v|, of which Gauss' methods of order 2, 4, 6 miss the parts b^2 / 12, b^4 / 720, b^6 /
// 100800, and no method of those orders much less. And what a step came to is compared with what the rates at
// both its ends say, by Hermite's quadrature
//     x1 = x0 + h (v0 + v1) / 2 - h^2 (a1 - a0) / 12 + O(h^5)
// (for a ball the rotation vector of Magnus' expansion, with h^2 (w0 x w1) / 12 more: Iserles et al.,
// Lie-group methods, Acta Numerica 2000, section 4), which shows the errors of methods below its order,
// however they come about.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dynamics/system/system.hpp"

namespace borelli {

class StepWatch {
 public:
  /// The largest part of a step that may be missed: what eight steps to a swing leave with a method of order
  /// 2, (pi / 4)^2 / 12.
  static constexpr double limit = 0.05;

  explicit StepWatch(const System& system);

  /// Looks at a state whose accelerations are `a` (nv). `joined`: one step lies between it and the state
  /// before; false: none does, or something in it that changed velocities.
  void observe(const State& state, const Eigen::VectorXd& a, bool joined);

  /// The worst step of a method of that order: what part of it was missed, its length taken at the
  /// coordinate's largest speed of the run.
  struct Finding {
    double part = 0;
    double time = 0, step = 0;  ///< s: its end, its length
    int coordinate = -1;        ///< in System::coordinates
  };
  Finding worst(int order) const;

  /// Why the run is not to be trusted, of a finding above the limit.
  std::string reason(const Finding& finding) const;

  template <class Keeper>
  void keep(Keeper& k) {
    k(started_, t_, q_, v_, a_, coordinates_);
  }

 private:
  /// The largest that something was over the run's steps: coordinates' scales per second.
  struct Largest {
    double size = 0;
    double time = 0, step = 0;  ///< s: the end of the step, its length
    void take(double now, double t, double h);
    template <class Keeper>
    void keep(Keeper& k) {
      k(size, time, step);
    }
  };
  /// Of one coordinate.
  struct Followed {
    double fastest = 0;  ///< its largest speed
    Largest defect;      ///< of a step from the quadrature, over its length
    Largest change;      ///< of its speed's rate over a step, times its length
    template <class Keeper>
    void keep(Keeper& k) {
      k(fastest, defect, change);
    }
  };
  double defect(const CoordinateInfo& info, const State& state, const Eigen::VectorXd& a, double h) const;

  const System& system_;
  bool started_ = false;
  double t_ = 0;  ///< the state last looked at
  Eigen::VectorXd q_, v_, a_;
  std::vector<Followed> coordinates_;
};

}  // namespace borelli
