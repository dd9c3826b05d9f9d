// Writes the motion of a scene as a BVH skeleton, for animation programs.
#pragma once

#include "dynamics/scene/scene.hpp"
#include "dynamics/system/trajectory.hpp"
#include "error/error.hpp"
#include "pipeline/recordings/bvh_file.hpp"

namespace borelli {

/// A skeleton with a joint for each solid, of its name, at the origin of the solid's frame. `motion` gives
/// times, solids and poses; its other members may be empty.
///
///   axes       Y is up, against gravity (without gravity: the world's z); a world with z up turns about its x.
///   unit       centimetres
///   rest pose  The axes of every solid are parallel to the world's. A scanned body then has the scan's pose,
///              OpenSim's models stand upright.
///   channels   Zrotation Xrotation Yrotation, each continuous over time. Solids on the world, and those whose
///              origin moves in their parent by more than 1 nm, have three positions before them and no offset.
///   End Site   of a solid without children: on the line from its origin through its gravity centre, twice
///              as far from the origin.
///   times      Equal steps from the first time on. If the given ones are not equal, the poses are interpolated
///              at steps of their median.
///
/// Errors: no times; the motion's solids differ from the scene's.
Result<BvhMotion> bvh_skeleton(const Scene& scene, const Trajectory& motion);

}  // namespace borelli
