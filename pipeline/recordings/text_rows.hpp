// Tables as text: lines, cells between tabs, words between blanks, and numbers independent of the locale.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace borelli {

/// Walks over the lines of a text. A line ends at LF, CR LF or CR. Skips the byte order mark of UTF-8.
class TextRows {
 public:
  explicit TextRows(std::string_view text);

  /// Goes to the next line; false at the end of the text.
  bool next();
  std::string_view line() const { return line_; }  ///< without its end; empty after the last
  int number() const { return number_; }           ///< of the line, from 1
  bool is_blank() const;                           ///< spaces and tabs alone

 private:
  std::string_view rest_, line_;
  int number_ = 0;
};

/// What stands between tabs, without the blanks around it. Empty cells at the end are left out.
std::vector<std::string_view> tab_cells(std::string_view line);

/// What stands between spaces and tabs; never empty.
std::vector<std::string_view> blank_words(std::string_view line);

/// Whether a cell stands for a missing value: empty, or NaN as C, Fortran, MATLAB or Microsoft's runtime
/// writes it.
bool is_gap(std::string_view cell);

/// A finite number. Empty: other text, infinity, NaN, or too large for a double. Too small a number is zero.
std::optional<double> finite_number(std::string_view cell);

/// A whole number.
std::optional<long> integer_number(std::string_view cell);

/// A number with 15 significant digits, the most that a double keeps of every decimal; "NaN" for NaN. With
/// 15 digits, a change of unit and back leaves the text as it was.
std::string decimal_text(double value);

/// Names from a file as a list for a sentence (printable.hpp).
std::string printable_list(std::vector<std::string> names);

}  // namespace borelli
