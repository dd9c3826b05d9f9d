// Values of a sweep.
#pragma once

#include <string>
#include <vector>

#include "error/error.hpp"

namespace borelli {

struct Ladder {
  std::vector<double> values;  ///< rising
  bool logarithmic = false;    ///< values have a constant ratio
};

/// Parses "LOW:HIGH", "LOW:HIGH:COUNT", "LOW:HIGH:COUNT:log" (or ":linear"), "A,B,C" or "A". Without "log" or
/// "linear", positive bounds a factor of ten or more apart give a constant ratio, otherwise a constant
/// difference. Without COUNT there are four values per decade (at most `count`), or `count` values. `what`
/// names the ladder in errors.
Result<Ladder> parse_ladder(const std::string& text, const std::string& what, int count = 17);

/// Bounds of each value's tile on a map: half way to its neighbours (geometric mean if logarithmic). One
/// value more than the ladder has.
std::vector<double> tile_bounds(const Ladder& ladder);

}  // namespace borelli
