// Elbows outside the field of view, of arms whose flesh distal to the elbow is in view.
#pragma once

#include "segmentation/body/anatomy.hpp"
#include "segmentation/joints/limbs.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

/// Adds elbow_left or elbow_right (mm, LPS) if the scan's side cuts the arm at its elbow, none was found, and
/// flesh of the arm lies distal to the estimated place. The elbow lies on the line of the visible humerus, as
/// far from the humeral head as on the other arm. If that elbow was not found either, the distance is de
/// Leva's (1996, Table 4: 281.7 mm of a man of 1.741 m) times the body's size. The source begins with
/// "proportion". `owner`: part label of each voxel of the work grid (parts.hpp). Adds none to an arm that
/// ends above its elbow, nor to one whose forearm the user names as absent.
void place_missing_elbows(const Anatomy& anatomy, const Limbs& limbs, const Volume<std::uint8_t>& owner,
                          const Trunk& trunk, Landmarks& landmarks);

}  // namespace borelli
