// One run at a time in a folder.
#pragma once

#include <filesystem>

#include "error/error.hpp"

namespace borelli {

/// Holds a folder against a second run in it, for as long as it lives. The system lets go of it when the
/// program ends, however it ends, so that a run that was killed blocks none after it; the empty file `.lock`
/// stays in the folder and means nothing by itself.
class FolderLock {
 public:
  /// Makes the folder where it is missing. Errors: it cannot be made or written to; another run holds it; its
  /// file system has no locks.
  static Result<FolderLock> take(const std::filesystem::path& folder);

  FolderLock(FolderLock&& other) noexcept;
  FolderLock& operator=(FolderLock&&) = delete;
  ~FolderLock();

  const std::filesystem::path& folder() const { return folder_; }

 private:
  FolderLock(std::filesystem::path folder, int file) : folder_(std::move(folder)), file_(file) {}

  std::filesystem::path folder_;
  int file_;
};

}  // namespace borelli
