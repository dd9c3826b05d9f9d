// Levels of the vertebral column at which dempster and bone part the trunk: the discs T12/L1, L4/L5 and
// L5/S1.
//
// They are placed by proportion between the hips and the neck (C7/T1): at 0.485, 0.27 and 0.212 of that way.
// So they lie in the ICRP 110 male, whose vertebrae are labelled, between hips and neck as we find them
// (0.480, 0.267, 0.213); our phantom, drawn without regard to it, has 0.493, 0.242 and 0.175. Half a
// vertebra, 15 mm, is their deviation; a landmark given by hand (--landmarks) takes their place.
#pragma once

#include "segmentation/body/anatomy.hpp"
#include "segmentation/joints/trunk.hpp"
#include "segmentation/vocabulary/convention.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

/// Adds t12_l1, l4_l5 and l5_s1 where hips and neck are known and the scan holds their level; those that are
/// there stay.
void find_column_levels(const Anatomy& anatomy, const Trunk& trunk, Landmarks& landmarks);

/// Moves spine_upper and spine_lower, the joints of the trunk's parts, to the discs by which the convention
/// parts them; with deleva1996 they stay at the levels of xiphion and omphalion.
void seat_spine_joints(Convention convention, Landmarks& landmarks);

}  // namespace borelli
