// SHA-256 of files and bytes, in hex: what tells whether something is still what it was.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <string_view>

#include "error/error.hpp"

namespace borelli {

/// Of bytes.
std::string digest_of_bytes(std::string_view bytes);

/// Of a file's bytes, or of all files of a folder (names and bytes, in the order of their names).
Result<std::string> digest_of(const std::filesystem::path& path);

/// Of the first `count` bytes of a file.
Result<std::string> digest_of_start(const std::filesystem::path& file, std::uint64_t count);

}  // namespace borelli
