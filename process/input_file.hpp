// Input files are regular files of bounded size: a pipe or a device may block or never end.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>

#include "error/error.hpp"

namespace borelli {

/// Size limit in bytes of a text input: scene, model, settings, state, table, landmarks, names.
inline constexpr std::uint64_t most_text_bytes = std::uint64_t{256} << 20;

/// No size limit: memory alone bounds these files.
inline constexpr std::uint64_t any_size = std::numeric_limits<std::uint64_t>::max();

/// Checks an input file before it is opened. Errors: no such file; a folder, pipe, socket or device; more
/// than `most` bytes.
Result<void> check_input_file(const std::filesystem::path& path, std::uint64_t most = any_size);

/// Reads all bytes of a file. Errors: as check_input_file; no permission; more bytes than the memory limit
/// allows.
Result<std::string> read_input_file(const std::filesystem::path& path, std::uint64_t most = most_text_bytes);

}  // namespace borelli
