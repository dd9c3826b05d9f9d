// When a run's rows of output are due.
#pragma once

#include <algorithm>
#include <cmath>

#include "dynamics/numbers/keeper.hpp"
#include "dynamics/scene/settings.hpp"

namespace borelli {

/// Rows at equal intervals after the start, the last one at the end. If the interval is 0, every step makes a
/// row, and only the end is due.
class OutputTimes {
 public:
  /// A run from time `start`, s.
  OutputTimes(double start, const SimulationSettings& s)
      : start_(start),
        interval_(s.output_interval),
        end_(s.end_time),
        count_(interval_ > 0 ? std::max(1L, long(std::ceil((end_ - start) / interval_ - 1e-9))) : 1) {}

  long count() const { return count_; }
  bool done() const { return next_ > count_; }
  bool at_last() const { return next_ >= count_; }
  /// Time of the next row, s.
  double next_time() const { return next_ == count_ ? end_ : start_ + double(next_) * interval_; }
  void go_on() { ++next_; }

  void keep(Keeper& k) { k.within(next_, 1L, count_ + 1); }

 private:
  double start_, interval_, end_;
  long count_, next_ = 1;  ///< number of rows after the first; the next one, from 1
};

}  // namespace borelli
