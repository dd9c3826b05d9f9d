// Convergence test of an iteration, by the sizes of its corrections.
#pragma once

#include <cmath>
#include <limits>

namespace borelli {

class Settling {
 public:
  enum class Verdict { go_on, settled, slow, failed };

  /// Judges a correction of this size, relative to the scale of the unknowns.
  /// - Settled: at rounding level, or near it and no longer halving.
  /// - Slow: shrinks by less than half, so many more iterations would be needed.
  /// - Failed: not finite, or too many corrections.
  Verdict after(double correction) {
    const double before = last_;
    last_ = correction;
    ++count_;
    if (!std::isfinite(correction) || count_ > most) return Verdict::failed;
    if (correction <= rounding || (correction <= near_rounding && correction >= 0.5 * before))
      return Verdict::settled;
    return count_ > 2 && correction > 0.5 * before ? Verdict::slow : Verdict::go_on;
  }

 private:
  static constexpr double rounding = 1e-15, near_rounding = 1e-11;
  static constexpr int most = 50;
  double last_ = std::numeric_limits<double>::infinity();
  int count_ = 0;
};

}  // namespace borelli
