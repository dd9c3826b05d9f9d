// Segment frames as the International Society of Biomechanics recommends them (Wu G et al (2002) J Biomech
// 35:543-548, (2005) 38:981-992), from the landmarks that define them.
//
// X forwards, Y up, Z to the right on both sides of the body. So lines across a left limb run from lateral to
// medial:
//   lower trunk  origin mid-ASIS; Z from left to right ASIS, Y = Z x (mid-ASIS - mid-PSIS)
//   upper trunk  suprasternale; Y from (xiphion, T8)'s to (suprasternale, C7)'s middle,
//                Z = (suprasternale - C7) x Y
//   upper arm    shoulder centre; Y from the epicondyles' middle to it, X = Y x the epicondyles' line
//   forearm      ulnar styloid; Y from it to the epicondyles' middle, X normal to the plane with the radial
//                styloid
//   thigh        hip centre; Y from the epicondyles' middle to it, X normal to the plane of the three
//   shank        middle of the malleoli; Y from it to the epicondyles' middle, X = Y x the malleoli's line
//   foot         heel; X to the middle of metatarsal heads I and V, Y normal to heel, II and V
// A landmark may be missing (neither found, see segmentation/README.md, nor given by hand). Then the segment
// keeps its joint-based frame, and `axes` names the missing landmark. Head, abdomen and hand have no ISB
// frame here.
#pragma once

#include <string>
#include <string_view>

#include "inertia/table.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

/// Replaces a segment's axes by the ISB's and sets its origin. If a landmark is missing the frame stays, its
/// `axes` say so, and the landmark's name is returned. `part` as in parts.hpp.
std::string lay_isb_frame(SegmentFrame& frame, std::string_view part, const Landmarks& landmarks);

}  // namespace borelli
