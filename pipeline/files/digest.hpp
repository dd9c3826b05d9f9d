// SHA-256 of files and bytes, as hexadecimal digits; used to detect changes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <string_view>

#include "error/error.hpp"

namespace borelli {

/// Digest of bytes.
std::string digest_of_bytes(std::string_view bytes);

/// Digest of a file's bytes, or of a folder: names and bytes of all its files, sorted by name. Errors: no
/// such file, not a regular file, not readable.
Result<std::string> digest_of(const std::filesystem::path& path);

/// Digest of the first `count` bytes of a file. Errors: as digest_of.
Result<std::string> digest_of_start(const std::filesystem::path& file, std::uint64_t count);

}  // namespace borelli
