// Comma-separated text (RFC 4180) with '#' lines as comments: the format of this folder's published data and
// of the inertia table.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "error/error.hpp"

namespace borelli {

struct CsvTable {
  std::vector<std::string> comments;  ///< lines that begin with '#', without it and the following blanks
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;  ///< each with as many fields as columns

  /// Field of a row by its column's name; empty if there is no such column.
  const std::string& field(std::size_t row, std::string_view column) const;
  /// The same as a number; NaN if it is empty or not a number.
  double number(std::size_t row, std::string_view column) const;
};

/// `where` names the text in errors. Errors: no header; a row with more or fewer fields than columns; an open
/// quote.
Result<CsvTable> parse_csv(std::string_view text, const std::string& where);

/// A text as a field: quoted if it holds commas, quotes, line ends or '#', and safe in a spreadsheet
/// (plain_cell.hpp). parse_csv restores the text.
std::string csv_field(std::string_view text);

}  // namespace borelli
