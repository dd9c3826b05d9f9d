// Allows only one run at a time in a folder.
#pragma once

#include <filesystem>

#include "error/error.hpp"

namespace borelli {

/// Locks a folder during its lifetime. The operating system releases the lock when the program ends for any
/// reason, so a killed run blocks none after it. The empty file `.lock` stays in the folder; its presence
/// alone means nothing.
class FolderLock {
 public:
  /// Creates the folder if missing. Errors: it cannot be created or written to; another run holds the lock;
  /// the file system has no locks.
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
