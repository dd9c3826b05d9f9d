// Reads URDF, the robot description of ROS (wiki.ros.org/urdf/XML), as a scene.
#pragma once

#include "dynamics/formats/model_file.hpp"
#include "dynamics/formats/xml_element.hpp"

namespace borelli {

/// Each link becomes a solid, placed by the origin and motion of its joint: fixed, revolute, continuous,
/// prismatic, floating (free_joint.hpp), planar and, beyond the standard, spherical (a ball). Planar means
/// two translations in the plane normal to the axis, then a rotation about it: for the axis z along x, y.
/// Solids have the order of the joints. So the coordinates are the joints in file order, each with the name
/// of its joint. The root is fixed to the world, or placed by a free joint of its own name (`floating`); a
/// root named "world" is the world itself.
///
/// Links joined by fixed joints are judged as one body (formats/placeholder_inertia.hpp). Massless links that
/// carry no mass are locked.
///
/// Modelled are inertials, position limits (Range), damping (CoordinateSpring) and mimic
/// (CoordinateCoupling). Shapes are for display: primitives of <visual>, or of <collision> for links without
/// it. All other content, elements of other programs too, is listed. Throws XmlRefusal; refuses xacro,
/// several roots, loops, and duplicate or unknown names.
ModelFile read_urdf(const XmlElement& root, const ModelOptions& options);

}  // namespace borelli
