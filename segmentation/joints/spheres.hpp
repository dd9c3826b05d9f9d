// Spheres on round bone heads: candidates by votes of the bone's surface, then a fit by rays.
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
  double score = 0;      ///< fraction of directions whose edge agrees, less those where bone ends earlier
  double deviation = 0;  ///< rms distance of the agreeing edges from the sphere, mm
  double rival = 0;      ///< standard deviation from the next likely place of the head, mm; 0: none
  bool cut = false;      ///< the scan's end cuts the head or the anatomy that confirms it
};

/// Candidate centres of spheres with radii from `least` to `most` mm. Each surface voxel votes along its
/// inward normal (Ballard's generalised Hough transform for spheres); a socket's normal points away, so it
/// does not vote for the head in it. Returns local maxima, best first, each at least `apart` mm from any
/// better one. `hu` and `bone` share an isotropic grid.
std::vector<FoundSphere> vote_balls(const Volume<std::int16_t>& hu, const Mask& bone, double least,
                                    double most, double apart, int threads = 0);

/// Spheres fitted to bone edges in a close-up of the scan, best score first. Centres lie within 30 mm of
/// `near` (mm, LPS), radii within `least` to `most` mm. A head and its socket's outer surface give two
/// spheres. Leaves out spheres with a score below a quarter. The result does not depend on `threads` (0: all
/// of the machine's).
std::vector<FoundSphere> fit_balls(const GreyVolume& volume, const Eigen::Vector3d& near, double least,
                                   double most, int threads = 0);

/// Algebraic least-squares sphere through at least four points (linear normal equations). Empty if they are
/// coplanar.
std::optional<FoundSphere> sphere_through(const std::vector<Eigen::Vector3d>& points);

}  // namespace borelli
