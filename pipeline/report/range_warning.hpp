// Merges the certificate's notes on joints that leave their ranges into one sentence.
#pragma once

#include <string>
#include <vector>

#include "dynamics/system/certificate.hpp"
#include "dynamics/system/system.hpp"

namespace borelli {

/// The certificate's notes. Those on ranges become one sentence, placed first: how many joints leave their
/// ranges, and which joint is the first, about which axis, at which value and when. Angles in degrees,
/// lengths in m.
std::vector<std::string> warnings_of(const Certificate& certificate, const System& system);

}  // namespace borelli
