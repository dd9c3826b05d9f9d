// MJCF's classes of defaults: <default class="..."> gives attributes to the elements of that class.
#pragma once

#include "dynamics/formats/xml_element.hpp"

namespace borelli {

/// Writes into every joint, geom, mesh, pair and equality constraint the attributes of its default class that
/// it lacks. The class is that of its `class`, else of the nearest `childclass` of the bodies and frames
/// around it, else the outermost. A nested class inherits from its parent. An element with an orientation of
/// its own, in any notation, inherits none.
void apply_mjcf_defaults(XmlElement& root);

}  // namespace borelli
