// The element and attribute names of MJCF. A misspelt name is refused, not taken for one that is not
// modelled.
#pragma once

#include "dynamics/formats/xml_element.hpp"

namespace borelli {

/// Refuses unknown elements and attributes in the parts of a model that mjcf.hpp reads (includes expanded),
/// and soft bodies. Source: MuJoCo's XML reference up to 3.12.
void check_mjcf_names(const XmlElement& root);

}  // namespace borelli
