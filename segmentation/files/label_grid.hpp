// A label map's grid beside its scan's, told before the labels are read.
#pragma once

#include <string>

#include "error/error.hpp"
#include "segmentation/volume.hpp"

namespace borelli {

/// Whether the voxels of the label map at `labels`, by its header, may be those of `scan` (in any order of
/// axes, and cropped or larger). Errors: they are not, about `labels`; a header that cannot be read.
Result<void> check_label_grid(const std::string& labels, const Grid& scan, const std::string& scan_name);

}  // namespace borelli
