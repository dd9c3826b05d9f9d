// From the channels of a force plate to the ground reaction in the laboratory.
//
// Sources: C3D user guide, "The FORCE_PLATFORM group" (www.c3d.org); for type 3 also Kistler's formulae
// (isbweb.org/software/movanal/vaughan/kistler.pdf); for the sign of ORIGIN, HAS-Motion's page "FP ORIGIN".
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "error/error.hpp"
#include "pipeline/recordings/measured_force.hpp"

namespace borelli {

/// Load along the plate's normal, N, below which the centre of pressure is lost in the plate's noise.
inline constexpr double least_plate_load = 20;

/// A plate as a file describes it. Its own frame C has its origin in the centre of the surface; x runs from
/// corner 2 to corner 1, y from corner 4 to corner 1, z = x × y, into the ground by the user guide.
struct ForcePlate {
  std::string name;
  int type = 2;
  Eigen::Matrix<double, 3, 4> corners;  ///< m, laboratory frame, quadrants (+x+y), (-x+y), (-x-y), (+x-y)
  /// Types 2 and 4: from the origin O of the measured moments to C, m, plate frame. Type 3: distances of the
  /// sensors from the y and from the x axis, and the z of C.
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  /// N, N m, m; one column per sample. Rows of type 1: Fx Fy Fz Px Py Tz (P from C); of types 2 and 4: Fx Fy
  /// Fz Mx My Mz (about O); of type 3: Fx12 Fx34 Fy14 Fy23 Fz1 Fz2 Fz3 Fz4.
  Eigen::MatrixXd channels;
  /// Samples in which the file says that the plate is unloaded: from the first to before the second.
  std::pair<Eigen::Index, Eigen::Index> unloaded{0, 0};
};

/// The rotation R_WP from the plate's frame to the laboratory, from all four corners. Errors about
/// `plate.name`: corners that are not finite, edges shorter than 1 cm or longer than 100 m, edges more than
/// 12° from square.
Result<Eigen::Matrix3d> plate_axes(const ForcePlate& plate);

/// The unit vector in the laboratory that points out of the ground: ±z of the plate, on the side of `up`;
/// -z where `up` is unknown or lies in the plate.
Eigen::Vector3d plate_normal(const Eigen::Matrix3d& R_WP, const std::optional<Eigen::Vector3d>& up);

/// The ground reaction. `times`: s, one per sample. `up`: as in MarkerMotion.
///
/// - The mean of the samples in `unloaded` is taken off each channel, unless it exceeds a tenth of the greatest
///   load: the plate then was not unloaded, and a warning says so.
/// - ORIGIN's z must lead from O up to the surface. If it leads down, all of ORIGIN changes sign (type 3: its z),
///   with a warning: many files have the distance there.
/// - The ground pushes. Where the greatest pull exceeds 50 N and twice the greatest push, the file holds what the
///   body does to the plate: all changes sign, with a warning.
/// - point and moment are NaN where the ground pushes with less than `least_plate_load`, and for a type 3 whose
///   ORIGIN has no x or no y (a warning says so).
/// Errors about `plate.name`: corners as plate_axes; a type other than 1 to 4.
Result<MeasuredForce> measured_force(const ForcePlate& plate, const std::vector<double>& times,
                                     const std::optional<Eigen::Vector3d>& up,
                                     std::vector<std::string>& warnings);

}  // namespace borelli
