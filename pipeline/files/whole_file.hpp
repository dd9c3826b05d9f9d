// Files appear under their final name only when whole: written under a temporary name, flushed to disk,
// renamed.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "error/error.hpp"

namespace borelli {

/// Calls `write` with a temporary path in the same folder and with the same extension, then renames the file
/// to `path`. Creates missing folders. On an error neither a file nor a new empty folder remains, and the
/// error names `path`. Removes temporary files that killed writers of `path` left.
Result<void> write_whole(const std::filesystem::path& path,
                         const std::function<Result<void>(const std::filesystem::path&)>& write);

/// The same for bytes in memory.
Result<void> write_whole(const std::filesystem::path& path, std::string_view bytes);

/// Writes files that belong together. `write` gets an empty folder and puts files of these `names` into it;
/// then they move to `folder` in that order. If `write` fails, `folder` stays unchanged, or absent.
Result<void> write_whole_set(const std::filesystem::path& folder, const std::vector<std::string>& names,
                             const std::function<Result<void>(const std::filesystem::path&)>& write);

/// Writes bytes to exactly this path, for callers inside write_whole. Errors: in the system's words.
Result<void> write_bytes(const std::filesystem::path& path, std::string_view bytes);

/// Checks before long work whether write_whole can succeed: `path` is neither a folder nor one of `inputs`
/// (the files the work reads), and check_folder_writable accepts its folder.
Result<void> check_writable(const std::filesystem::path& path,
                            const std::vector<std::filesystem::path>& inputs = {});

/// Checks whether a file can be created in `folder`, or in the nearest folder above it if it is missing, by
/// creating one and removing it: only the system knows all obstacles (permissions, a file in the way, a full
/// or read-only disk). Then checks that none of `names` is a folder in it.
Result<void> check_folder_writable(const std::filesystem::path& folder,
                                   const std::vector<std::string>& names = {});

/// Call before the program ends: removes the temporary files that write_whole is filling now, in all threads,
/// and prevents new ones. Safe in a signal handler.
void stop_writing() noexcept;

/// Removes temporary files that killed writers of `path` left; never those of a living writer.
void sweep_partial_files(const std::filesystem::path& path);

/// The same for every file in `folder` and its subfolders.
void sweep_partial_files_below(const std::filesystem::path& folder);

}  // namespace borelli
