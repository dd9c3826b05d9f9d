// MJCF's <include file="...">: the elements of another file, in its place.
#pragma once

#include "dynamics/formats/xml_element.hpp"

namespace borelli {

/// The largest number of elements of a model with its includes, attached models and copies.
constexpr std::size_t most_mjcf_elements = 1'000'000;

/// Replaces each <include> by the elements of its file, recursively. Paths are relative to the folder of the
/// main file. Refuses missing files, a file that includes itself directly or indirectly, a model that grows
/// beyond `most_mjcf_elements`, and nesting deeper than `deepest_xml`.
void put_in_includes(XmlElement& root);

}  // namespace borelli
