// Values that a sweep goes through.
#pragma once

#include <string>
#include <vector>

#include "error/error.hpp"

namespace borelli {

struct Ladder {
  std::vector<double> values;  ///< rising
  bool logarithmic = false;    ///< evenly spaced by their ratio
};

/// "LOW:HIGH", "LOW:HIGH:COUNT", "LOW:HIGH:COUNT:log" (or ":linear"), "A,B,C" or "A". Where it is not said,
/// values from positive bounds ten times apart or more are evenly spaced by ratio, four to a decade (at most
/// `count`), others by difference, `count` of them. `what` names it in errors.
Result<Ladder> parse_ladder(const std::string& text, const std::string& what, int count = 17);

/// The bounds of each value's tile on a map: half way to its neighbours (by ratio where it is logarithmic).
/// One value more than the ladder has.
std::vector<double> tile_bounds(const Ladder& ladder);

}  // namespace borelli
