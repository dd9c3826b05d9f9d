// The files that a text header (NRRD, MetaImage) names for its voxels: one, a list, or a pattern of numbers.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "segmentation/image_file.hpp"

namespace borelli {

/// Whether the field says that file names follow in the lines after it.
bool names_follow(std::string_view field);

/// The files that `field` names, beside the header at `path`, in the order of their slices: one file; of
/// "LIST" those in the `lines` that follow; of "slice%03d.raw 1 64 1" those of each number (from the first to
/// the last, in steps). Errors: another pattern; a number of files among which `slices` cannot be shared out.
Result<std::vector<std::string>> named_files(const std::string& path, std::string_view field,
                                             const std::vector<std::string>& lines, std::int64_t slices);

/// What stands in each file before its voxels.
struct BeforeVoxels {
  double lines = 0;
  std::uint64_t bytes = 0;  ///< after these lines
  bool all_else = false;    ///< the voxels are the last bytes
};

/// Puts the files into the header, whose grid and type are known. Errors: a file that cannot be read, or is
/// too short.
Result<void> set_voxel_files(ImageHeader& header, const std::vector<std::string>& files,
                             const BeforeVoxels& before);

}  // namespace borelli
