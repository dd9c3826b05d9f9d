// Reading XML strictly: a document as a tree of elements that know their file and line, and that remember
// which of their attributes were asked for, so that what a reader does not use can be told. Inside a reader a
// refusal is thrown; the file's border catches it and answers it as an Error.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "error/error.hpp"

namespace borelli {

/// Thrown by XmlElement, caught at the file's border.
struct XmlRefusal {
  Error error;
};

struct XmlAttribute {
  std::string name, value;
  std::string where;          ///< file:line
  bool own = true;            ///< false: taken over from elsewhere (a class of defaults)
  mutable bool read = false;  ///< some reader asked for it
};

/// Levels of elements, over all included files. Readers recurse, with up to some kilobytes of stack a level.
inline constexpr int deepest_xml = 2500;

/// An element with its attributes and the elements in it. Text between elements is not kept.
struct XmlElement {
  std::string name;
  std::string file;
  int line = 0;
  int part = 0;  ///< index of the model file it is from (MJCF's <attach>)
  std::vector<XmlAttribute> attributes;
  std::vector<XmlElement> children;
  mutable bool read = false;  ///< some reader used the element

  /// An attribute's text, or null where it is not there. Marks it as read, as all that follow do.
  const std::string* find(std::string_view key) const;
  const std::string& require(std::string_view key) const;
  std::string text(std::string_view key, std::string_view standard = "") const;
  bool has(std::string_view key) const { return find(key) != nullptr; }

  /// Finite numbers between white space; refuses other counts than `least` to `most`. None where it is not
  /// there.
  std::vector<double> numbers(std::string_view key, std::size_t least, std::size_t most) const;
  double number(std::string_view key, double standard) const;
  /// One of zero or more.
  double not_negative(std::string_view key, double standard) const;
  Eigen::Vector3d vector(std::string_view key, const Eigen::Vector3d& standard) const;
  /// Which one of these words it is.
  std::string word(std::string_view key, const std::vector<std::string_view>& words,
                   std::string_view standard) const;
  bool boolean(std::string_view key, bool standard) const;

  /// The only child of a name, or null where there is none; marks it as read. Refuses two.
  const XmlElement* child(std::string_view child_name) const;
  const XmlElement& require_child(std::string_view child_name) const;

  std::string where() const;     ///< file:line
  std::string describe() const;  ///< "geom 'thigh'", or "geom" where it has no name
  [[noreturn]] void refuse(const std::string& sentence) const;
  /// The same at an attribute's own place.
  [[noreturn]] void refuse(std::string_view key, const std::string& sentence) const;
};

/// The root element of a file. Refuses (by XmlRefusal) what is missing, a folder, not well-formed, or nested
/// deeper than `deepest_xml` elements.
XmlElement read_xml(const std::filesystem::path& path);

}  // namespace borelli
