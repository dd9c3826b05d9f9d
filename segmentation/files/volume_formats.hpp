// File formats of volumes beside DICOM. To add one, write its reader and list it in volume_formats.cpp.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "segmentation/files/image_file.hpp"

namespace borelli {

/// Endings are in lower case, longer ones first; files may have them in capitals.
struct VolumeFormat {
  std::vector<std::string_view> endings;  ///< of files that begin with the header
  std::vector<std::string_view> halves;   ///< of files of voxels whose header stands beside them
  std::vector<std::string_view> written;  ///< of files that `write` writes
  /// Reads the header of a file, or of the one beside a half.
  Result<ImageHeader> (*read_header)(const std::string& path);
  Result<void> (*write)(const std::string& path, const Grid& grid, Scalar scalar,
                        std::span<const std::byte> voxels, const std::string& recorded_quantity);
};

const std::vector<VolumeFormat>& volume_formats();

/// A format and the ending by which a path names it; null: none.
struct NamedFormat {
  const VolumeFormat* format = nullptr;
  std::string_view ending;
};
using Endings = std::vector<std::string_view> VolumeFormat::*;

/// The format whose ending of this list (`&VolumeFormat::endings`, `halves` or `written`) a path has.
NamedFormat format_of(std::string_view path, Endings endings);

/// The endings of this list of all formats, for messages: ".nii.gz, .nii, .nrrd or .mha".
std::string endings_in_words(Endings endings);

}  // namespace borelli
