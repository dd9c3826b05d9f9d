// Bony points that only the ISB's segment frames use (Wu G et al (2002) J Biomech 35:543, (2005) 38:981).
#pragma once

#include "segmentation/body/anatomy.hpp"
#include "segmentation/joints/limbs.hpp"
#include "segmentation/joints/trunk.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

/// Adds the points below, each if the scan shows its bone and the landmarks in brackets are known:
///   psis_*              hindmost point of the iliac wing beside the sacrum (hips)
///   t8                  tip of the spinous process at the disc T8/T9 (hips, neck), whose level comes
///                       from the discs in view, else from proportion
///   ulnar_styloid_*, radial_styloid_*
///                       distal ends of ulna and radius (elbow, wrist)
///   metatarsal_1_*, _2_*, _5_*
///                       centres of the metatarsal heads (heel, toe tip, malleoli)
/// `owner`: part label of each voxel of the work grid (parts.hpp). It keeps out the bones of a hand beside
/// the hip or of the other foot.
void find_frame_points(const Anatomy& anatomy, const Trunk& trunk, const Volume<std::uint8_t>& owner,
                       Landmarks& landmarks);

}  // namespace borelli
