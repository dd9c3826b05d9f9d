// A segment's length and anatomical axes, from the body's landmarks.
//
// Endpoints after de Leva (1996) J Biomech 29:1223; axes as the ISB has them (Wu et al (2002) J Biomech
// 35:543, (2005) 38:981), with the nearest of our landmarks where theirs are missing. Y runs along the segment; X is
// normal to Y and the line given; Z = X x Y.
//   segment       endpoints                  Y                                      line
//   head          VERT-CERV                  neck to vertex                         the trunk's right
//   upper trunk   SUPR-XYPH, else CERV-XYPH  the trunk's up: hips' middle to neck   the hips' line
//   middle trunk  XYPH-OMPH                  the same                               the same
//   lower trunk   OMPH-MIDH                  the same                               the same
//   upper arm     SJC-EJC                    elbow to shoulder                      the elbow's epicondyles
//   forearm       EJC-WJC                    wrist to elbow                         the elbow's epicondyles
//   hand          WJC-MET3                   knuckle to wrist                       X along the hand's axis of
//                                                                                   largest moment (through the palm)
//   thigh         HJC-KJC                    knee to hip                            the knee's epicondyles
//   shank         KJC-AJC, else KJC-LMAL     ankle to knee                          the malleoli, else the knee's
//                                                                                   epicondyles
//   foot          HEEL-TTIP                  up to the ankle, square to X           X from heel to toe
// Of groups (segmentation/labelling/segments.hpp) the trunk has the axes of its parts and SUPR-MIDH, else
// CERV-MIDH; an arm and a leg have those of upper arm and thigh, and no length.
// Where a line is missing, the trunk's right stands in, and `axes` says so; where the neck or a hip is, the
// patient's axes stand in for the trunk's.
#pragma once

#include <optional>
#include <string_view>

#include "inertia/table.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

/// SegmentFrame::axes of a part of the trunk where the patient's axes stand in.
inline constexpr std::string_view patients_axes = "the patient's, for want of the neck or a hip";

/// The frame of a part (as in parts.hpp) or a group of parts, points in metres. Nothing where the points of
/// its Y axis (of a foot: its X) are not there, or for the trunk neither those of its axes nor both
/// endpoints. Without both endpoints it has axes but no length. `cuts` is the convention that the labels were
/// cut by: of "deleva1996" the planes are told apart as published (zatsiorsky, joint), another name stands as
/// it is. `inertial`: of the part, in patient axes; only a hand's axes need it.
std::optional<SegmentFrame> segment_frame(std::string_view part, const Landmarks& landmarks,
                                          const Inertial& inertial, std::string_view cuts = "deleva1996");

/// What a reader should know of the endpoints, e.g. that one was placed by proportion; but not what the
/// segmentation `told` already ("omphalion placed by proportion").
std::vector<std::string> endpoint_notes(const SegmentFrame& frame, std::string_view part,
                                        const Landmarks& landmarks, std::string_view told = {});

}  // namespace borelli
