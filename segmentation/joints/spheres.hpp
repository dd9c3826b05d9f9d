// Round bone heads: found by votes of the bone's surface, measured by rays to it.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "segmentation/body/bone_edges.hpp"
#include "segmentation/grid/morphology.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

struct FoundSphere {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< mm, LPS
  double radius = 0;                                 ///< mm
  double score =
      0;  ///< share of the directions in which the bone's surface agrees, less where it ends before
  double deviation = 0;  ///< rms distance of the agreeing surface points from the ball, mm
  bool cut = false;      ///< the scan's end cuts the head or all that bears it out
};

/// Where bone surfaces curve about a point at a distance of `least` to `most` mm: each surface voxel votes
/// along its inward normal (Ballard's generalised Hough transform for spheres), so that a socket, whose
/// normal points away, does not vote for the ball in it. Local maxima, best first, none nearer than `apart`
/// mm to a better one. `hu` and `bone` on the same isotropic grid.
std::vector<FoundSphere> vote_balls(const Volume<std::int16_t>& hu, const Mask& bone, double least,
                                    double most, double apart, int threads = 0);

/// The balls that bone edges agree on, those first that most rays agree on: within 30 mm of `near` and of a
/// radius within `least` to `most` mm, measured in a close-up of the scan itself. A head and its socket's
/// outer face are two. Balls that less than a quarter of the rays agree on are left out. The answer does not
/// depend on `threads` (0: as many as the machine has).
std::vector<FoundSphere> fit_balls(const GreyVolume& volume, const Eigen::Vector3d& near, double least,
                                   double most, int threads = 0);

/// Algebraic least-squares sphere through at least four points (its linear normal equations). Nothing where
/// they are coplanar.
std::optional<FoundSphere> sphere_through(const std::vector<Eigen::Vector3d>& points);

}  // namespace borelli
