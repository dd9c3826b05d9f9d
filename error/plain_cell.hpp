// Text in tables that people open with a spreadsheet, which takes a cell that begins with = + - @, a tab or a
// carriage return for a formula, and may run programs by it.
#pragma once

#include <string>
#include <string_view>

namespace borelli {

/// Whether a cell is a formula, or would be one without the apostrophes before it.
inline bool is_formula_cell(std::string_view text) {
  const std::size_t first = text.find_first_not_of('\'');
  return first != text.npos && std::string_view("=+-@\t\r").find(text[first]) != std::string_view::npos;
}

/// Text as a cell: with an apostrophe before it where it is a formula, which makes it text.
inline std::string plain_cell(std::string_view text) {
  return (is_formula_cell(text) ? "'" : "") + std::string(text);
}

/// The text that plain_cell made a cell of.
inline std::string text_of_cell(std::string_view cell) {
  if (cell.starts_with('\'') && is_formula_cell(cell)) cell.remove_prefix(1);
  return std::string(cell);
}

/// A line of comment, which a spreadsheet parts into cells at commas, semicolons and tabs.
inline std::string plain_comment(std::string_view line) {
  std::string out;
  for (std::size_t at = 0; at < line.size(); ++at) {
    out += line[at];
    if (std::string_view(",;\t").find(line[at]) == std::string_view::npos) continue;
    const std::string_view cell = line.substr(at + 1);
    if (is_formula_cell(cell.starts_with('"') ? cell.substr(1) : cell)) out += '\'';
  }
  return out;
}

}  // namespace borelli
