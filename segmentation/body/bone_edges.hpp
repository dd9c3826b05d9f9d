// Bone edges along rays, in a close-up of the scan: the measurements behind spheres and hinges.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "segmentation/volume/volume.hpp"

namespace borelli {

/// A region of a scan, resampled along the patient's axes as CT numbers.
struct CloseUp {
  /// Isotropic grid, integer values; padding_hu outside the scan. Stored as double, since interpolation reads
  /// it about a hundred million times.
  Volume<double> hu;
  double blur = 1;      ///< cube root of the scan's voxel volume, the width of a blurred edge, mm
  double coarsest = 1;  ///< the scan's largest spacing, mm

  /// Trilinear value at a patient point (mm, LPS); padding_hu outside.
  double at(const Eigen::Vector3d& point) const;
  /// The same at `count` points, from `from` on, `step` (mm) apart.
  void along(const Eigen::Vector3d& from, const Eigen::Vector3d& step, int count, double* values) const;
};

/// A cube of half width `half` mm about a point (mm, LPS), at about the scan's own resolution (1 to 3 mm).
CloseUp close_up(const GreyVolume& volume, const Eigen::Vector3d& centre, double half);

/// Distances in mm from `from` along a unit direction, ascending, within `least` to `most` mm, at which CT
/// numbers fall steeply (by 100 or more over the blur). Each edge lies half way between the levels on its two
/// sides. The scan's end counts as no edge.
std::vector<double> falls_along(const CloseUp& view, const Eigen::Vector3d& from,
                                const Eigen::Vector3d& direction, double least, double most);

/// Unit vectors evenly distributed over the sphere (golden spiral).
std::vector<Eigen::Vector3d> even_directions(int count);

}  // namespace borelli
