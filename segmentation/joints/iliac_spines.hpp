// The anterior superior iliac spines.
#pragma once

#include "segmentation/joints/limbs.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

/// Adds `asis_*` at the foremost bone of the pelvis above each hip. If the two are not mirror images, their
/// distance from symmetry becomes the deviation of both.
void find_iliac_spines(const Anatomy& anatomy, const Trunk& trunk, const Limbs& limbs, Landmarks& marks);

/// The same if no hips are in view; `level` is their estimated height (mm, patient z).
void find_iliac_spines_about(const Anatomy& anatomy, const Trunk& trunk, const Limbs& limbs, double level,
                             Landmarks& marks);

}  // namespace borelli
