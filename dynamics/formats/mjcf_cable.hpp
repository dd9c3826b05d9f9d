// MJCF's <composite type="cable">: a chain of rods.
#pragma once

#include <vector>

#include "dynamics/formats/xml_element.hpp"

namespace borelli {

struct MjcfCable {
  XmlElement body;                   ///< the first rod; the others are nested in it
  std::vector<XmlElement> excludes;  ///< <exclude> elements: neighbouring rods do not touch
};

/// The bodies of a <composite>, as MuJoCo makes them (its user_composite.cc): one rod between consecutive
/// vertices, x along it, on ball joints. The first rod is on a ball joint or a free joint, or fixed
/// (`initial`). The names are those of MuJoCo. Refuses the types that MuJoCo has dropped.
MjcfCable make_mjcf_cable(const XmlElement& composite);

}  // namespace borelli
