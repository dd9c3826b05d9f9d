// Lists the files of a folder that may be DICOM, and placeholders that hold no image.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "error/error.hpp"
#include "segmentation/files/dicom_elements.hpp"

namespace borelli {

/// Files among the images that hold no image.
struct Placeholders {
  std::vector<std::string> unfetched;       ///< pointer files of git-annex (datalad) or Git LFS; broken links
  std::vector<std::string> macos_metadata;  ///< "._NAME", which macOS writes beside NAME
  std::vector<std::string> stubs;           ///< empty, or only the first bytes of a DICOM file

  /// Adds a file to its list by its first bytes. Returns false if it is no placeholder.
  bool add_if_placeholder(const std::string& path);
  std::vector<std::string> sentences() const;  ///< one for each list that is not empty
};

/// "NAME `one`", or "N files (the first is NAME) `many`".
std::string files_sentence(const std::vector<std::string>& paths, std::string_view one,
                           std::string_view many);

struct FolderFiles {
  std::vector<std::string> files;  ///< regular files, sorted by path
  Placeholders placeholders;       ///< broken links and "._NAME"; callers add the others
};

/// All files below a folder, links followed. Each folder is listed once; links to a folder above `folder` are
/// skipped. A path to a file gives that file. Errors: the folder cannot be listed.
Result<FolderFiles> files_below(const std::string& folder);

/// What a DICOM object is that is no series of images: "an RT dose"; "" for images and segmentations.
std::string kind_without_series(const DicomElements& object);

}  // namespace borelli
