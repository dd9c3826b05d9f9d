#include "pipeline/recordings/text_rows.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "error/printable.hpp"
#include "segmentation/files/header_text.hpp"

namespace borelli {
namespace {

constexpr std::string_view blanks = " \t\r\v\f";

}  // namespace

TextRows::TextRows(std::string_view text) : rest_(text) {
  if (rest_.starts_with("\xef\xbb\xbf")) rest_.remove_prefix(3);
}

bool TextRows::next() {
  line_ = {};
  if (rest_.empty()) return false;
  const std::size_t end = rest_.find_first_of("\r\n");
  line_ = rest_.substr(0, end);
  const std::size_t ends = end == rest_.npos ? 0 : rest_.substr(end).starts_with("\r\n") ? 2 : 1;
  rest_.remove_prefix(line_.size() + ends);
  ++number_;
  return true;
}

bool TextRows::is_blank() const { return line_.find_first_not_of(blanks) == line_.npos; }

std::vector<std::string_view> tab_cells(std::string_view line) {
  const std::size_t last = line.find_last_not_of(blanks);
  if (last == line.npos) return {};
  line = line.substr(0, last + 1);
  std::vector<std::string_view> cells;
  for (std::size_t tab = 0; tab != line.npos;) {
    tab = line.find('\t');
    cells.push_back(trimmed(line.substr(0, tab)));
    if (tab != line.npos) line.remove_prefix(tab + 1);
  }
  return cells;
}

std::vector<std::string_view> blank_words(std::string_view line) {
  std::vector<std::string_view> words;
  for (std::size_t begin = line.find_first_not_of(blanks); begin != line.npos;
       begin = line.find_first_not_of(blanks)) {
    line.remove_prefix(begin);
    const std::size_t end = std::min(line.find_first_of(blanks), line.size());
    words.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
  return words;
}

bool is_gap(std::string_view cell) {
  if (cell.empty()) return true;
  if (cell.size() > 12) return false;
  const std::string word = lower_case(cell);
  std::string_view bare = word;
  if (bare.front() == '-' || bare.front() == '+') bare.remove_prefix(1);
  // (Microsoft's runtime pads "1.#QNAN" with zeros to the digits asked for: "1.#QNAN0")
  return bare == "nan" || bare.starts_with("nan(") || bare.starts_with("1.#qnan") ||
         bare.starts_with("1.#ind") || bare.starts_with("1.#snan");
}

std::optional<double> finite_number(std::string_view cell) {
  if (cell.starts_with('+')) cell.remove_prefix(1);
  double value = 0;
  const auto [rest, trouble] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (cell.empty() || rest != cell.data() + cell.size()) return std::nullopt;
  if (trouble == std::errc::result_out_of_range && cell.find_first_of("eE") != cell.npos &&
      cell.substr(cell.find_first_of("eE")).find('-') != cell.npos)
    return 0;
  if (trouble != std::errc() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<long> integer_number(std::string_view cell) {
  if (cell.starts_with('+')) cell.remove_prefix(1);
  long value = 0;
  const auto [rest, trouble] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (cell.empty() || trouble != std::errc() || rest != cell.data() + cell.size()) return std::nullopt;
  return value;
}

std::string decimal_text(double value) {
  if (std::isnan(value)) return "NaN";
  std::array<char, 40> text;
  const auto [end, trouble] =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 15);
  return {text.data(), end};
}

std::string printable_list(std::vector<std::string> names) {
  for (std::string& name : names) name = printable(name);
  return name_list(names);
}

}  // namespace borelli
