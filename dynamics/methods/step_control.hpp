// The next step from the error of this one. With beta > 0 the error before counts as well, which keeps the
// steps steady where stability rather than accuracy bounds them (PI control: Hairer and Wanner, Solving ODEs
// II, section IV.2).
#pragma once

#include <algorithm>
#include <cmath>

namespace borelli {

class StepControl {
 public:
  struct Limits {
    double beta;          ///< the share of the error before
    double shrink, grow;  ///< the least and largest factor from step to step
    double safety = 0.9;
  };
  /// `order`: the error goes as h^order.
  StepControl(int order, const Limits& limits)
      : limits_(limits), exponent_(1.0 / order - 0.75 * limits.beta) {}

  /// The step after an accepted one of h whose error was `error` of what is allowed.
  double after_accepted(double h, double error) {
    const double factor =
        limits_.safety * std::pow(before_, limits_.beta) / std::pow(std::max(error, 1e-10), exponent_);
    before_ = std::max(error, 1e-4);
    // growing again right after a rejection would only be rejected again
    const double grow = rejected_ ? 1 : limits_.grow;
    rejected_ = false;
    return h * std::clamp(factor, limits_.shrink, grow);
  }
  /// The step to try instead of one of h whose error was too large.
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
