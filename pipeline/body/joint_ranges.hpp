// How far human joints turn (pipeline/data/joint_ranges.csv, which names its source).
#pragma once

#include <map>
#include <string>

#include "dynamics/scene/switch.hpp"

namespace borelli {

/// Ranges by joint without its side and axis, e.g. "knee flexion"; rad.
const std::map<std::string, Range>& joint_ranges();

}  // namespace borelli
