// Writes a volume or a label map to the path it is given: .nii.gz, .nii, .nrrd or .mha.
#pragma once

#include <string>

#include "error/error.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

/// Voxels as int16; the quantity is recorded in the header, so that read_volume needs no --quantity. NIfTI
/// stores the grid as float32 (seven digits), NRRD and MetaImage at full precision. Errors: unknown
/// extension, path not writable, disk full, a sheared grid as MetaImage.
Result<void> write_volume(const std::string& path, const GreyVolume& volume);

/// Voxels as uint8, and beside them the names as TSV (names_file in read.hpp). Errors as write_volume.
Result<void> write_labels(const std::string& path, const LabelMap& labels);

}  // namespace borelli
