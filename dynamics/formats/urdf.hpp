// URDF, the robot description of ROS (wiki.ros.org/urdf/XML), as a scene.
#pragma once

#include "dynamics/formats/model_file.hpp"
#include "dynamics/formats/xml_element.hpp"

namespace borelli {

/// Each link becomes a solid, placed by its joint's origin and motion: fixed, revolute, continuous,
/// prismatic, floating (free_joint.hpp), planar (two translations in the plane across the axis, then a
/// rotation about it: for the axis z along x, y) and, beyond the standard, spherical (a ball). Solids stand
/// in the order of the joints, so that the coordinates are the joints in file order; each bears its joint's
/// name. The root is fixed to the world, or placed by a free joint of its own name (`floating`); a root named
/// "world" is the world itself.
///
/// What fixed joints join is judged as one body (formats/placeholder_inertia.hpp): links without mass that
/// carry none are locked.
///
/// Inertials, position limits (Range), damping (CoordinateSpring) and mimic (CoordinateCoupling) count.
/// Shapes are there to be seen: primitives of <visual>, or of <collision> where a link has none. What else
/// the file holds, elements of other programs too, is listed. Throws XmlRefusal; refuses xacro, several
/// roots, loops and names that are used twice or not there.
ModelFile read_urdf(const XmlElement& root, const ModelOptions& options);

}  // namespace borelli
