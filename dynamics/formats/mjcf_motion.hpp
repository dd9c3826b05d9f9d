// Which unread elements and attributes of MJCF change the motion.
#pragma once

#include "dynamics/formats/unread.hpp"

namespace borelli {

MotionRules mjcf_motion_rules();

}  // namespace borelli
