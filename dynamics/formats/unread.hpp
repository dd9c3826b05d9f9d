// Lists the content of an XML model that its reader left unread, so that nothing is dropped silently.
#pragma once

#include <string>
#include <vector>

#include "dynamics/formats/xml_element.hpp"

namespace borelli {

/// Content of a model file that its scene does not model, one line each.
struct NotModelled {
  std::vector<std::string> motion;  ///< affects the motion: a warning
  std::vector<std::string>
      other;  ///< appearance, sensors, settings of other programs, and where a joint starts
  bool empty() const { return motion.empty() && other.empty(); }
};

/// Decides which elements and attributes of a file format affect the motion.
struct MotionRules {
  bool (*element)(const XmlElement& element, const XmlElement& parent);
  bool (*attribute)(const XmlAttribute& attribute, const XmlElement& element);
};

/// Adds the unread content of a model, in the order of the file. Content that affects the motion has a line
/// per kind of element or per attribute: name, count, first place. The rest has one line per kind of element:
/// the attributes or elements that no reader used.
void list_unread(const XmlElement& root, const MotionRules& rules, NotModelled& out);

/// Marks an element and all its content as read.
void mark_read(const XmlElement& element);

}  // namespace borelli
