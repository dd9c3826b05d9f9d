// Colours, dashes and shapes of a plot, for its drawing as SVG and on a page. Colours after Okabe & Ito
// (2008, jfly.uni-koeln.de/color), which colour-blind people can tell apart.
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "pipeline/charts/plot.hpp"

namespace borelli {

struct CurveStyle {
  std::string_view colour;  ///< #RRGGBB
  std::string_view dash;    ///< lengths of strokes and gaps in pixels, by blanks; "none": a full line
  int shape = 0;            ///< of its marks: 0 dot, 1 square, 2 triangle
};

/// By the plot's curves. A curve without a group has a colour of its own; those of one group share theirs and
/// differ in dash and shape. Curves of the same colour have different dashes.
std::vector<CurveStyle> curve_styles(const Plot& plot);

/// Fill of a kind of tiles; its hatching distinguishes it in grey print.
struct TileFill {
  std::string_view colour, hatch;  ///< #RRGGBB; path in a square of 8 pixels, empty: none
};

/// By Plot::kinds, from pale to dark.
inline constexpr std::array<TileFill, 9> tile_fills{{{"#E6F3EC", ""},
                                                     {"#F5EDA0", ""},
                                                     {"#56B4E9", ""},
                                                     {"#E69F00", ""},
                                                     {"#CC79A7", "M-2 10L10 -2"},
                                                     {"#1A1A1A", ""},
                                                     {"#D55E00", "M-2 -2L10 10"},
                                                     {"#FFFFFF", "M0 0L8 8M0 8L8 0"},
                                                     {"#D9D9D9", "M4 3v2"}}};

}  // namespace borelli
