// Scans of bodies with exact part labels, for training and testing the voxel labeller.
#pragma once

#include <cstdint>
#include <optional>
#include <random>
#include <string>

#include "error/error.hpp"
#include "samples/phantom_voxels.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli::suite {

/// A scan and the part of each of its voxels (labels as in parts.hpp), on the same grid.
struct LabelledScan {
  GreyVolume grey;
  Volume<std::uint8_t> parts;
};

/// Reads FOLDER/scan.nii.gz and FOLDER/parts.nii.gz. Errors: those of the readers, grids that differ.
Result<LabelledScan> read_labelled(const std::string& folder);

/// The phantom of a seed: 1.15 to 2.0 m, slight to stout, either sex. Three of five are in a pose drawn from
/// the joints' whole ranges, and half of these with a forearm or hand that touches another part. Voxels
/// of 2.5 mm and slices of 2.5 to 6 mm. Throws std::runtime_error where it cannot be made.
LabelledScan drawn_phantom(std::uint64_t seed);

/// Draws another scan of a similar body: scaled by 0.85 to 1.15 and by 0.93 to 1.07 along each axis, turned
/// by up to 12 degrees about each, with noise of up to 40 HU. Usually it shows only
/// a part of the body, and sometimes one limb alone.
LabelledScan drawn_view(const LabelledScan& whole, std::mt19937_64& random);

/// The part of a scan between two shares (0 to 1) of its length along an axis of its grid.
LabelledScan cropped(const LabelledScan& whole, int axis, double first, double last);

}  // namespace borelli::suite
