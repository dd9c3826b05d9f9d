// What each part is worth: whole or cut, how sure its bounds are, and what a person should look at.
#pragma once

#include <cstdint>

#include "segmentation/body/anatomy.hpp"
#include "segmentation/joints/trunk.hpp"
#include "segmentation/labelling/segment.hpp"
#include "segmentation/vocabulary/part_planes.hpp"

namespace borelli {

/// Fills `out.part` from its labels and landmarks. A part is cut where the scan's edge cuts it, where no
/// plane parts it from the next one of its limb, and where its share beside the other whole parts is none
/// that a body has; its confidence falls with the deviation of what bounds it, and where it touches what it
/// does not join. Ends of hands and feet that the scan cuts are taken out of the landmarks.
/// `owner`: whose flesh each place of the work grid is; `gone`: parts that the body lacks, told or not, whose
/// missing joints doubt nothing.
void judge_parts(const Anatomy& anatomy, const Volume<std::uint8_t>& owner, const PartPlanes& planes,
                 const AbsentParts& gone, Segmentation& out);

/// Of a body that shows one leg or one arm alone, and of which nothing is told to be absent: what it lacks.
void warn_of_lone_limbs(const Trunk& trunk, Segmentation& out);

/// Where the bones of the arms meet, hands of unlike size are not each one hand alone.
void doubt_hands_that_meet(Segmentation& out);

/// Of a scan that shows the hips and not the shoulders: arms in view hang on nothing that was found, and
/// their flesh may have gone to the trunk and the thighs. Where slices above the hips (level `hips`, mm) show
/// pieces beside the trunk that a part holds, this part is cut, and thighs too where such pieces reach down
/// to them.
void doubt_what_holds_arms(const Anatomy& anatomy, const Volume<std::uint8_t>& owner,
                           const PartPlanes& planes, double hips, Segmentation& out);

/// Of legs alone whose flesh is one at the scan's upper end: what is there of the lower trunk is the thighs'.
void doubt_thighs_above_crotch(const Anatomy& anatomy, const Volume<std::uint8_t>& owner, Segmentation& out);

/// Of a head alone: what lies below its neck is a piece of the upper trunk, with shoulders and arms in it.
void doubt_trunk_without_shoulders(Segmentation& out);

/// Of a scan that shows the shoulders, but of the pelvis nothing that tells where thighs begin: a lower trunk
/// that reaches down to them may hold them. `scale` as Trunk's.
void doubt_trunk_without_hips(const Anatomy& anatomy, const Volume<std::uint8_t>& owner,
                              const PartPlanes& planes, double scale, Segmentation& out);

/// Adds a warning where more than a little of the body in view is nobody's.
void warn_of_flesh_without_part(const Anatomy& anatomy, const Volume<std::uint8_t>& owner, Segmentation& out);

}  // namespace borelli
