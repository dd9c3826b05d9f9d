#include "inertia/csv.hpp"

#include <fmt/core.h>

#include <charconv>
#include <cmath>

#include "error/plain_cell.hpp"
#include "error/printable.hpp"

namespace borelli {
namespace {

// Reads one record from `position`, which may span lines inside quotes, and moves to the next one. False if a
// quote is not closed.
bool read_record(std::string_view text, std::size_t& position, std::vector<std::string>& fields) {
  fields.assign(1, "");
  bool quoted = false;
  for (; position < text.size(); ++position) {
    const char c = text[position];
    if (quoted && c == '"' && text.substr(position + 1, 1) == "\"") {
      fields.back() += '"';
      ++position;
    } else if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      fields.emplace_back();
    } else if (c == '\n' && !quoted) {
      ++position;
      return true;
    } else if (c != '\r' || quoted) {
      fields.back() += c;
    }
  }
  return !quoted;
}

}  // namespace

const std::string& CsvTable::field(std::size_t row, std::string_view column) const {
  static const std::string none;
  for (std::size_t c = 0; c < columns.size(); ++c)
    if (columns[c] == column) return rows[row][c];
  return none;
}

double CsvTable::number(std::size_t row, std::string_view column) const {
  const std::string& text = field(row, column);
  double value = NAN;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() ? value : NAN;
}

Result<CsvTable> parse_csv(std::string_view text, const std::string& where) {
  CsvTable table;
  std::vector<std::string> fields;
  for (std::size_t position = 0; position < text.size();) {
    if (text[position] == '\n' || text[position] == '\r') {
      ++position;
      continue;
    }
    if (text[position] == '#') {
      const std::size_t end = std::min(text.find('\n', position), text.size());
      const std::string_view line = text.substr(position + 1, end - position - 1);
      const std::size_t first = std::min(line.find_first_not_of(' '), line.size());
      const std::size_t last = line.find_last_not_of('\r');
      table.comments.emplace_back(line.substr(first, last == line.npos ? 0 : last + 1 - first));
      position = end;
      continue;
    }
    if (!read_record(text, position, fields)) return failure(where, "a quoted text is not closed");
    for (std::string& field : fields) field = text_of_cell(field);
    if (table.columns.empty()) {
      table.columns = fields;
    } else if (fields.size() != table.columns.size()) {
      return failure(where, fmt::format("row {} (\"{}\" ...) has {} fields, but the header names {} columns",
                                        table.rows.size() + 1, printable(fields[0]), fields.size(),
                                        table.columns.size()));
    } else {
      table.rows.push_back(fields);
    }
  }
  if (table.columns.empty()) return failure(where, "contains no table, expected a header that names columns");
  return table;
}

std::string csv_field(std::string_view text) {
  const std::string field = plain_cell(text);
  if (field.find_first_of(",\"\n\r#") == field.npos) return field;
  std::string quoted = "\"";
  for (const char c : field) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

}  // namespace borelli
