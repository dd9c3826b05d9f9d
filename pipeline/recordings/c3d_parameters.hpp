// The parameter section of a C3D file: named values in named groups.
// Source: C3D user guide, "The Parameter Section", www.c3d.org.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "error/error.hpp"
#include "pipeline/recordings/c3d_numbers.hpp"

namespace borelli {

struct C3dParameter {
  enum class Kind { text, byte, integer, real };
  Kind kind = Kind::text;
  std::vector<int> dimensions;  ///< up to 7, the fastest first, as in Fortran; empty for a single value
  std::string text;             ///< of Kind::text: all characters
  std::vector<double> numbers;  ///< of the other kinds: all elements; integers read as signed

  /// Rows of the first dimension, without the blanks and zero bytes at their ends. None for numbers.
  std::vector<std::string> texts() const;
};

class C3dParameters {
 public:
  /// Null where the file has no such parameter. Names are those of the user guide, in capitals.
  const C3dParameter* find(std::string_view group, std::string_view name) const;

  /// All rows of a parameter and of its sequels: LABELS, LABELS2, LABELS3 ... (a dimension ends at 255).
  std::vector<std::string> texts(std::string_view group, const std::string& name) const;
  /// The same for numbers.
  std::vector<double> numbers(std::string_view group, const std::string& name) const;
  /// The first number of a parameter.
  std::optional<double> number(std::string_view group, std::string_view name) const;
  /// The first number as a count: integers read as unsigned. Empty for negative and for infinite ones.
  std::optional<double> count(std::string_view group, std::string_view name) const;
  /// The first row of a text.
  std::string line(std::string_view group, std::string_view name) const;

  /// Adds a parameter. Where two have one name, the first counts.
  void add(const std::string& group, const std::string& name, C3dParameter parameter);

 private:
  std::map<std::string, std::map<std::string, C3dParameter, std::less<>>, std::less<>> groups_;
};

/// Reads the section from byte `start` to before `end` of a whole file. Groups and parameters stand in any
/// order, each with the offset to the next one. An offset of 0 ends the section, and so does what is no name.
/// Names are read in capitals, locked ones as others.
/// Skips, with a warning: parameters whose data reach into the next one, of no group, or of unknown type.
/// Errors about `file`: a record or its data reach beyond the end of the file.
Result<C3dParameters> read_c3d_parameters(std::string_view bytes, std::size_t start, std::size_t end,
                                          C3dProcessor processor, const std::string& file,
                                          std::vector<std::string>& warnings);

}  // namespace borelli
