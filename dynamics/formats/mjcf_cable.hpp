// MJCF's <composite type="cable">: a chain of rods.
#pragma once

#include <vector>

#include "dynamics/formats/xml_element.hpp"

namespace borelli {

struct MjcfCable {
  XmlElement body;                   ///< the first rod's, with the others nested in it
  std::vector<XmlElement> excludes;  ///< neighbours do not touch: <exclude> elements
};

/// The bodies of a <composite>, as MuJoCo makes them (its user_composite.cc): one rod from each vertex to the
/// next, x along it, on ball joints; the first one on a ball, free or fixed (`initial`). Names are those of
/// MuJoCo. Refuses the types that MuJoCo has given up.
MjcfCable make_mjcf_cable(const XmlElement& composite);

}  // namespace borelli
