// What a run says of the joints that leave their ranges: one sentence, where the certificate has a note and
// an event for each.
#pragma once

#include <string>
#include <vector>

#include "dynamics/system/certificate.hpp"
#include "dynamics/system/system.hpp"

namespace borelli {

/// The certificate's notes, with those of ranges merged into one sentence at their head: how many joints
/// leave theirs, and which is the first, about which of its axes, where and when; angles in degrees, lengths
/// in m.
std::vector<std::string> warnings_of(const Certificate& certificate, const System& system);

}  // namespace borelli
