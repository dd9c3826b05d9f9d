// Properties of OpenSim's XML files: each is a child element whose text is the value.
//
// All functions refuse by XmlRefusal (dynamics/formats/xml_element.hpp), with the element's line. They mark
// what they use as read.
#pragma once

#include <filesystem>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "dynamics/formats/unread.hpp"
#include "dynamics/formats/xml_element.hpp"

namespace borelli {

/// The object of a file: the root itself, or the only such element below <OpenSimDocument>. Refuses another
/// file, naming what was found. `names`: its name, then older ones.
const XmlElement& opensim_object(const XmlElement& root, const std::vector<std::string_view>& names);

/// The objects of a set: <SET><objects>... (OpenSim 2 and later) or the children of <SET> themselves. Empty
/// if `set` is null.
std::vector<const XmlElement*> set_objects(const XmlElement* set);

/// The value of a property; `standard` where it is missing. "Unassigned", which OpenSim writes for a name not
/// given, is "".
std::string property_text(const XmlElement& owner, std::string_view name, std::string_view standard = "");
/// true or false, in any letter case, or 1 or 0.
bool property_flag(const XmlElement& owner, std::string_view name, bool standard);
/// A number that is not NaN; "Inf", "Infinity" and their negatives are numbers here.
double property_number(const XmlElement& owner, std::string_view name, double standard);
/// Two numbers in order; from -infinity to infinity where it is missing or empty.
std::pair<double, double> property_range(const XmlElement& owner, std::string_view name);
/// Words separated by blanks.
std::vector<std::string> property_words(const XmlElement& owner, std::string_view name);
/// A file's path, relative to the folder of the XML file; empty where none is given. Backslashes, which
/// OpenSim writes on Windows, separate folders too.
std::filesystem::path property_path(const XmlElement& owner, std::string_view name);

/// A component's own name: what follows the last slash of its path ("/bodyset/calcn_r" is "calcn_r").
std::string component_name(const std::string& path);

/// Lists what was not read. All of it may change the result, but remarks on authors and units. Elements that
/// say nothing are left out.
NotModelled not_read(const XmlElement& root);

}  // namespace borelli
