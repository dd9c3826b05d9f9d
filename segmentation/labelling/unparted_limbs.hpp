// Limb parts that contain the next part too, because no joint was found between them.
#pragma once

#include "segmentation/body/anatomy.hpp"
#include "segmentation/joints/limbs.hpp"
#include "segmentation/labelling/segment.hpp"
#include "segmentation/vocabulary/part_planes.hpp"

namespace borelli {

/// Marks stumps: a part whose child is given as absent is cut. Absent parts get the note `stated_as_absent`.
void note_stumps(Segmentation& out);

/// Marks limb parts that end within the scan without a plane at their far joint: they contain the next part
/// too.
void note_missing_cuts(const PartPlanes& planes, Segmentation& out);

/// Doubts limb parts that the scan cuts and whose far joint is not known, if they are too long. Limits: the
/// other side's length; for a thigh without a hip landmark, the other side's knee; for arms that both lack
/// their elbow, the upper arm of an adult of that size.
void doubt_unparted_limbs(Segmentation& out);

/// Doubts forearms and shanks that the scan cuts and whose two joints are unknown. If one end lies in view,
/// the part includes the hand or foot. If the scan cuts both ends, the part may include some of it.
void doubt_jointless_limbs(const Anatomy& anatomy, Segmentation& out);

/// Doubts the head if the scan's side cuts a raised arm before its wrist: the hand may lie on the head and be
/// labelled as head.
void doubt_head_under_arms(const Anatomy& anatomy, const Limbs& limbs, Segmentation& out);

}  // namespace borelli
