// Line plots as SVG for a page or a paper, and their data as CSV. Each colour has its own dash pattern for
// grey print (plot_style.hpp).
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
  bool whole_numbers = false;       ///< ticks only at whole numbers (counts)
  std::vector<double> ticks = {};   ///< tick positions; empty: at round numbers
};

struct Curve {
  std::string name;
  std::vector<double> x = {}, y = {};  ///< of equal length; a value that is not finite breaks the line
  bool marks = false;  ///< a dot at every point (from the eighth curve on a square, from the 15th a triangle)
  std::vector<std::string> tips = {};  ///< per point: the tip shown under the pointer
  std::vector<bool> hollow = {};       ///< per point: its dot is hollow
  bool faint = false;                  ///< thin and grey, not in the legend
  std::size_t number =
      0;  ///< of a faint curve: beside one of its points if there is room, and in a note; 0: none
  bool broad = false;      ///< a pale band behind the others
  std::string group = {};  ///< curves of one group share a colour; empty: a colour of its own
};

/// A run without a value: a cross at the upper edge.
struct EdgeMark {
  double x;
  std::string curve, tip;
};

/// A filled rectangle of a map.
struct Tile {
  double x_low, x_high, y_low, y_high;
  std::size_t kind;  ///< index into Plot::kinds
  std::string tip = {};
};

struct Plot {
  std::string title;
  Axis x, y;
  std::vector<Curve> curves;
  std::vector<std::string> notes = {};  ///< sentences set small below the plot
  std::vector<EdgeMark> edge = {};
  std::vector<Tile> tiles = {};  ///< behind the curves; the axes' ranges must be given
  /// Names of the tiles' kinds, at most nine. A kind's place here sets its colour and hatching, so one list
  /// serves several maps. The legend names only the kinds that occur.
  std::vector<std::string> kinds = {};
};

/// The plot as a self-contained SVG document, 720 wide and as high as its notes need.
std::string svg(const Plot& plot);

/// Columns x, curve 1, curve 2 ... if all curves share their x; otherwise long form: curve, x, y. Numbers
/// have 17 significant digits. The notes precede the table, on lines that begin with '#'.
std::string csv(const Plot& plot);

}  // namespace borelli
