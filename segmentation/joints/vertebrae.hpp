// Vertebrae: centres of their bodies, and the disc and spinous process at the base of the neck.
#pragma once

#include <optional>

#include "segmentation/body/anatomy.hpp"
#include "segmentation/joints/trunk.hpp"

namespace borelli {

/// The centre of the spine at a level (mm, patient z; result LPS): midway between the faces of the vertebral
/// bodies just above and below it, front to back (the spinal canal behind is soft) and side to side. With
/// `neck`, the front face locates the body, since cervical bodies are hardly thicker than their arches.
/// Elsewhere contrast-filled vessels in front may be as dense as bone.
Eigen::Vector3d vertebral_body(const Anatomy& anatomy, const Trunk& trunk, double z, bool neck = false);

/// Upper edge (mm, patient z) of the first rib beside the spine, searched upwards from the chest to 75 mm (in
/// an adult) above `near`. Bone counts only where both sides show it, unless the scan shows one side alone.
/// Empty if the scan's top cuts the chest.
std::optional<double> first_rib(const Anatomy& anatomy, const Trunk& trunk, double near);

/// Centre (mm, patient z, interpolated) of the disc that best combines depth of the dip and nearness to
/// `level`, whose standard deviation is `spread` mm. It lies less than half a vertebra from `level`. Empty if
/// the scan does not resolve discs.
std::optional<double> disc_near(const Anatomy& anatomy, const Trunk& trunk, double level, double spread);

/// The disc C7/T1 where thick slices miss it: the gap between two slices nearest to the level that the discs
/// C6/C7 above and T1/T2 below give, or one of them together with `level` (mm, patient z). Empty if neither
/// disc is in view.
std::optional<double> disc_between_slices(const Anatomy& anatomy, const Trunk& trunk, double level);

/// Tip of the spinous process of C7: the hindmost bone behind the disc between C7 and T1 (mm, LPS; those of
/// C6 and T1 end a vertebra's height above and below). `scale`: the body's size, see Trunk. Empty if no bone
/// is found.
std::optional<Eigen::Vector3d> spinous_tip(const Anatomy& anatomy, const Eigen::Vector3d& disc, double scale);

}  // namespace borelli
