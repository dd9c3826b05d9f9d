// Inertias of MJCF's bodies.
#pragma once

#include <string>
#include <vector>

#include "dynamics/formats/mjcf_compiler.hpp"
#include "dynamics/formats/mjcf_geom.hpp"

namespace borelli {

/// A body's inertia in its own frame. It comes from <inertial> or the geoms, as inertiafromgeom of the
/// compiler says. boundmass, boundinertia and balanceinertia then correct it. `geoms`: those of the body, as
/// read. Mass zero if there is none.
Inertial mjcf_inertial(const XmlElement& body, const std::vector<MjcfGeom>& geoms,
                       const MjcfCompilers& compilers);

/// Whether the geoms of a body count in its inertia.
bool weighs_by_geoms(const XmlElement& body, const MjcfCompilers& compilers);

}  // namespace borelli
