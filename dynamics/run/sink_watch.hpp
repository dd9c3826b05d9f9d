// Detects adaptive runs that would not reach their end. Where a velocity grows without bound in finite time,
// the steps shrink towards zero (sinking). Where a force jumps to and fro, or where the motion is too fast
// for its duration (1e9 rad/s), more steps would be needed than a run may take (stalled).
#pragma once

#include <algorithm>
#include <limits>

namespace borelli {

class SinkWatch {
 public:
  enum class Verdict { fine, sinking, stalled };

  /// Call after each attempt at a step. `t`: the time reached, s; `step`: the next step proposed, s; `most`:
  /// the number of steps that a run may take.
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

  double longest() const { return longest_; }  ///< s: the longest step proposed
  double made() const { return made_; }        ///< s: the time that the last tried() attempts covered
  int tried() const { return tried_; }

  template <class Keeper>
  void keep(Keeper& k) {
    k(longest_, sunk_, tries_, tried_, windows_, window_start_, long_start_, made_);
  }

 private:
  static constexpr int window = 2000;  // tries
  static constexpr int many = 100;     // windows, that a dip of steps does not last over
  // A jump of a force is passed by a few steps of the tolerance's size, which grow again at once, a singular
  // position by more, down to 1e-10 of the longest; a motion that ends sends each step below the one before.
  static constexpr double deep = 1e-6, deepest = 1e-12;  // of the longest step
  static constexpr int steadily = 16;                    // accepted steps below `deep`, in a row
  static constexpr double hopeless = 10;  // so many times the most steps of a run are left after one

  double longest_ = 0;
  int sunk_ = 0, tries_ = 0, tried_ = 0, windows_ = 0;
  double window_start_ = 0, long_start_ = 0, made_ = 0;
};

}  // namespace borelli
