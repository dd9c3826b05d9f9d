#include "pipeline/recordings/c3d_numbers.hpp"

#include <bit>
#include <cmath>
#include <limits>

namespace borelli {
namespace {

std::uint32_t c3d_byte(const char* bytes, int i) { return static_cast<std::uint8_t>(bytes[i]); }

// VAX F_floating: 1 sign bit, 8 exponent bits e, 23 fraction bits f. The value is
// (-1)^sign (1/2 + f / 2^24) 2^(e - 128). With e = 0 it is 0, or reserved if the sign is set.
// Source: VAX Architecture Reference Manual, "Floating-point formats".
float of_vax(std::uint32_t bits) {
  const int exponent = static_cast<int>(bits >> 23 & 0xff);
  const bool negative = bits >> 31 != 0;
  if (exponent == 0) return negative ? std::numeric_limits<float>::quiet_NaN() : 0.0F;
  const float fraction = 0.5F + std::ldexp(static_cast<float>(bits & 0x7fffff), -24);
  return std::ldexp(negative ? -fraction : fraction, exponent - 128);
}

}  // namespace

std::optional<C3dProcessor> c3d_processor(std::uint8_t byte) {
  switch (byte) {
    case 84:
      return C3dProcessor::intel;
    case 85:
      return C3dProcessor::dec;
    case 86:
      return C3dProcessor::mips;
    default:
      return std::nullopt;
  }
}

std::uint16_t c3d_word(const char* bytes, C3dProcessor processor) {
  const int low = processor == C3dProcessor::mips ? 1 : 0;
  return static_cast<std::uint16_t>(c3d_byte(bytes, low) | c3d_byte(bytes, 1 - low) << 8);
}

std::int16_t c3d_integer(const char* bytes, C3dProcessor processor) {
  return static_cast<std::int16_t>(c3d_word(bytes, processor));
}

float c3d_real(const char* bytes, C3dProcessor processor) {
  const std::uint32_t first = c3d_word(bytes, processor);
  const std::uint32_t second = c3d_word(bytes + 2, processor);
  switch (processor) {
    case C3dProcessor::intel:
      return std::bit_cast<float>(second << 16 | first);
    case C3dProcessor::mips:
      return std::bit_cast<float>(first << 16 | second);
    case C3dProcessor::dec:
      break;
  }
  return of_vax(first << 16 | second);
}

}  // namespace borelli
