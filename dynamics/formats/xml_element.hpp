// Strict reading of XML: a document as a tree of elements that know their file and line. Elements and
// attributes remember whether they were read, so that unused content can be listed. Inside a reader a refusal
// is thrown; the entry point of the file catches it and returns an Error.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "error/error.hpp"

namespace borelli {

/// Thrown by XmlElement, caught at the entry point of the file.
struct XmlRefusal {
  Error error;
};

struct XmlAttribute {
  std::string name, value;
  std::string where;          ///< file:line
  bool own = true;            ///< false: inherited from a default class
  mutable bool read = false;  ///< some reader asked for it
};

/// The largest nesting depth, over all included files. Readers recurse, with up to some kilobytes of stack
/// per level.
inline constexpr int deepest_xml = 2500;

/// An element with its attributes and child elements, or its text. Text between elements is dropped.
struct XmlElement {
  std::string name;
  std::string file;
  int line = 0;
  int part = 0;  ///< index of the model file it is from (MJCF's <attach>)
  std::vector<XmlAttribute> attributes;
  std::vector<XmlElement> children;
  std::string content;        ///< of an element without children: its text, without white space at both ends
  mutable bool read = false;  ///< some reader used the element

  /// The text of an attribute, or null if it is missing. Marks it as read, as do all accessors below.
  const std::string* find(std::string_view key) const;
  const std::string& require(std::string_view key) const;
  std::string text(std::string_view key, std::string_view standard = "") const;
  bool has(std::string_view key) const { return find(key) != nullptr; }

  /// Finite numbers separated by white space, `least` to `most` of them; refuses other counts. Empty if
  /// missing.
  std::vector<double> numbers(std::string_view key, std::size_t least, std::size_t most) const;
  double number(std::string_view key, double standard) const;
  /// The same of the element's text; refuses an empty one unless `least` is 0.
  std::vector<double> content_numbers(std::size_t least, std::size_t most) const;
  /// A number that is zero or more.
  double not_negative(std::string_view key, double standard) const;
  Eigen::Vector3d vector(std::string_view key, const Eigen::Vector3d& standard) const;
  /// One of these words.
  std::string word(std::string_view key, const std::vector<std::string_view>& words,
                   std::string_view standard) const;
  bool boolean(std::string_view key, bool standard) const;

  /// The only child of this name, or null if there is none; marks it as read. Refuses two.
  const XmlElement* child(std::string_view child_name) const;
  const XmlElement& require_child(std::string_view child_name) const;

  std::string where() const;     ///< file:line
  std::string describe() const;  ///< "geom 'thigh'", or "geom" if it has no name
  [[noreturn]] void refuse(const std::string& sentence) const;
  /// The same, at the place of an attribute.
  [[noreturn]] void refuse(std::string_view key, const std::string& sentence) const;
};

/// Refuses (by XmlRefusal) more elements, at `where`, than the memory limit allows.
void admit_xml(const std::string& where, std::size_t elements);

/// Reads the root element of a file. Refuses (by XmlRefusal) a missing file, a folder, XML that is not
/// well-formed, entities that the file does not define itself, nesting deeper than `deepest_xml` elements,
/// and more elements than the memory limit allows.
XmlElement read_xml(const std::filesystem::path& path);

/// Reads the root element of the file that the attribute `file` of an element names. Refuses a file that
/// cannot be read at this element.
XmlElement read_xml_named(const XmlElement& by, const std::filesystem::path& file);

}  // namespace borelli
