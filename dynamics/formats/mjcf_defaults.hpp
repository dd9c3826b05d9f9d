// MJCF's classes of defaults: <default class="..."> gives attributes to the elements of that class.
#pragma once

#include "dynamics/formats/xml_element.hpp"

namespace borelli {

/// Writes into every joint, geom, mesh, pair and equality constraint of a model the attributes of its class
/// that it has not itself: the class that its `class` names, else the nearest `childclass` of the bodies and
/// frames around it, else the outermost. A nested class has what its parent has, but for what it says itself.
/// An element with an orientation of its own takes over none, whatever its notation.
void apply_mjcf_defaults(XmlElement& root);

}  // namespace borelli
