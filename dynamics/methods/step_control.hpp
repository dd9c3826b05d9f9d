// Chooses the next step from the error of this one. With beta > 0 the previous error also counts (PI
// control), which keeps the steps steady when stability rather than accuracy limits them (Hairer and Wanner,
// Solving ODEs II, section IV.2).
#pragma once

#include <algorithm>
#include <cmath>

namespace borelli {

class StepControl {
 public:
  struct Limits {
    double beta;          ///< weight of the previous error
    double shrink, grow;  ///< smallest and largest ratio of successive steps
    double safety = 0.9;
  };
  /// `order`: the error is proportional to h^order.
  StepControl(int order, const Limits& limits)
      : limits_(limits), exponent_(1.0 / order - 0.75 * limits.beta) {}

  /// The step after an accepted one of h; `error` in units of the tolerance.
  double after_accepted(double h, double error) {
    const double factor =
        limits_.safety * std::pow(before_, limits_.beta) / std::pow(std::max(error, 1e-10), exponent_);
    before_ = std::max(error, 1e-4);
    // A step that grows right after a rejection would be rejected again.
    const double grow = rejected_ ? 1 : limits_.grow;
    rejected_ = false;
    return h * std::clamp(factor, limits_.shrink, grow);
  }
  /// The step to try in place of a rejected one of h.
  double after_rejected(double h, double error) {
    rejected_ = true;
    return h * std::max(limits_.shrink, limits_.safety / std::pow(error, exponent_));
  }
  void reset() {
    before_ = 1e-4;
    rejected_ = false;
  }

  template <class Keeper>
  void keep(Keeper& k) {
    k(before_, rejected_);
  }

 private:
  Limits limits_;
  double exponent_;
  double before_ = 1e-4;
  bool rejected_ = false;
};

}  // namespace borelli
