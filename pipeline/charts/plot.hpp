// Line plots as SVG for a page or a paper, and the CSV of what they draw. Colours after Okabe & Ito (2008,
// jfly.uni-koeln.de/color: told apart by the colour-blind), each with a dash of its own so that grey print
// serves too.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace borelli {

struct Axis {
  std::string label;         ///< with its unit, e.g. "time (s)"
  bool logarithmic = false;  ///< values that are not positive are left out
  std::optional<double> low = {},
                        high = {};  ///< the range drawn; where absent, the data's, widened to round numbers
  bool whole_numbers = false;       ///< ticks at whole numbers only (counts)
  std::vector<double> ticks = {};   ///< where they stand; empty: at round numbers
};

struct Curve {
  std::string name;
  std::vector<double> x = {}, y = {};  ///< of equal length; a value that is not finite breaks the line
  bool marks = false;  ///< at every point a dot (of the eighth curve on a square, a triangle of the 15th)
  std::vector<std::string> tips = {};  ///< per point, what a page shows of it under the pointer
  std::vector<bool> hollow = {};       ///< per point: its dot is an empty one
  bool faint = false;                  ///< thin and grey, and not in the legend
  std::size_t number = 0;  ///< of a faint one: stands beside a point of it where there is room; 0: none
  bool broad = false;      ///< a pale band behind the others
};

/// What came to no value: a cross at the upper edge.
struct EdgeMark {
  double x;
  std::string curve, tip;
};

/// A rectangle of a map, filled by its kind.
struct Tile {
  double x_low, x_high, y_low, y_high;
  std::size_t kind;  ///< in Plot::kinds
  std::string tip = {};
};

struct Plot {
  std::string title;
  Axis x, y;
  std::vector<Curve> curves;
  std::vector<std::string> notes = {};  ///< sentences set small below the plot
  std::vector<EdgeMark> edge = {};
  std::vector<Tile> tiles = {};  ///< behind the curves; the axes' ranges must be given
  /// What tiles are of: at most nine, each with a colour and hatching of its own by its place here, so that
  /// one list serves several maps. The legend names those that occur.
  std::vector<std::string> kinds = {};
};

/// The plot as a self-contained SVG document, 720 wide and as high as its notes need.
std::string svg(const Plot& plot);

/// Columns x, curve 1, curve 2 ... where all curves share their x; else curve, x, y in long form. Numbers
/// with 17 significant digits; the notes stand above as lines that begin with '#'.
std::string csv(const Plot& plot);

}  // namespace borelli
