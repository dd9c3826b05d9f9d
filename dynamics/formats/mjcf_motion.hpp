// Which unread elements and attributes of MJCF change the motion.
// What <flag> switches off does not.
#pragma once

#include "dynamics/formats/unread.hpp"

namespace borelli {

MotionRules mjcf_motion_rules();

/// What the <flag> of <option> leaves switched on.
struct MjcfSwitches {
  bool equality = true, contact = true, limits = true, friction_loss = true, actuation = true;
};

/// Marks as read what is switched off.
void mark_switched_off(const XmlElement& root, const MjcfSwitches& switches);

}  // namespace borelli
