// Where the samples of a C3D file stand and how many there are. The header and the parameters both tell.
// Source: C3D user guide, "The Header Section", "Reading the frame count", "POINT:DATA_START", www.c3d.org.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "error/error.hpp"
#include "pipeline/recordings/c3d_parameters.hpp"

namespace borelli {

struct C3dLayout {
  std::uint64_t points = 0;    ///< per frame
  std::uint64_t channels = 0;  ///< analog channels
  std::uint64_t samples = 1;   ///< of each channel per frame
  std::uint64_t frames = 0;
  std::uint64_t data = 0;  ///< byte of the first frame
  bool real = false;       ///< 32-bit floating-point numbers; else 16-bit integers
  double scale = 1;        ///< positive; unit of integer coordinates and of residuals, in POINT:UNITS
  double rate = 0;         ///< frames per second
  double first_frame = 1;  ///< number of the first frame; its time is (first_frame - 1) / rate

  std::uint64_t number_bytes() const { return real ? 4 : 2; }
  std::uint64_t frame_bytes() const { return (4 * points + channels * samples) * number_bytes(); }
};

/// Lays out the frames of the file `bytes`, of at least 512 bytes.
///
/// Precedence: the parameters (POINT:USED, ANALOG:USED, POINT:FRAMES, POINT:RATE, POINT:DATA_START) override
/// the header, as the user guide says. The scale is the header's, since programs read that one and it is
/// right in files with another POINT:SCALE. If the frames then do not fit in the file or do not end in its
/// last block, variants that fit better replace this, with a warning, in this order: the sign of POINT:SCALE,
/// the header's count of frames, the whole header.
///
/// The count of frames: POINT:FRAMES, unless it is 65535 or differs from TRIAL's by a multiple of 65536; then
/// POINT:LONG_FRAMES, then TRIAL:ACTUAL_START_FIELD and ACTUAL_END_FIELD, whose two words are one 32-bit
/// number. (The guide's factor 65535 for the second word contradicts its own "32-bit value".)
///
/// Errors about `file`: frames that do not fit in it, no points and no channels, no rate, no scale.
Result<C3dLayout> c3d_layout(std::string_view bytes, C3dProcessor processor, const C3dParameters& parameters,
                             const std::string& file, std::vector<std::string>& warnings);

}  // namespace borelli
