// The files that a text header (NRRD, MetaImage) names for its voxels: one, a list, or a pattern of numbers.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "segmentation/files/image_file.hpp"

namespace borelli {

/// Whether the field ("LIST") says that file names follow, one per line.
bool names_follow(std::string_view field);

/// The files that `field` of the header at `path` names, in the order of their slices. "LIST" stands for the
/// names in `lines`, "slice%03d.raw 1 64 1" for numbered files (first number, last, step), any other text for
/// one file. Names are relative to the header's folder. Errors: a malformed pattern; a missing file; `slices`
/// is not a multiple of the number of files.
Result<std::vector<std::string>> named_files(const std::string& path, std::string_view field,
                                             const std::vector<std::string>& lines, std::int64_t slices);

/// What to skip in each file before its voxels.
struct BeforeVoxels {
  double lines = 0;
  std::uint64_t bytes = 0;  ///< skipped after the lines
  bool all_else = false;    ///< skip all but the last bytes, the voxels
};

/// Sets the files of `header`, whose grid and scalar type are known. Errors: a file that cannot be read or is
/// too short.
Result<void> set_voxel_files(ImageHeader& header, const std::vector<std::string>& files,
                             const BeforeVoxels& before);

}  // namespace borelli
