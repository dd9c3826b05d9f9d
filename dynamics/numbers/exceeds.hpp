// The largest of numbers that may not all be numbers.
#pragma once

#include <cmath>

namespace borelli {

/// Whether `part` is to take the place of the largest so far: it is larger, or not a number, which then
/// stays.
inline bool exceeds(double part, double most) { return !(part <= most) && !std::isnan(most); }

}  // namespace borelli
