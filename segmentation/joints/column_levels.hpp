// Levels of the discs T12/L1, L4/L5 and L5/S1, where the conventions dempster and bone divide the trunk.
//
// The levels are fixed fractions of the height from the hips to the neck (C7/T1): 0.485, 0.27 and 0.212. They
// come from the ICRP 110 male, whose vertebrae are labelled, with our own hip and neck landmarks (0.480,
// 0.267, 0.213). The standard deviation is half a vertebra, 15 mm. A landmark given by hand (--landmarks)
// takes precedence.
#pragma once

#include "segmentation/body/anatomy.hpp"
#include "segmentation/joints/trunk.hpp"
#include "segmentation/vocabulary/convention.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

/// Adds t12_l1, l4_l5 and l5_s1 if hips and neck are known and the spine in view contains their level. Keeps
/// those that already exist.
void find_column_levels(const Anatomy& anatomy, const Trunk& trunk, Landmarks& landmarks);

/// Moves spine_upper and spine_lower, the joints between the trunk's parts, to the discs of the convention;
/// erases a joint whose disc is missing. With deleva1996 they stay at the levels of xiphion and omphalion.
void seat_spine_joints(Convention convention, Landmarks& landmarks);

}  // namespace borelli
