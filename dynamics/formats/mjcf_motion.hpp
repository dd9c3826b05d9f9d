// Decides which unread elements and attributes of MJCF change the motion. Those that <flag> switches off do
// not.
#pragma once

#include "dynamics/formats/unread.hpp"

namespace borelli {

MotionRules mjcf_motion_rules();

/// What the <flag> of <option> leaves switched on.
struct MjcfSwitches {
  bool equality = true, contact = true, limits = true, friction_loss = true, actuation = true;
};

/// Marks elements and attributes as read that are switched off.
void mark_switched_off(const XmlElement& root, const MjcfSwitches& switches);

}  // namespace borelli
