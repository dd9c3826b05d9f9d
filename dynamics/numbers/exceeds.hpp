// The maximum of numbers that may include NaN.
#pragma once

#include <cmath>

namespace borelli {

/// Whether `part` replaces the running maximum `most`: it is larger, or NaN. A maximum of NaN stays.
inline bool exceeds(double part, double most) { return !(part <= most) && !std::isnan(most); }

}  // namespace borelli
