// The numbers of a C3D file: written by an Intel, a DEC (VAX, PDP-11) or a MIPS (SGI) processor.
// Source: C3D user guide, "Parameter header" and "Binary formats", www.c3d.org.
#pragma once

#include <cstdint>
#include <optional>

namespace borelli {

enum class C3dProcessor {
  intel,  ///< low byte first, IEEE 754
  dec,    ///< low byte first; VAX F floating point, whose 16-bit halves stand high half first
  mips,   ///< high byte first, IEEE 754
};

/// The processor of byte 4 of the parameter section: 84 Intel, 85 DEC, 86 MIPS. Empty for other bytes.
std::optional<C3dProcessor> c3d_processor(std::uint8_t byte);

/// The unsigned 16-bit integer at `bytes` (two bytes are read).
std::uint16_t c3d_word(const char* bytes, C3dProcessor processor);
/// The signed one.
std::int16_t c3d_integer(const char* bytes, C3dProcessor processor);
/// The 32-bit floating-point number at `bytes` (four bytes are read). NaN for VAX's reserved operand.
float c3d_real(const char* bytes, C3dProcessor processor);

}  // namespace borelli
