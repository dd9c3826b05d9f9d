// Elbows that the field of view leaves out, where flesh beyond them is in view.
#pragma once

#include "segmentation/body/anatomy.hpp"
#include "segmentation/joints/limbs.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

/// Where the scan's side cuts an arm at its elbow, so that no elbow was found but flesh of the arm lies
/// beyond where it must be: adds elbow_left or elbow_right (mm, LPS), on the line from the humeral head along
/// what shows of the humerus, as far from the head as the other arm's elbow from its own. Where the other one
/// was not found either: as far as in de Leva (1996), Table 4 (281.7 mm of a man of 1.741 m), by the body's
/// size. The source begins with "proportion". `owner`: whose flesh each place of the work grid is (labels as
/// in parts.hpp). An arm that ends above its elbow gets none, nor does one that is told to.
void place_missing_elbows(const Anatomy& anatomy, const Limbs& limbs, const Volume<std::uint8_t>& owner,
                          const Trunk& trunk, Landmarks& landmarks);

}  // namespace borelli
