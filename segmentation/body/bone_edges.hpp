// Where bone ends along a ray, in a close-up of the scan: what spheres and hinges are measured from.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "segmentation/volume/volume.hpp"

namespace borelli {

/// A stretch of a scan along the patient's axes, as CT numbers.
struct CloseUp {
  /// Whole numbers, isotropic; padding_hu where the scan shows nothing. As doubles, since a hundred million
  /// values between them are asked for.
  Volume<double> hu;
  double blur = 1;      ///< over which the scan itself blurs an edge, mm (its middling voxel size)
  double coarsest = 1;  ///< the scan's largest spacing, mm

  /// Trilinear value at a patient point, padding_hu beyond.
  double at(const Eigen::Vector3d& point) const;
  /// The same at `count` points from `from` on, each `step` (mm) after the last.
  void along(const Eigen::Vector3d& from, const Eigen::Vector3d& step, int count, double* values) const;
};

/// A cube of half width `half` mm about a point, at about the scan's own resolution (1 to 3 mm).
CloseUp close_up(const GreyVolume& volume, const Eigen::Vector3d& centre, double half);

/// Distances from `from` along a unit direction, within `least` to `most` mm, at which CT numbers fall
/// steeply (by 100 or more over the blur), each at half way between the levels on its two sides; outwards.
/// Where the scan ends none is seen.
std::vector<double> falls_along(const CloseUp& view, const Eigen::Vector3d& from,
                                const Eigen::Vector3d& direction, double least, double most);

/// Unit vectors spread evenly over the sphere (golden spiral).
std::vector<Eigen::Vector3d> even_directions(int count);

}  // namespace borelli
