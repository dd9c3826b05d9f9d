// The times at which adaptive steps end for the sake of a scene's tables: where the pieces of a spline meet,
// since its third derivative jumps there, which the estimates of errors of higher order do not see; and
// halfway between, since the work done is read between steps, too, and of a whole piece that would be coarse.
#pragma once

#include <vector>

#include "dynamics/system/system.hpp"

namespace borelli {

class Knots {
 public:
  /// Of all functions of time of drives, efforts and constraints.
  Knots(const System& system, const Parameters& parameters);

  /// The first of them after time t, s; infinity: none.
  double after(double t) const;
  /// At most so many from `start` to `end`.
  double count(double start, double end) const;

 private:
  struct Places {
    std::vector<double> times;
    double period = 0;  ///< s, after which they come again; 0: they do not
  };
  std::vector<Places> tables_;
};

}  // namespace borelli
