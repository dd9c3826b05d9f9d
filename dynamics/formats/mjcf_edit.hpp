// Editing of MJCF elements.
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "dynamics/formats/xml_element.hpp"
#include "dynamics/numbers/pose.hpp"

namespace borelli {

/// Numbers as text that reads back exactly.
std::string mjcf_numbers(const std::vector<double>& numbers);

/// Sets an attribute, or adds it.
void set_attribute(XmlElement& element, std::string_view key, std::string value);
void remove_attribute(XmlElement& element, std::string_view key);

/// Replaces the element's position and orientation by `pos` and `quat`.
void set_pose(XmlElement& element, const Pose& X);

/// An empty element with the file, line and part of `origin`.
XmlElement made_from(const XmlElement& origin, std::string name);

/// A 32-bit integer; `standard` if it is missing. Refuses other values.
int whole_number(const XmlElement& element, std::string_view key, int standard);

/// The number of elements in an element, itself included.
std::size_t count_elements(const XmlElement& element);

}  // namespace borelli
