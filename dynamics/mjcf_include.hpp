// MJCF's <include file="...">: the elements of another file, in its place.
#pragma once

#include "dynamics/xml_element.hpp"

namespace borelli {

/// Puts what the includes of a model name in their place, those of included files too; paths are relative to
/// the main file's folder. Refuses a file that includes itself on any way, and what is not there.
void put_in_includes(XmlElement& root);

}  // namespace borelli
