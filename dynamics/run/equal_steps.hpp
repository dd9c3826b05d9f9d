// Fixed steps: divides the time to a target into equal steps, and a step that is too long into halves.
//
// A method that treats contacts within its steps may need shorter ones for a while. A part that is too long
// is halved. After some parts of one length, a part of twice that length is tried.
#pragma once

#include "dynamics/numbers/keeper.hpp"
#include "dynamics/scene/settings.hpp"

namespace borelli {

class EqualSteps {
 public:
  /// A step or a part of it: its length and its end, s.
  struct Part {
    double h, end;
  };

  /// Begins the fewest equal steps from time `from` to `target` (s) of at most `step` (s) each.
  void begin(double from, double target, double step);
  /// Whether no step is left (before begin() too).
  bool done() const { return number_ == 0; }
  double target() const { return target_; }  ///< s

  double step_end() const;               ///< end of the present step, s
  Part part_from(double t) const;        ///< the part of the present step to make next, from time t (s)
  bool divisible(double h) const;        ///< whether a part of h (s) may be divided
  void divide(double h);                 ///< a part of h (s) was too long: halve it
  void lengthen();                       ///< a part was short enough: now and then double it
  void count_vain() { ++vain_; }         ///< a shortest part was still too long
  void cut_short() { whole_ = false; }   ///< an event has ended a part early
  bool whole() const { return whole_; }  ///< no event has ended a part of the present step early
  void go_on();                          ///< goes on to the next step

  /// Saves or restores the progress of a run from time `start` (s) with these settings.
  void keep(Keeper& k, double start, const SimulationSettings& settings);

 private:
  double whole_step() const { return (target_ - from_) / double(count_); }

  double from_ = 0, target_ = 0;
  long count_ = 0, number_ = 0;  ///< number of steps; the present one, from 1 (0: none)
  bool whole_ = true;
  double part_ = 1;  ///< longest part to try, a power of 1/2 of the step
  int made_ = 0;     ///< successive parts of that length
  int patience_ =
      1;  ///< a longer part is tried after this many; doubled after each failed try, halved after each success
  bool longer_ = false;  ///< the next part is such a try
  int vain_ = 0;         ///< number of shortest parts of this step that were too long
};

}  // namespace borelli
