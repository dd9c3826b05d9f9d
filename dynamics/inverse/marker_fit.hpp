// Inverse kinematics: the positions of a system that bring points of its solids nearest to measured markers,
// by weighted least squares over all markers and coordinates at once (Lu and O'Connor, Bone position
// estimation from skin marker co-ordinates using global optimisation with joint constraints, Journal of
// Biomechanics 32, 1999).
//
// The goal is that of OpenSim's inverse kinematics (Simbody's Markers and QValue conditions):
//   sum_m w_m |x_m(q) - y_m|^2 / (2 sum_m w_m) + sum_c w_c (q_c - g_c)^2 / 2,
// over the markers that were seen in the frame. Newton's method with Levenberg and Marquardt's damping
// minimises it: the normal matrix J^T W J of points with weights w is the mass matrix of points with masses
// w, so that sums over the branches of the tree give it, as in the composite rigid body algorithm
// (Featherstone, Rigid Body Dynamics Algorithms, 2008, chapter 6). Such sums also give the second
// derivatives.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "dynamics/scene/site.hpp"
#include "dynamics/system/system.hpp"
#include "error/error.hpp"

namespace borelli {

/// A point of a solid that follows a measured marker.
struct FollowedMarker {
  std::string name;   ///< of the marker, for messages
  SolidPoint at;      ///< where the model has it
  double weight = 1;  ///< relative to the other markers; 0: only its error is computed
};

/// A free scalar coordinate that is drawn towards a value.
struct FollowedCoordinate {
  std::string coordinate;
  double weight = 1;  ///< 1/rad^2 or 1/m^2, beside markers whose weighted mean square is taken in m^2
};

struct MarkerFitSettings {
  /// The fit ends when a step changes no coordinate by more than this, in rad, or in m over the scene's
  /// length.
  double tolerance = 1e-8;
  int most_iterations = 100;
  bool within_ranges = true;  ///< keep coordinates in the ranges of System::ranges
  /// Per free velocity component (nv; empty: none): draws rotations towards the scene's initial positions, so
  /// that what markers do not tell stays near them. m^2/rad^2, beside markers whose weighted mean square is
  /// taken; for other coordinates than rotations it is not used.
  Eigen::VectorXd rest_weights = {};
};

/// One fitted frame.
struct MarkerFrame {
  Eigen::Matrix3Xd model;  ///< m, world: the model's markers
  Eigen::VectorXd errors;  ///< m, their distances from the measured ones; NaN: not seen
  double rms = 0;          ///< m, root mean square of the errors of markers with a weight, unweighted
  int worst = -1;          ///< the marker with the largest error, of those with a weight; -1: none was seen
  int seen = 0;            ///< number of markers with a weight that were seen
  int iterations = 0;
  bool converged = false;
  std::vector<int> at_range;  ///< free velocity components held at an end of their range
};

/// Fits frame after frame. Sized once for a system, markers and coordinates.
class MarkerFit {
 public:
  /// Errors: a solid or coordinate that the system does not have, a weight that is negative or not finite, no
  /// marker with a weight and no coordinate task.
  static Result<MarkerFit> create(const System& system, std::vector<FollowedMarker> markers,
                                  std::vector<FollowedCoordinate> coordinates,
                                  const MarkerFitSettings& settings = {});

  MarkerFit(MarkerFit&&) noexcept;
  MarkerFit& operator=(MarkerFit&&) noexcept;
  ~MarkerFit();

  /// Moves q (nq), from its values on, to the best fit at time t. `measured` (3 x #markers): m, world; a
  /// column that is not finite was not seen. `values` (#coordinates): rad or m. Bilateral constraints hold at
  /// the result. Fails if they cannot be reached. A frame that does not converge says so in `converged`.
  Result<MarkerFrame> fit(double t, const Eigen::Matrix3Xd& measured, const Eigen::VectorXd& values,
                          Eigen::VectorXd& q);

  const std::vector<FollowedMarker>& markers() const;
  const std::vector<FollowedCoordinate>& coordinates() const;

  /// Names of the free velocity components that no marker and no coordinate task determines at the last
  /// fitted frame: they keep the values that they had.
  std::vector<std::string> undetermined() const;

 private:
  struct Work;
  explicit MarkerFit(std::unique_ptr<Work> work);
  std::unique_ptr<Work> work_;
};

}  // namespace borelli
