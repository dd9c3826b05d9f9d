// Input files are regular files of bounded size: a pipe or a device may block or never end.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>

#include "error/error.hpp"

namespace borelli {

/// The most bytes of a text input: scene, model, settings, state, table, landmarks, names.
inline constexpr std::uint64_t most_text_bytes = std::uint64_t{256} << 20;

/// For files whose size memory alone bounds.
inline constexpr std::uint64_t any_size = std::numeric_limits<std::uint64_t>::max();

/// Asked before any input file is opened. Errors: no such file, a folder, a pipe, socket or device; more than
/// `most` bytes.
Result<void> check_input_file(const std::filesystem::path& path, std::uint64_t most = any_size);

/// All bytes of a file. Errors: as check_input_file; no right to read; more bytes than memory may hold.
Result<std::string> read_input_file(const std::filesystem::path& path, std::uint64_t most = most_text_bytes);

}  // namespace borelli
