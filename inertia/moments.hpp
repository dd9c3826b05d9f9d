// Computes the ten moments (of order 0, 1 and 2) of each label of a volume, in one streaming pass over labels
// and grey values.
//
// The sums run in index space, over integers i, j, k; the grid's affine map is applied once at the end. So
// the result is exact (to rounding) on anisotropic, oblique and sheared grids alike. A weighted set of points
// with sum m, mean c and covariance C becomes m, p + A c and A C A^T under x = p + A i.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "error/error.hpp"
#include "inertia/inertial.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

/// Moments of a set of weighted voxels, in index space.
struct Moments {
  std::int64_t voxels = 0;                           ///< number of voxels, whatever their weights
  double weight = 0;                                 ///< sum of w
  Eigen::Vector3d first = Eigen::Vector3d::Zero();   ///< sum of w (i, j, k)
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();  ///< sum of w (i, j, k) (i, j, k)^T

  Moments& operator+=(const Moments& other);
};

/// moments[label]
using LabelMoments = std::array<Moments, 256>;

/// Weight of each of the 65536 grey values: weight[grey + 32768]. Densities in kg/m^3 give masses.
using GreyWeights = std::vector<double>;

/// Errors: the two grids differ, or a volume or the table has not its stated size.
Result<void> check_same_grid(const LabelMap& labels, const Volume<std::int16_t>& grey,
                             const GreyWeights& weights);

/// Moments of every label except 0 (outside), each voxel weighted by its grey value. Errors: as
/// check_same_grid. The order of the sums is fixed: the result does not depend on `threads` (0: as many as
/// the machine has).
Result<LabelMoments> label_moments(const LabelMap& labels, const Volume<std::int16_t>& grey,
                                   const GreyWeights& weights, int threads = 0);

/// The same with weight 1 for each voxel: the moments of volume.
Result<LabelMoments> label_moments(const LabelMap& labels, int threads = 0);

/// Meaning of a voxel's weight.
enum class Sampling {
  /// The body's density at the voxel's centre. Label maps are of this kind: a voxel is in or out by its
  /// centre. Second moments are then right as summed; adding each voxel's own cube moment (h^2/12 per axis)
  /// makes them worse.
  points,
  /// The body's mean density over the voxel's box, as in a CT, whose skin voxels hold part body, part air.
  /// This convolves the body with a box, so h^2/12 per axis is subtracted from the second moments per unit of
  /// mass (Sheppard W F (1898) Proc Lond Math Soc 29:353). On an oblique grid the box is the voxel's
  /// parallelepiped. At a cut between two parts the weights end sharply and need no such term. The resulting
  /// error, at most m h^2/12 on the cut's axis, is below 1e-4 of any segment's moment at 2 mm. A sliver
  /// thinner than two voxels (standard deviation below half a voxel) is treated as points.
  averages,
};

/// Mass, gravity centre and tensor of moments whose weights are densities in kg/m^3, in the world frame: the
/// grid's axes (patient, LPS) in metres. Zero weight gives zeros.
Inertial to_inertial(const Moments& moments, const Grid& grid, Sampling sampling);

}  // namespace borelli
