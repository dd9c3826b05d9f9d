// Files appear under their final name only when whole: written beside, flushed to the disk, then renamed.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "error/error.hpp"

namespace borelli {

/// Calls `write` with a temporary path in the same folder and with the same extension, then renames what it
/// wrote to `path`. On an error nothing stays behind, and the error names `path`. Creates the folder where it
/// is missing. Removes temporary files that killed writers of `path` left.
Result<void> write_whole(const std::filesystem::path& path,
                         const std::function<Result<void>(const std::filesystem::path&)>& write);

/// The same for bytes in memory.
Result<void> write_whole(const std::filesystem::path& path, std::string_view bytes);

/// Files that belong together: `write` gets an empty folder and puts files of these `names` into it; then
/// they move to `folder` in that order. If `write` fails, `folder` stays as it was.
Result<void> write_whole_set(const std::filesystem::path& folder, const std::vector<std::string>& names,
                             const std::function<Result<void>(const std::filesystem::path&)>& write);

/// Bytes to exactly this path, for a writer that write_whole calls; what failed is told as the system does.
Result<void> write_bytes(const std::filesystem::path& path, std::string_view bytes);

/// Whether write_whole may succeed, asked before long work: `path` is no folder and none of the files that
/// the work is to read, and check_folder_writable of the one that it goes to.
Result<void> check_writable(const std::filesystem::path& path,
                            const std::vector<std::filesystem::path>& inputs = {});

/// Whether a file can be made in `folder`: makes one, and the folders on the way that are missing, and
/// removes them again, since only the system knows all that may stand against it (permissions, a file in the
/// way, a disk that is full or read-only). Then whether none of the `names` to be written in it is a folder.
Result<void> check_folder_writable(const std::filesystem::path& folder,
                                   const std::vector<std::string>& names = {});

/// Removes the temporary files that write_whole is filling now, of all threads, before the program's end:
/// none begins another file. A signal's handler may call it.
void stop_writing() noexcept;

/// Removes temporary files that killed writers of `path` left; never those of a living writer.
void sweep_partial_files(const std::filesystem::path& path);

/// The same for every file in `folder` and its subfolders.
void sweep_partial_files_below(const std::filesystem::path& folder);

}  // namespace borelli
