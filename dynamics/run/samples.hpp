// What a run is compared by with other runs of the same motion.
#pragma once

#include <limits>
#include <vector>

#include "dynamics/system/system.hpp"

namespace borelli {

/// States of a run at the times at which runs are compared.
struct Samples {
  std::vector<double> times;          ///< s, ascending, after the start
  std::vector<Eigen::VectorXd> q, v;  ///< one per time that the run reached
  /// Minimum and maximum of each component of q and v over the start and all steps. They show motion that the
  /// sampling times alias.
  Eigen::VectorXd q_low, q_high, v_low, v_high;
  long evaluations = 0;  ///< of the run, also if it failed
  long steps = 0;        ///< accepted ones of an adaptive method
  long cut_steps = 0;    ///< of these, shorter than the tolerance asks, for functions of time and their knots

  double cut_part() const { return steps > 0 ? double(cut_steps) / double(steps) : 0; }

  /// The next time at which a state is wanted, s; infinite after the last.
  double next() const {
    return q.size() == times.size() ? std::numeric_limits<double>::infinity() : times[q.size()];
  }
  /// Takes a state if its time is the next one.
  void take(const State& state) {
    if (next() != state.t) return;
    q.push_back(state.q);
    v.push_back(state.v);
    cover(state);
  }
  /// Widens the minima and maxima to a state.
  void cover(const State& state) {
    if (q_low.size() == 0) {
      q_low = q_high = state.q;
      v_low = v_high = state.v;
    }
    q_low = q_low.cwiseMin(state.q), q_high = q_high.cwiseMax(state.q);
    v_low = v_low.cwiseMin(state.v), v_high = v_high.cwiseMax(state.v);
  }
};

}  // namespace borelli
