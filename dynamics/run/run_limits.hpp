// Limits of one run. simulate.hpp offers them; accuracy.hpp sets them run by run.
#pragma once

#include <limits>

namespace borelli {

/// Conditions for ending a run early, and how it starts.
struct RunLimits {
  /// Leave if the scene is stiff (Certificate::stiff_from) and the rest at the present step needs more than
  /// 1.5 times the steps tried so far.
  bool leave_if_stiff = false;
  double evaluations = std::numeric_limits<double>::infinity();  ///< leave after this many evaluations
  /// Use the method's own first step if it has one (Integrator::first_step), not settings.step.
  bool own_first_step = false;
  /// Disturb the velocities by this fraction of their scales (disturbance.hpp): at the start, and a few times
  /// on the way if work is done on the scene and the method keeps no history.
  double disturbance = 0;
  /// Steps take at most this share of the longest step that functions of time allow. If it is below 1, they
  /// also take at most this share of half the time between two knots.
  double step_share = 1;
};

}  // namespace borelli
