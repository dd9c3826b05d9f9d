// The times at which adaptive steps end because of the tables of a scene. At a knot the third derivative of a
// spline jumps, which error estimates of higher order do not see. Steps also end halfway between knots: the
// work done is also evaluated between steps, and over a whole piece that would be coarse.
#pragma once

#include <vector>

#include "dynamics/system/system.hpp"

namespace borelli {

class Knots {
 public:
  /// Collects the knots of all functions of time of drives, efforts and constraints.
  Knots(const System& system, const Parameters& parameters);

  /// The first of these times after t, s; infinity: none.
  double after(double t) const;
  /// An upper bound of their number from `start` to `end`.
  double count(double start, double end) const;

 private:
  struct Places {
    std::vector<double> times;
    double period = 0;  ///< s, of repetition; 0: not periodic
  };
  std::vector<Places> tables_;
};

}  // namespace borelli
