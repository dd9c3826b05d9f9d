// A segment's length and anatomical axes, from the body's landmarks.
//
// Endpoints after de Leva (1996) J Biomech 29:1223; axes as the ISB defines them (Wu et al (2002) J Biomech
// 35:543, (2005) 38:981), with the nearest of our landmarks if theirs are missing. Y runs along the segment;
// X is normal to Y and the given line; Z = X x Y.
//   segment       endpoints                  Y                                      line
//   head          VERT-CERV                  neck to vertex                         the trunk's right
//   upper trunk   SUPR-XYPH, else CERV-XYPH  the trunk's up: hips' middle to neck   the hips' line
//   middle trunk  XYPH-OMPH                  the same                               the same
//   lower trunk   OMPH-MIDH                  the same                               the same
//   upper arm     SJC-EJC                    elbow to shoulder                      the elbow's epicondyles
//   forearm       EJC-WJC                    wrist to elbow                         the elbow's epicondyles
//   hand          WJC-MET3                   knuckle to wrist                       X along largest moment's
//                                                                                   axis (through the palm)
//   thigh         HJC-KJC                    knee to hip                            the knee's epicondyles
//   shank         KJC-AJC, else KJC-LMAL     ankle to knee                          the malleoli, else the
//                                                                                   knee's epicondyles
//   foot          HEEL-TTIP                  up to the ankle, square to X           X from heel to toe
// Groups (segmentation/labelling/segments.hpp): the trunk has the axes of its parts and the endpoints
// SUPR-MIDH, else CERV-MIDH. An arm or leg has the axes of upper arm or thigh, and no length.
// If a line is missing, the trunk's right replaces it, and `axes` says so. If the neck or a hip is missing,
// the patient's axes replace the trunk's.
#pragma once

#include <optional>
#include <string_view>

#include "inertia/table.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

/// SegmentFrame::axes of a part of the trunk when the patient's axes replace the trunk's.
inline constexpr std::string_view patients_axes = "the patient's, because the neck or a hip is missing";

/// Frame of a part (as in parts.hpp) or of a group of parts; points in metres. Empty if the points of its Y
/// axis (foot: X axis) are missing; for the trunk, if both the points of its axes and an endpoint are
/// missing. With an endpoint missing it has axes but no length. `cuts`: the convention that cut the labels.
/// For "deleva1996" each plane gets its published name (zatsiorsky, joint); other names are kept. `inertial`:
/// of the part, in patient axes; only a hand's axes need it.
std::optional<SegmentFrame> segment_frame(std::string_view part, const Landmarks& landmarks,
                                          const Inertial& inertial, std::string_view cuts = "deleva1996");

/// What a reader should know of the endpoints, e.g. that one was placed by proportion. Leaves out what the
/// segmentation already told (`known`) ("omphalion placed by proportion").
std::vector<std::string> endpoint_notes(const SegmentFrame& frame, std::string_view part,
                                        const Landmarks& landmarks, std::string_view known = {});

}  // namespace borelli
