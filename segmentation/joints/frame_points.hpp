// Bony points on which nothing but the ISB's segment frames hangs (Wu G et al (2002) J Biomech 35:543, (2005)
// 38:981).
#pragma once

#include "segmentation/body/anatomy.hpp"
#include "segmentation/joints/limbs.hpp"
#include "segmentation/joints/trunk.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

/// Adds the points below, each if the scan shows its bone and the landmarks in brackets are known:
///   psis_*              hindmost point of the ilium's wing beside the sacrum (hips)
///   t8                  tip of the spinous process at the disc T8/T9, whose level is by proportion (hips, neck)
///   ulnar_styloid_*, radial_styloid_*
///                       ends of ulna and radius (elbow, wrist)
///   metatarsal_1_*, _2_*, _5_*
///                       middles of the heads (heel, toe tip, malleoli)
/// `owner`: whose flesh each place of the work grid is (labels as in parts.hpp), so that a hand's bones
/// beside the hip or the other foot's count for nothing.
void find_frame_points(const Anatomy& anatomy, const Trunk& trunk, const Volume<std::uint8_t>& owner,
                       Landmarks& landmarks);

}  // namespace borelli
