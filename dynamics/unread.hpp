// What a reader of XML left unread, for people: so that nothing of a model is dropped silently.
#pragma once

#include <string>
#include <vector>

#include "dynamics/xml_element.hpp"

namespace borelli {

/// One line per kind of element: its attributes that no reader asked for, or the elements of that kind that
/// no reader used, how many, and where the first stands. In the order of the file.
std::vector<std::string> list_unread(const XmlElement& root);

/// Marks an element with all that is in it as read.
void mark_read(const XmlElement& element);

}  // namespace borelli
