// The ten moments of each label of a volume (of order 0, 1 and 2), in one streaming pass over labels and grey
// values.
//
// The sums run in index space, over whole numbers i, j, k, and the grid's affine maps them once at the end.
// So the answer is exact (to rounding) on anisotropic, oblique and sheared grids alike: a weighted set of
// points with sum m, mean c and covariance C turns under x = p + A i into m, p + A c and A C A^T.
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
  std::int64_t voxels = 0;                           ///< how many there are, whatever they weigh
  double weight = 0;                                 ///< sum of w
  Eigen::Vector3d first = Eigen::Vector3d::Zero();   ///< sum of w (i, j, k)
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();  ///< sum of w (i, j, k) (i, j, k)^T

  Moments& operator+=(const Moments& other);
};

/// moments[label]
using LabelMoments = std::array<Moments, 256>;

/// What each of the 65536 grey values weighs: weight[grey + 32768]. Densities in kg/m^3 give masses.
using GreyWeights = std::vector<double>;

/// Fails where the two grids differ or a volume or the table has not the size it says.
Result<void> check_same_grid(const LabelMap& labels, const Volume<std::int16_t>& grey,
                             const GreyWeights& weights);

/// Moments of every label but 0 (outside), each voxel weighed by its grey value. Fails where the two grids
/// differ or a table or volume has not the size it says. The sums' order is fixed: the answer does not depend
/// on `threads` (0: as many as the machine has).
Result<LabelMoments> label_moments(const LabelMap& labels, const Volume<std::int16_t>& grey,
                                   const GreyWeights& weights, int threads = 0);

/// The same with each voxel weighing 1: the moments of volume.
Result<LabelMoments> label_moments(const LabelMap& labels, int threads = 0);

/// What a voxel's weight stands for.
enum class Sampling {
  /// The body's density at the voxel's centre. So it is in a label map: a voxel is in or out by its centre.
  /// Second
  /// moments are then right as summed; to give each voxel a cube's own moment (h^2/12 per axis) makes them
  /// worse.
  points,
  /// The body's mean density over the voxel's box, as in a CT, whose skin voxels hold part body, part air.
  /// This
  /// widens the body by a box, so that h^2/12 per axis is subtracted (Sheppard W F (1898) Proc Lond Math Soc
  /// 29:353); on an oblique grid the box is the voxel's parallelepiped. Where a part is cut from its
  /// neighbour,
  /// its weights end sharply and need no such term there; the error made, at most m h^2/12 on the cut's axis,
  /// is
  /// below 1e-4 of any segment's moment at 2 mm. A sliver whose extent is a standard deviation of less than
  /// half a voxel
  /// (under two voxels thick) is left as points.
  averages,
};

/// Mass, gravity centre and tensor of such moments, weights being densities in kg/m^3, in the world frame:
/// the grid's axes (patient, LPS) in metres. Without weight all is zero.
Inertial to_inertial(const Moments& moments, const Grid& grid, Sampling sampling);

}  // namespace borelli
