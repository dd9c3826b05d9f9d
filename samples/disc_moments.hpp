// Area and moments, up to second order, of a disc cut by straight lines: the cross-section of every solid of
// the phantom, up to an affine map.
//
// The boundary of a disc cut by half-planes is made of arcs and chords; Green's theorem turns each moment
// into a sum over them, and every term has a closed form.
#pragma once

#include <Eigen/Core>
#include <span>

namespace borelli {

/// The points u with normal . u <= offset; the normal is unit.
struct HalfPlane {
  Eigen::Vector2d normal;
  double offset;
};

/// Integrals of 1, x, y, xx, yy, xy.
using PlaneMoments = Eigen::Matrix<double, 6, 1>;

/// How many half-planes a disc may be cut by.
inline constexpr std::size_t most_cuts = 16;

/// Moments about its centre of the unit disc cut by at most most_cuts half-planes. Two half-planes with one
/// normal are allowed.
PlaneMoments disc_moments(std::span<const HalfPlane> cuts);

}  // namespace borelli
