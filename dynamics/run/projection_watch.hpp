// Detects steps whose end the projection moves so far that the error estimate is not valid.
#pragma once

#include <algorithm>
#include <limits>

namespace borelli {

class ProjectionWatch {
 public:
  /// Largest move, in tolerances. A method with a valid estimate leaves the constraints by about its error.
  static constexpr double limit = 10;

  explicit ProjectionWatch(double tolerance) : allowed_(std::max(limit * tolerance, 1e-9)) {}

  /// Whether to repeat the step of h from t with a step of `shorter` times its length. `moved`: how far the
  /// projection moved its end, in the coordinates' scales. Stops repeating if the shorter step was not moved
  /// much less: at a singular position no step is short enough (the certificate judges that).
  bool again(double t, double h, double moved) {
    const bool first = t != time_ || h >= step_;
    const bool again = moved > allowed_ && (first || moved < worthwhile * moved_);
    time_ = t;
    step_ = h;
    moved_ = moved;
    count_ += again;
    return again;
  }
  static constexpr double shorter = 0.25;

  long count() const { return count_; }  ///< number of repeated steps

  template <class Keeper>
  void keep(Keeper& k) {
    k(time_, step_, moved_, count_);
  }

 private:
  static constexpr double worthwhile = 0.1;  // a first-order method gains a factor of 16 per quartering
  double allowed_;
  /// s, start of the step last checked
  double time_ = std::numeric_limits<double>::quiet_NaN();
  double step_ = 0, moved_ = 0;  ///< its length, s, and the move of its end
  long count_ = 0;
};

}  // namespace borelli
