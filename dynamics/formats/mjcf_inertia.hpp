// What MJCF's bodies weigh.
#pragma once

#include <string>
#include <vector>

#include "dynamics/formats/mjcf_compiler.hpp"
#include "dynamics/formats/mjcf_geom.hpp"

namespace borelli {

/// A body's inertia in the body's frame: that of its <inertial> or of its geoms, as the compiler's
/// inertiafromgeom says, put right by its boundmass, boundinertia and balanceinertia. `geoms`: the body's, as
/// read. Mass zero where there is none.
Inertial mjcf_inertial(const XmlElement& body, const std::vector<MjcfGeom>& geoms,
                       const MjcfCompilers& compilers);

/// Whether the geoms of a body count in its inertia.
bool weighs_by_geoms(const XmlElement& body, const MjcfCompilers& compilers);

}  // namespace borelli
