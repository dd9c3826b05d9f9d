// Contents of a warped body's voxels: contrast agent, metal, stumps and prostheses.
#pragma once

#include <cstdint>
#include <vector>

#include "tests/suite/labelled_body.hpp"
#include "tests/suite/warp.hpp"

namespace borelli::suite {

/// By number of the body's voxels.
struct WarpedTissue {
  std::vector<std::int16_t> hu, density;
  std::vector<std::uint8_t> gone;   ///< removed
  std::vector<std::uint8_t> thing;  ///< an object, not body
  std::vector<std::uint8_t> bone;
};

/// A stump's bone ends 25 mm before its flesh, under muscle; the last 4 mm are skin. A metal hip is the
/// femoral head, its socket's inside and a stem of 130 mm.
WarpedTissue warped_tissue(const LabelledBody& body, const Warp& warp);

/// Whether a part is another part or lies beyond it.
bool hangs_on(int part, int on);

}  // namespace borelli::suite
