// What of MJCF changes the motion, where the reader leaves it unread.
#pragma once

#include "dynamics/unread.hpp"

namespace borelli {

MotionRules mjcf_motion_rules();

}  // namespace borelli
