// Joint angles of normal level walking, and smooth periodic functions of the gait cycle.
#pragma once

#include <Eigen/Core>

namespace borelli {

/// Sagittal angles of one leg, rad. Zero: standing upright.
struct LegAngles {
  double hip = 0;    ///< flexion of the thigh from the vertical
  double knee = 0;   ///< flexion
  double ankle = 0;  ///< dorsiflexion

  /// Of the foot from the floor, toes up.
  double foot_pitch() const { return hip - knee + ankle; }
};

/// Angles at a phase of the gait cycle (1: a whole cycle, from one heel strike to the next of the same foot).
///
/// A rounded sketch of healthy adults' walking, one value every 5 % of the cycle, smoothed by seven
/// harmonics. Its shape is that of Perry and Burnfield, Gait Analysis (2nd ed., 2010); its numbers are not
/// from a table there. It is no reference for normal gait.
LegAngles leg_angles(double phase);

/// Share of the cycle for which a foot stands (Perry and Burnfield 2010: 62 %).
inline constexpr double stance_share = 0.62;

/// Rises from 0 at x = 0 to 1 at x = 1, with two continuous derivatives: 6 x^5 - 15 x^4 + 10 x^3.
double smooth_step(double x);

/// A truncated Fourier series per column, through samples at equal phases.
class PeriodicSeries {
 public:
  /// `samples`: #phases by #columns, phases 0, 1/#phases, ... Needs #phases > 2 harmonics.
  PeriodicSeries(const Eigen::MatrixXd& samples, int harmonics);
  Eigen::VectorXd at(double phase) const;

  Eigen::MatrixXd cosines, sines;  ///< #harmonics + 1 by #columns
};

}  // namespace borelli
