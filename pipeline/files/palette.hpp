// One colour per body part, the same in meshes, pictures and report.
//
// A left part has the lighter, its right twin the darker shade of one hue. A search over sRGB kept each part
// near its hue and maximised the smallest CIEDE2000 distance between parts, in normal vision and in the three
// dichromacies (protan, deutan, tritan; Machado, Oliveira & Fernandes (2009) IEEE TVCG 15:1291, severity 1).
// Distances are at least 15 between parts that touch, 13 between left and right, 7 between any two.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string_view>

#include "segmentation/labelling/segments.hpp"
#include "segmentation/vocabulary/parts.hpp"

namespace borelli {

/// An sRGB colour (as in CSS and PNG), 0 to 255 each.
struct Colour {
  std::uint8_t red = 0;
  std::uint8_t green = 0;
  std::uint8_t blue = 0;

  constexpr bool operator==(const Colour&) const = default;
};

/// part_colours[label], in the order of `parts`; label 0 (outside) is the grey of everything that is not a
/// body part.
inline constexpr std::array<Colour, parts.size()> part_colours{{
    {0x9a, 0x9a, 0x9a},  // outside
    {0xf6, 0xcc, 0x5a},  // head
    {0x24, 0x67, 0xd0},  // upper_trunk
    {0x9e, 0xc3, 0xe5},  // middle_trunk
    {0x09, 0x33, 0x8b},  // lower_trunk
    {0xed, 0xa4, 0x1a},  // upper_arm_left
    {0xba, 0x76, 0x14},  // upper_arm_right
    {0x0e, 0xa7, 0x7f},  // forearm_left
    {0x2d, 0x70, 0x55},  // forearm_right
    {0xf6, 0xa5, 0xc4},  // hand_left
    {0x9c, 0x5b, 0x86},  // hand_right
    {0xe7, 0x74, 0x5a},  // thigh_left
    {0xc4, 0x36, 0x08},  // thigh_right
    {0x9f, 0xe1, 0xec},  // shank_left
    {0x75, 0xa0, 0x9c},  // shank_right
    {0xab, 0x6f, 0xa1},  // foot_left
    {0x79, 0x0d, 0x40},  // foot_right
}};

/// Colour of a part by its name ("thigh_left"), or of a group by its first part; grey for other names.
constexpr Colour part_colour(std::string_view name) {
  if (const SegmentGroup* group = segment_group(name)) name = group->parts.front();
  return part_colours[static_cast<std::size_t>(part_label(name))];
}

/// Colour of the n-th name that is not a body part: hues a golden angle apart, so that neighbours in a list
/// differ most.
inline Colour other_colour(std::size_t n) {
  const double hue = std::fmod(static_cast<double>(n) * 0.618034, 1.0);
  const auto channel = [&](double shift) {
    const double x = std::abs(std::fmod(hue + shift, 1.0) * 6 - 3) - 1;
    return static_cast<std::uint8_t>(255 * (0.35 + 0.55 * std::clamp(x, 0.0, 1.0)));
  };
  return {channel(0), channel(2.0 / 3), channel(1.0 / 3)};
}

}  // namespace borelli
