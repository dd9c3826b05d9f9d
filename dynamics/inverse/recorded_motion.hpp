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
  /// Filters the positions (low_pass.hpp; `cutoff` in Hz, 0: no filter) and puts natural quintic splines
  /// through them. Each component of a ball's quaternion has its own spline; at() normalises the quaternion.
  /// Errors: positions that are not nq wide; those of low_pass and QuinticSpline.
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
