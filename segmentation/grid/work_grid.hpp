// The grid that parts are looked for on: isotropic, along the patient's own axes, a few millimetres apart.
//
// Whatever the scan's grid is (anisotropic, oblique, mirrored, sheared), on this one i runs to the patient's
// left, j to the back and k up, so that left and right come from the affine and never from the picture.
#pragma once

#include "segmentation/grid/morphology.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

/// What a scan shows on the work grid.
struct WorkVolume {
  Volume<std::int16_t> hu;  ///< CT numbers (of a density volume: those that its densities stand for)
  Mask seen;                ///< 1 where the scan holds the place: inside its grid and not padding
};

/// The CT number that a value stands for: itself, or from a mass density by Schneider's broken line (fat and
/// soft tissue near unit slope, bone steeper).
double hu_of(double value, Quantity quantity);

/// Trilinear value at a fractional index of the scan; false where the scan does not show the place (beyond
/// its grid, or padding: CT numbers below -1024, densities below 0).
bool sample(const GreyVolume& volume, const Eigen::Vector3d& index, double& value);

/// Axis-aligned isotropic grid over what in the scan is denser than air, with 30 mm around it as far as the
/// scan goes, and one voxel more.
Grid work_grid(const GreyVolume& volume, double step, int threads = 0);

/// The volume on the work grid: mean of trilinear samples over each work voxel (so that nothing thin is
/// stepped over), padding taken as unseen air.
WorkVolume resampled(const GreyVolume& volume, double step, int threads = 0);
/// The same on a grid from work_grid.
WorkVolume resampled(const GreyVolume& volume, const Grid& grid, int threads = 0);

}  // namespace borelli
