// Label names in the header extensions of a NIfTI file.
//
// TotalSegmentator (`--ml`), Caret and Connectome Workbench write them as a header extension (NIfTI-1,
// section "header extensions": four bytes whose first is 1, then blocks of size, code and content). The
// content is XML with a LabelTable: <Label Key="75" ...>femur_left</Label>.
#pragma once

#include <cstdint>
#include <vector>

#include "error/error.hpp"
#include "segmentation/files/image_file.hpp"

namespace borelli {

/// The labels that a NIfTI file names between its header, of `header_bytes`, and its voxels. `header`: at
/// least its file, packing and voxel offset. Empty if no extension has a LabelTable. The first name of a
/// repeated number counts; numbers below 1 are left out. Errors: a LabelTable that is not XML; not readable.
Result<std::vector<ImageSegment>> nifti_label_names(const ImageHeader& header, std::uint64_t header_bytes);

}  // namespace borelli
