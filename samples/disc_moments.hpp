// Area and moments, up to second order, of a disc cut by straight lines. Every solid of the phantom has this
// cross-section, up to an affine map.
//
// The boundary of such a disc consists of arcs and chords. Green's theorem turns each moment into a sum over
// them, with closed-form terms.
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

/// Largest number of half-planes that may cut a disc.
inline constexpr std::size_t most_cuts = 16;

/// Moments about its centre of the unit disc cut by at most most_cuts half-planes. Two half-planes with one
/// normal are allowed.
PlaneMoments disc_moments(std::span<const HalfPlane> cuts);

}  // namespace borelli
