// A folder of masks, one file per class and named by it (femur_left.nii.gz), as one label map:
// TotalSegmentator's default output.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "error/error.hpp"
#include "segmentation/files/image_file.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

struct MaskFolder {
  Grid grid;
  StoredVoxels voxels;                        ///< uint8: a class's number, 0: none
  std::map<std::int64_t, std::string> names;  ///< of masks that hold a voxel, numbered by name
  std::vector<std::string> warnings;
};

/// The masks in a folder, in the order of their names: files of the formats of read_volume; other files and
/// subfolders do not count.
std::vector<std::string> masks_in(const std::string& folder);

/// Reads them, one at a time. Empty masks are left out; where two overlap by a little, the first by name has
/// the voxel, with a warning. `accept` checks the grid before a voxel is read; its error is passed on.
/// Errors: no mask, or none with a voxel; masks on different grids, of several values or layers, overlapping
/// by more than a twentieth of the smaller; two of one name; more than 255 with a voxel; too large for
/// memory.
Result<MaskFolder> read_mask_folder(const std::string& folder,
                                    const std::function<Result<void>(const Grid&)>& accept = {},
                                    const Progress& progress = {});

}  // namespace borelli
