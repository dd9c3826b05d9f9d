// Shapes and meshes that show a body in OpenSim.
#pragma once

#include <string>

#include "dynamics/formats/model_write.hpp"
#include "dynamics/formats/omissions.hpp"
#include "dynamics/formats/osim_write_names.hpp"
#include "dynamics/formats/xml_text.hpp"

namespace borelli {

/// Adds what shows a solid (or the world: null) to its <Body> or <Ground>: its shapes, and the meshes and
/// frames of `extras` that name it. A shape away from the body's origin gets a frame of its own. A capsule
/// becomes a cylinder and two spheres. Names in `lost` the solids with shapes made of triangles, which need a
/// file.
void write_osim_geometry(const std::string& name, const Solid* solid, const ModelExtras& extras,
                         const OsimNames& names, XmlNode& body, Omissions& lost);

}  // namespace borelli
