// The names that MJCF knows, so that a misspelt one is refused rather than taken for one that is not
// modelled.
#pragma once

#include "dynamics/formats/xml_element.hpp"

namespace borelli {

/// Refuses unknown elements and unknown attributes in those parts of a model (includes put in place) that
/// mjcf.hpp reads, and soft bodies. MuJoCo's XML reference up to 3.12.
void check_mjcf_names(const XmlElement& root);

}  // namespace borelli
