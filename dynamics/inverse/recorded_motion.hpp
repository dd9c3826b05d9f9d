// A recorded motion as smooth functions of time: positions, velocities and accelerations of a system's free
// coordinates, for inverse dynamics and replay.
#pragma once

#include <vector>

#include "dynamics/inverse/quintic_spline.hpp"
#include "dynamics/system/system.hpp"

namespace borelli {

/// Positions of the free coordinates at instants.
struct RecordedPositions {
  std::vector<double> times;  ///< s, increasing
  Rows q;                     ///< #times by nq
};

class RecordedMotion {
 public:
  /// Quintic splines through the positions, after a low-pass filter at `cutoff` (Hz; 0: none; low_pass.hpp).
  /// The four numbers of a ball's quaternion are filtered and interpolated one by one and scaled to unit
  /// length where they are read. Errors: as those of low_pass and QuinticSpline, and positions that do not
  /// fit the system.
  static Result<RecordedMotion> of(const System& system, const RecordedPositions& positions, double cutoff);

  /// The state at t, and the accelerations a (nv). A ball's velocities are those of its own axes.
  void at(double t, State& state, Eigen::VectorXd& a) const;

  double start() const { return start_; }  ///< s, of the positions given
  double end() const { return end_; }

 private:
  RecordedMotion(const System& system, QuinticSpline spline) : system_(&system), spline_(std::move(spline)) {}
  const System* system_;
  QuinticSpline spline_;
  double start_ = 0, end_ = 0;
};

}  // namespace borelli
