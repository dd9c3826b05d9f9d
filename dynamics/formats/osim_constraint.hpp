// Reads the constraints and forces of OpenSim that a scene can hold.
#pragma once

#include <optional>

#include "dynamics/formats/osim_frames.hpp"
#include "dynamics/formats/osim_layout.hpp"
#include "dynamics/formats/unread.hpp"
#include "dynamics/scene/scene.hpp"

namespace borelli {

/// Adds to the scene, whose solids are complete: CoordinateCouplerConstraint (of one coordinate: the
/// dependent one becomes Coupled; a linear one of several: CoordinateCoupling), PointConstraint,
/// WeldConstraint, ConstantDistanceConstraint, PointOnLineConstraint; and the forces of osim_force.hpp.
/// Others, and those that are switched off, are left unread (so that they are listed). Throws XmlRefusal:
/// names that are not there, and couplings by functions of several coordinates.
void read_osim_constraints(const XmlElement& model, const OsimFrames& frames, Scene& scene);

/// Whether a constraint or force of the file acts: isEnforced, appliesForce, and isDisabled of OpenSim 3.
bool osim_acts(const XmlElement& element);

}  // namespace borelli
