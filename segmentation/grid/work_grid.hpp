// The grid on which parts are found: isotropic, along the patient's axes, with a step of a few millimetres.
//
// Whatever the scan's grid is (anisotropic, oblique, mirrored, sheared), i runs to the patient's left, j to
// the back and k up. So left and right come from the affine transform and never from the image content.
#pragma once

#include "segmentation/grid/morphology.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

/// The scan, resampled on the work grid.
struct WorkVolume {
  Volume<std::int16_t> hu;  ///< CT numbers (of a density volume: the equivalent ones)
  Mask seen;                ///< 1 where the scan shows the place: inside its grid and not padding
};

/// Converts a value to a CT number: unchanged, or from mass density by Schneider's piecewise linear relation
/// (about unit slope in fat and soft tissue, steeper in bone).
double hu_of(double value, Quantity quantity);

/// Trilinear value at a fractional index of the scan; false if the scan does not show the place (outside its
/// grid, or padding: CT numbers below -1024, densities below 0).
bool sample(const GreyVolume& volume, const Eigen::Vector3d& index, double& value);

/// Axis-aligned isotropic grid over all that is denser than air, with a margin of 30 mm as far as the scan
/// extends, and one more voxel.
Grid work_grid(const GreyVolume& volume, double step, int threads = 0);

/// Resamples the volume on the work grid: mean of trilinear samples over each work voxel, so that thin
/// structures are not missed. Padding becomes air that is not seen.
WorkVolume resampled(const GreyVolume& volume, double step, int threads = 0);
/// The same on a grid from work_grid.
WorkVolume resampled(const GreyVolume& volume, const Grid& grid, int threads = 0);

}  // namespace borelli
