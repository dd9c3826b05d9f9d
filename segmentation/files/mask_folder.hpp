// Reads a folder of masks, one file per class and named by it (femur_left.nii.gz), as one label map. This is
// TotalSegmentator's default output.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "error/error.hpp"
#include "segmentation/files/image_file.hpp"
#include "segmentation/files/segment_overlaps.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

struct MaskFolder {
  Grid grid;
  StoredVoxels voxels;                        ///< uint8: a class's number, 0: none
  std::map<std::int64_t, std::string> names;  ///< of masks that are not empty, numbered in name order
  std::vector<std::string> warnings;
};

/// The masks in a folder, in the order of their names: files in the formats of read_volume. Other files and
/// subfolders are ignored.
std::vector<std::string> masks_in(const std::string& folder);

/// Reads the masks, one at a time, in name order. Empty masks are left out. SegmentOverlaps decides on voxels
/// in several masks. `accept` checks the grid before a voxel is read; its error is passed on. Errors: no
/// mask, or all empty; masks on different grids, with several values or layers; those of SegmentOverlaps; two
/// with the same name; more than 255 that are not empty; too large for memory.
Result<MaskFolder> read_mask_folder(const std::string& folder,
                                    const std::function<Result<void>(const Grid&)>& accept = {},
                                    const IsUsed& is_used = {}, const Progress& progress = {});

}  // namespace borelli
