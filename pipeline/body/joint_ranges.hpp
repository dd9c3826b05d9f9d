// Published ranges of motion of human joints (pipeline/data/joint_ranges.csv names the source).
#pragma once

#include <map>
#include <string>

#include "dynamics/scene/switch.hpp"

namespace borelli {

/// Ranges in rad; keys are joint without side and motion, e.g. "knee flexion".
const std::map<std::string, Range>& joint_ranges();

}  // namespace borelli
