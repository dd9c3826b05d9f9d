// Judges each part: whole or cut, how certain its bounds are, and what a person should check.
#pragma once

#include <cstdint>

#include "segmentation/body/anatomy.hpp"
#include "segmentation/joints/trunk.hpp"
#include "segmentation/labelling/segment.hpp"
#include "segmentation/vocabulary/part_planes.hpp"

namespace borelli {

/// Fills `out.part` from its labels and landmarks. A part is cut if the scan's edge cuts it, if no plane
/// separates it from the next part of its limb, or if its share of the other whole parts is anatomically
/// impossible. Confidence falls with the deviation of the bounding landmarks, and where skin touches skin of
/// another limb. Ends of hands and feet that the scan cuts are removed from the landmarks. `owner`: the part
/// whose flesh each voxel of the work grid is. `gone`: parts that the body lacks, given as absent or found
/// so; their missing joints raise no doubt.
void judge_parts(const Anatomy& anatomy, const Volume<std::uint8_t>& owner, const PartPlanes& planes,
                 const AbsentParts& gone, Segmentation& out);

/// Warns of the missing limb if only one leg or one arm is found and the other is not given as absent.
void warn_of_lone_limbs(const Trunk& trunk, Segmentation& out);

/// For arms whose bones touch: hands of unequal volume are doubtful, because one may hold part of the other.
void doubt_hands_that_meet(Segmentation& out);

/// For a scan that shows the hips but not the shoulders. No joint connects the arms in view, so trunk or
/// thighs may contain their flesh, unless the forest labelled the arms. Slices above the hips (level `hips`, mm) may show pieces beside the trunk:
/// a part that contains such pieces is marked cut. So are the thighs if the pieces reach down to them.
void doubt_what_holds_arms(const Anatomy& anatomy, const Volume<std::uint8_t>& owner,
                           const PartPlanes& planes, double hips, Segmentation& out);

/// For scans of legs alone, joined at the scan's upper end: the thighs contain the visible piece of the lower
/// trunk.
void doubt_thighs_above_crotch(const Anatomy& anatomy, const Volume<std::uint8_t>& owner, Segmentation& out);

/// For scans of a head alone: what lies below the neck is a piece of the upper trunk with shoulders and arms.
void doubt_trunk_without_shoulders(Segmentation& out);

/// For scans that show the shoulders but no hip landmarks: a lower trunk that reaches down to the thighs may
/// contain them. `scale`: as in Trunk.
void doubt_trunk_without_hips(const Anatomy& anatomy, const Volume<std::uint8_t>& owner,
                              const PartPlanes& planes, double scale, Segmentation& out);

/// Adds a warning if more than a small share of the body in view belongs to no part.
void warn_of_flesh_without_part(const Anatomy& anatomy, const Volume<std::uint8_t>& owner, Segmentation& out);

}  // namespace borelli
