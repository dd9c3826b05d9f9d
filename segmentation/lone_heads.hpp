// The hip and the shoulder of a body that lacks the other leg or arm: no pair tells them, and what the trunk
// needs of the side that is gone is their mirror image.
#pragma once

#include "segmentation/heads_in_body.hpp"
#include "segmentation/landmarks.hpp"
#include "segmentation/round_heads.hpp"
#include "segmentation/trunk.hpp"

namespace borelli {

/// Where the trunk has no hips: the one that is there, over its femur and below the lungs (or the shoulders
/// that were found), and the other as its mirror image, with `no_leg` set there. The other leg must be told
/// to be absent, or none be seen: no bone of a thigh beside this one's, where the scan shows the place.
void find_lone_hip(const Anatomy& anatomy, const HeadsInBody& body, RoundHeads& candidates, Trunk& trunk);

/// The same of a shoulder, over two hips; of a pair that was found one is none where nothing of an arm lies
/// beside the chest. `no_arm` is set there.
void find_lone_shoulder(const Anatomy& anatomy, const HeadsInBody& body, RoundHeads& candidates,
                        Trunk& trunk);

/// What the body lacks, told or not, with all that hangs on it.
AbsentParts gone_parts(const Trunk& trunk);
std::array<bool, 2> sides_without_leg(const Trunk& trunk);

/// The hips' middle of a body with one leg, by that leg's hip and its mirror image.
void put_middle_of_hips(const Trunk& trunk, Landmarks& marks);

/// The mirror images again, in the plane that the column tells.
void settle_lone_heads(Trunk& trunk);

}  // namespace borelli
