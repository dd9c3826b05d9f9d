// Detects adaptive runs that will not reach their end. Sinking: a velocity grows without bound in finite time
// and the steps shrink towards zero. Stalled: a force chatters, or the motion is too fast for its duration
// (1e9 rad/s), so the run would need more steps than allowed.
#pragma once

#include <algorithm>
#include <limits>

namespace borelli {

class SinkWatch {
 public:
  enum class Verdict { fine, sinking, stalled };

  /// Call after each attempted step. `t`: time reached, s; `step`: next step proposed, s; `end`: end time, s;
  /// `most`: largest number of steps of a run.
  Verdict after(double t, double step, bool accepted, double end, double most) {
    if (tries_++ == 0) window_start_ = t;
    longest_ = std::max(longest_, accepted ? step : 0);
    sunk_ = step > deep * longest_ ? 0 : sunk_ + accepted;
    if (sunk_ >= steadily && step < deepest * longest_) return Verdict::sinking;
    if (tries_ <= window) return Verdict::fine;
    tries_ = 0;
    tried_ = window;
    made_ = t - window_start_;
    if ((end - t) * window > hopeless * most * made_) return Verdict::stalled;
    if (windows_++ == 0) long_start_ = window_start_;
    if (windows_ < many) return Verdict::fine;
    windows_ = 0;
    tried_ = many * window;
    made_ = t - long_start_;
    return (end - t) * tried_ > most * made_ ? Verdict::stalled : Verdict::fine;
  }

  double longest() const { return longest_; }  ///< s, longest step proposed
  double made() const { return made_; }        ///< s, time covered by the last tried() attempts
  int tried() const { return tried_; }

  template <class Keeper>
  void keep(Keeper& k) {
    k(longest_, sunk_, tries_, tried_, windows_, window_start_, long_start_, made_);
  }

 private:
  static constexpr int window = 2000;  // attempts
  static constexpr int many = 100;     // windows; longer than a temporary dip of the steps
  // At a jump of a force the steps dip to the tolerance's size for a few steps and grow again at once. A
  // singular position takes more steps, down to 1e-10 of the longest. A motion that ends in finite time
  // shrinks every step below the previous one.
  static constexpr double deep = 1e-6, deepest = 1e-12;  // relative to the longest step
  static constexpr int steadily = 16;                    // accepted steps below `deep` in a row
  // Give up after one window if the rest needs this multiple of the largest number of steps.
  static constexpr double hopeless = 10;

  double longest_ = 0;
  int sunk_ = 0, tries_ = 0, tried_ = 0, windows_ = 0;
  double window_start_ = 0, long_start_ = 0, made_ = 0;
};

}  // namespace borelli
