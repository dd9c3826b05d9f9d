// The files of a folder that may be DICOM, and those that only stand for one.
#pragma once

#include <string>
#include <vector>

#include "error/error.hpp"

namespace borelli {

/// Files that stand where pictures are and hold none.
struct Placeholders {
  std::vector<std::string> unfetched;  ///< pointers of git-annex (datalad) or Git LFS; links to nothing
  std::vector<std::string> apple;      ///< "._NAME", which macOS writes beside NAME
  std::vector<std::string> stubs;      ///< empty, or with no more than the start of a DICOM file

  /// Puts a file that holds no picture into its list. False: it is none of these.
  bool take(const std::string& path);
  std::vector<std::string> sentences() const;  ///< one for each kind that there is
};

struct FolderFiles {
  std::vector<std::string> files;  ///< regular ones, in an order that does not depend on the disk
  Placeholders placeholders;       ///< links to nothing and "._NAME", which are not opened
};

/// All files in a folder and in the folders in it, also behind links; each folder once, and none that holds
/// `folder` itself. Of a file: that file. Errors: the folder cannot be listed.
Result<FolderFiles> files_below(const std::string& folder);

}  // namespace borelli
