// The anterior superior iliac spines.
#pragma once

#include "segmentation/joints/limbs.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

/// Puts `asis_*` on the foremost bone of the pelvis over each of the two hips. Two that do not mirror each
/// other are both as unsure as they differ.
void find_iliac_spines(const Anatomy& anatomy, const Trunk& trunk, const Limbs& limbs, Landmarks& marks);

/// The same where no hips are in view, which would stand about `level` (mm, patient z).
void find_iliac_spines_about(const Anatomy& anatomy, const Trunk& trunk, const Limbs& limbs, double level,
                             Landmarks& marks);

}  // namespace borelli
