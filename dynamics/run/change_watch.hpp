// Whether steps resolve the scene's fastest change in time.
#pragma once

#include <limits>

#include "dynamics/run/certifier.hpp"
#include "dynamics/system/fastest_change.hpp"

namespace borelli {

class ChangeWatch {
 public:
  /// `span`: the run's length, s. `tables`: as for fastest_change().
  ChangeWatch(const System& system, const Parameters& parameters, double span, bool tables);

  /// `step`, or `share` of the longest step that resolves the change if that is shorter, s.
  double bounded(double step, double share = 1);
  /// Takes note of an accepted step of `made` from time `from`, s.
  void take_step(double from, double made);
  /// Notes that steps were bounded. Distrusts the run if they were too long.
  void judge(Certifier& certifier) const;

  void keep(Keeper& k) { k(longest_made_, first_overlong_, limited_); }

 private:
  FastestChange change_;
  double longest_ = std::numeric_limits<double>::infinity();  ///< s, longest step that resolves the change
  double longest_made_ = 0;                                   ///< s, longest accepted step
  double first_overlong_ = 0;                                 ///< s, start of the first step above longest_
  bool limited_ = false;                                      ///< a step was cut to longest_
};

}  // namespace borelli
