// What a reader of XML left unread, for people: so that nothing of a model is dropped silently.
#pragma once

#include <string>
#include <vector>

#include "dynamics/formats/xml_element.hpp"

namespace borelli {

/// What a model file holds and its scene does not, a line each.
struct NotModelled {
  std::vector<std::string> motion;  ///< what changes the motion: a warning
  std::vector<std::string>
      other;  ///< looks, sensors, what only tunes another program, and where a joint starts
  bool empty() const { return motion.empty() && other.empty(); }
};

/// Which of a language's elements and attributes change the motion.
struct MotionRules {
  bool (*element)(const XmlElement& element, const XmlElement& parent);
  bool (*attribute)(const XmlAttribute& attribute, const XmlElement& element);
};

/// Adds what is unread of a model. What changes the motion has a line per kind of element or per attribute:
/// its name, how many there are, where the first stands. Of the rest, one line per kind of element: its
/// attributes that no reader asked for, or the elements that no reader used. In the order of the file.
void list_unread(const XmlElement& root, const MotionRules& rules, NotModelled& out);

/// Marks an element with all that is in it as read.
void mark_read(const XmlElement& element);

}  // namespace borelli
