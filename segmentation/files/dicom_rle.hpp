// Unpacks RLE pixels of DICOM (PS3.5, annex G).
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

namespace borelli {

/// Unpacks one frame of `width` bytes per pixel (1, 2 or 4) to little-endian words. `to`: `width` bytes for
/// each pixel. Returns what is wrong with the stream; empty: nothing.
std::string_view unpack_rle(std::span<const std::byte> stream, std::size_t width, std::span<std::byte> to);

/// The most bytes that `packed` bytes can unpack to: two bytes code a run of up to 128.
constexpr double most_of_rle(double packed) { return 64 * packed; }

}  // namespace borelli
