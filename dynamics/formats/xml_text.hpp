// Writes XML: a tree of elements as indented text. The counterpart of xml_element.hpp.
#pragma once

#include <Eigen/Core>
#include <list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace borelli {

/// An element to be written. References to its children stay valid while others are added.
struct XmlNode {
  std::string name;
  std::vector<std::pair<std::string, std::string>> attributes{};  ///< in the order they are written
  std::list<XmlNode> children{};
  std::string content{};  ///< text of an element without children

  /// Adds a child and returns it.
  XmlNode& add(std::string child);
  /// Adds a child with text as its content.
  XmlNode& add(std::string child, std::string text);
  /// Adds a comment; it must not be the root.
  void comment(std::string text);

  /// Adds an attribute and returns this element.
  XmlNode& set(std::string key, std::string text);
  XmlNode& set(std::string key, const char* text) { return set(std::move(key), std::string(text)); }
  XmlNode& set(std::string key, double number);
  /// Numbers separated by blanks.
  XmlNode& set(std::string key, const std::vector<double>& numbers);
  XmlNode& set(std::string key, const Eigen::Vector3d& vector);
};

/// The shortest text that reads back as the same number.
std::string exact_text(double number);
/// The same for several numbers, separated by blanks.
std::string exact_text(const std::vector<double>& numbers);

/// The document of a root element, in UTF-8, with a declaration and two blanks per level. Special characters
/// are escaped. Control characters, which XML cannot hold, and bytes that are not UTF-8 become "?".
std::string xml_text(const XmlNode& root);

}  // namespace borelli
