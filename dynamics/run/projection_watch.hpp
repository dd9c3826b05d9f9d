// Tells when the projection on the constraints moves the end of a step so far that the estimate of its error
// does not hold.
#pragma once

#include <algorithm>
#include <limits>

namespace borelli {

class ProjectionWatch {
 public:
  /// A method whose estimate holds leaves the constraints by about its error: what more than so many
  /// tolerances are.
  static constexpr double limit = 10;

  explicit ProjectionWatch(double tolerance) : allowed_(std::max(limit * tolerance, 1e-9)) {}

  /// Whether the step of h from t, whose end was moved so far (on the coordinates' scales), is to be tried
  /// again, shorter (`shorter` of it). Not again where the shorter one was not moved far less: at a singular
  /// position no step is short enough (the certificate judges that).
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

  long count() const { return count_; }  ///< of the steps tried again

  template <class Keeper>
  void keep(Keeper& k) {
    k(time_, step_, moved_, count_);
  }

 private:
  static constexpr double worthwhile = 0.1;  // a method of first order falls to a sixteenth when quartered
  double allowed_;
  double time_ = std::numeric_limits<double>::quiet_NaN();  ///< s: of the step last looked at, its length and
  double step_ = 0, moved_ = 0;                             ///< how far its end was moved
  long count_ = 0;
};

}  // namespace borelli
