#include "segmentation/files/header_text.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>

#include "segmentation/files/byte_stream.hpp"

namespace borelli {
namespace {

constexpr std::size_t longest = std::size_t{1} << 20;  // bytes; headers have hundreds

bool separates(char c) { return std::string_view(" \t,()[]{}\"").find(c) != std::string_view::npos; }

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

std::vector<double> numbers_in(std::string_view text) {
  std::vector<double> numbers;
  while (true) {
    while (!text.empty() && separates(text.front())) text.remove_prefix(1);
    if (text.empty()) return numbers;
    if (text.front() == '+') text.remove_prefix(1);
    double value = 0;
    const auto [rest, trouble] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (trouble != std::errc()) return numbers;
    text.remove_prefix(static_cast<std::size_t>(rest - text.data()));
    numbers.push_back(value);
    if (!text.empty() && !separates(text.front())) return numbers;
  }
}

std::optional<double> number_in(std::string_view text) {
  text = trimmed(text);
  if (text.empty()) return std::nullopt;
  if (text.front() == '+') text.remove_prefix(1);
  double value = 0;
  const auto [rest, trouble] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (trouble != std::errc() || rest != text.data() + text.size())
    return std::numeric_limits<double>::quiet_NaN();
  return value;
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
