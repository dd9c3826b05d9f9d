#include "segmentation/files/header_text.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>

#include "error/printable.hpp"
#include "segmentation/files/byte_stream.hpp"

namespace borelli {
namespace {

constexpr std::size_t longest = std::size_t{1} << 20;  // bytes; headers have hundreds

// The whole word as a number.
std::optional<double> exact_number(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = 0;
  const auto [rest, trouble] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (trouble != std::errc() || rest != word.data() + word.size()) return std::nullopt;
  return value;
}

}  // namespace

Result<HeaderText> read_header_text(const std::string& path,
                                    const std::function<bool(std::string_view)>& last) {
  auto source = ByteSource::open(path, ByteSource::Packing::plain);
  if (!source) return tl::unexpected(source.error());
  HeaderText text;
  std::string line;
  std::array<std::byte, 4096> block;
  for (std::uint64_t before = 0; before < longest; before += block.size()) {
    const auto got = source->read(block);
    if (!got) return tl::unexpected(got.error());
    for (std::size_t n = 0; n < *got; ++n) {
      const char c = static_cast<char>(block[n]);
      if (c != '\n') {
        line += c;
        continue;
      }
      if (line.ends_with('\r')) line.pop_back();
      text.lines.push_back(line);
      text.end = before + n + 1;
      if (last(line)) return text;
      line.clear();
    }
    if (*got < block.size()) {
      if (!line.empty()) text.lines.push_back(line);
      text.end = before + *got;
      return text;
    }
  }
  return failure(path, "does not end its header within the first million bytes");
}

std::string_view trimmed(std::string_view text) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

std::string lower_case(std::string_view text) {
  std::string lower(text);
  std::ranges::transform(lower, lower.begin(), [](unsigned char c) { return std::tolower(c); });
  return lower;
}

std::optional<std::vector<double>> numbers_in(std::string_view text) {
  std::vector<double> numbers;
  for (text = trimmed(text); !text.empty(); text = trimmed(text)) {
    std::string_view word = text.substr(0, text.find_first_of(" \t"));
    text.remove_prefix(word.size());
    if (word.ends_with(',')) word.remove_suffix(1);
    const auto number = exact_number(word);
    if (!number) return std::nullopt;
    numbers.push_back(*number);
  }
  return numbers;
}

Result<std::vector<double>> field_numbers(const std::string& path, std::string_view name,
                                          std::string_view text, std::size_t count) {
  auto numbers = numbers_in(text);
  if (numbers && (numbers->empty() || count == 0 || numbers->size() == count)) return *std::move(numbers);
  const auto comma = std::ranges::adjacent_find(
      text, [](char c, char next) { return c == ',' && std::isdigit(static_cast<unsigned char>(next)); });
  return failure(path,
                 fmt::format("has a damaged header: {} is '{}'; expected {} separated by blanks{}", name,
                             printable(text), count == 0 ? "numbers" : fmt::format("{} numbers", count),
                             comma != text.end() ? ", with decimal points instead of commas" : ""));
}

std::optional<double> number_in(std::string_view text) {
  text = trimmed(text);
  if (text.empty()) return std::nullopt;
  return exact_number(text).value_or(std::numeric_limits<double>::quiet_NaN());
}

std::int64_t whole_number(double value) {
  return std::isnan(value) ? 0 : static_cast<std::int64_t>(std::clamp(value, -1e15, 1e15));
}

std::string exact(double value) {
  std::array<char, 32> text;
  const auto [end, trouble] = std::to_chars(text.data(), text.data() + text.size(), value);
  return {text.data(), end};
}

}  // namespace borelli
