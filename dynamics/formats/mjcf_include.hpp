// MJCF's <include file="...">: the elements of another file, in its place.
#pragma once

#include "dynamics/formats/xml_element.hpp"

namespace borelli {

/// What a model may grow to by its includes, attached models and copies.
constexpr std::size_t most_mjcf_elements = 1'000'000;

/// Puts what the includes of a model name in their place, those of included files too; paths are relative to
/// the main file's folder. Refuses a file that includes itself on any way, what is not there, and a model
/// that grows beyond `most_mjcf_elements` or is nested deeper than 10000 elements by it.
void put_in_includes(XmlElement& root);

}  // namespace borelli
