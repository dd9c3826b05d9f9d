#include "segmentation/files/dicom_rle.hpp"

#include <cstdint>

namespace borelli {
namespace {

constexpr std::size_t rle_header_bytes = 64;

std::uint32_t rle_word(std::span<const std::byte> bytes, std::size_t at) {
  std::uint32_t word = 0;
  for (std::size_t n = 0; n < 4; ++n) word |= std::to_integer<std::uint32_t>(bytes[at + n]) << 8 * n;
  return word;
}

// Unpacks a segment (PackBits), which holds one byte of every pixel, into each `step`-th byte of `to`.
// Returns false if the segment holds too few or too many bytes.
bool unpack_rle_segment(std::span<const std::byte> from, std::span<std::byte> to, std::size_t step) {
  std::size_t at = 0, filled = 0;
  while (filled < to.size()) {
    if (at == from.size()) return false;
    const auto code = std::to_integer<unsigned>(from[at++]);
    if (code == 128) continue;  // no operation
    const bool literal = code < 128;
    const std::size_t count = literal ? code + 1 : 257 - code, taken = literal ? count : 1;
    if (from.size() - at < taken || (to.size() - filled + step - 1) / step < count) return false;
    for (std::size_t n = 0; n < count; ++n, filled += step) to[filled] = from[literal ? at + n : at];
    at += taken;
  }
  return true;
}

}  // namespace

std::string_view unpack_rle(std::span<const std::byte> stream, std::size_t width, std::span<std::byte> to) {
  if (stream.size() < rle_header_bytes) return "its header is cut off";
  if (rle_word(stream, 0) != width) return "it does not have one segment per byte of a pixel";
  for (std::size_t n = 0; n < width; ++n) {  // most significant byte first
    const std::size_t start = rle_word(stream, 4 + 4 * n);
    const std::size_t end = n + 1 < width ? rle_word(stream, 8 + 4 * n) : stream.size();
    if (start < rle_header_bytes || start > end || end > stream.size())
      return "a segment lies outside the data";
    if (!unpack_rle_segment(stream.subspan(start, end - start), to.subspan(width - 1 - n), width))
      return "a segment does not hold one byte per pixel";
  }
  return {};
}

}  // namespace borelli
