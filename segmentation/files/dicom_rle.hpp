// RLE pixels of DICOM (PS3.5, annex G).
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

namespace borelli {

/// Unpacks one frame of `width` bytes a pixel (1, 2 or 4) to little-endian words. `to`: width bytes for each
/// pixel. Answers what is wrong with the stream; empty where it is whole.
std::string_view unpack_rle(std::span<const std::byte> stream, std::size_t width, std::span<std::byte> to);

/// The most bytes that a stream of `packed` bytes can unpack to.
constexpr double most_of_rle(double packed) { return 64 * packed; }

}  // namespace borelli
