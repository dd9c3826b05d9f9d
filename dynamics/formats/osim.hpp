// Reads OpenSim models (.osim) as scenes.
#pragma once

#include "dynamics/formats/model_file.hpp"
#include "dynamics/formats/xml_element.hpp"

namespace borelli {

/// Each body becomes a solid, placed in the body that its joint names by the switches of osim_joint.hpp. The
/// ground is the world; its y axis points up. Two layouts are read: that of OpenSim 2 and 3, with joints
/// inside bodies, and that of OpenSim 4, with sockets. A body without a joint moves freely, as in OpenSim.
/// The coordinates have the file's names and units (m, rad). OpenSim's order of a joint's coordinates may
/// differ: here translations precede rotations.
///
/// Modelled are masses and inertias, default values and speeds, locked and prescribed coordinates, ranges of
/// clamped coordinates (Range), constraints and springs (osim_constraint.hpp), markers and gravity. All else
/// is listed: muscles, actuators, controllers and contacts change the motion. Throws XmlRefusal; refuses
/// loops of joints, sets in files of their own, and what the files of osim_*.hpp refuse. Moving bodies
/// lighter than `minimum_mass` (kg) become balls of water of this mass (placeholder_inertia.hpp).
///
/// Format: opensim-org/opensim-core, OpenSim/Simulation/SimbodyEngine (Joint.cpp, SpatialTransform.cpp,
/// CustomJoint.cpp), OpenSim/Simulation/Model.
ModelFile read_osim(const XmlElement& root, double minimum_mass = 0);

}  // namespace borelli
