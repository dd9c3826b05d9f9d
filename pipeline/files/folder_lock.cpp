#include "pipeline/files/folder_lock.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace borelli {

Result<FolderLock> FolderLock::take(const std::filesystem::path& folder) {
  std::error_code problem;
  std::filesystem::create_directories(folder, problem);
  if (problem) return failure(folder.string(), "cannot create this folder: " + problem.message());
  const int file = open((folder / ".lock").c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0666);
  if (file < 0) return failure(folder.string(), std::string("cannot be written to: ") + std::strerror(errno));
  FolderLock lock(folder, file);
  if (flock(file, LOCK_EX | LOCK_NB) == 0) return lock;
  if (errno == EWOULDBLOCK)
    return failure(folder.string(), "another run is using this folder; wait until it ends");
  return failure(folder.string(), std::string("cannot be locked against a second run: ") +
                                      std::strerror(errno) + "; choose a folder on another disk");
}

FolderLock::FolderLock(FolderLock&& other) noexcept
    : folder_(std::move(other.folder_)), file_(std::exchange(other.file_, -1)) {}

FolderLock::~FolderLock() {
  if (file_ >= 0) close(file_);
}

}  // namespace borelli
