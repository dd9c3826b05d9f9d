// Makes texts in tables safe to open in a spreadsheet. A cell that begins with = + - @, a tab or a carriage
// return is a formula there, and formulas can run programs (OWASP, CSV injection).
#pragma once

#include <string>
#include <string_view>

namespace borelli {

/// Whether a cell without its leading apostrophes is a formula.
inline bool is_formula_cell(std::string_view text) {
  const std::size_t first = text.find_first_not_of('\'');
  return first != text.npos && std::string_view("=+-@\t\r").find(text[first]) != std::string_view::npos;
}

/// A text as a cell. An apostrophe before a formula makes it text.
inline std::string plain_cell(std::string_view text) {
  return (is_formula_cell(text) ? "'" : "") + std::string(text);
}

/// The inverse of plain_cell.
inline std::string text_of_cell(std::string_view cell) {
  if (cell.starts_with('\'') && is_formula_cell(cell)) cell.remove_prefix(1);
  return std::string(cell);
}

/// A comment line without formulas. Spreadsheets split it into cells at commas, semicolons and tabs.
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
