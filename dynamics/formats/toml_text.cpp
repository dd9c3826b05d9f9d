#include "dynamics/formats/toml_text.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <vector>

#include "process/memory.hpp"

namespace borelli {
namespace {

constexpr std::size_t deepest = 100;

// Scans the nesting of keys and brackets without building anything.
class NestingScan {
 public:
  explicit NestingScan(std::string_view text) : text_(text) {}

  /// The line where the nesting becomes too deep; 0: nowhere.
  std::size_t line_too_deep() {
    for (; at_ < text_.size(); ++at_) {
      switch (text_[at_]) {
        case '\n':
          ++line_, parts_ = 1;
          break;
        case '#':
          at_ = std::min(text_.find('\n', at_), text_.size()) - 1;
          break;
        case '"':
        case '\'':
          skip_string();
          break;
        case '.':
          ++values_;
          if (outer_ + ++parts_ > deepest) return line_;
          break;
        case '=':
          ++values_;
          break;
        case '[':
        case '{':
          ++values_;
          open_.push_back(parts_);
          if ((outer_ += parts_) > deepest) return line_;
          parts_ = 1;
          break;
        case ']':
        case '}':
          if (!open_.empty()) outer_ -= open_.back(), open_.pop_back();
          parts_ = 1;
          break;
        case ',':
          ++values_;
          parts_ = 1;
          break;
        default:
          break;
      }
    }
    return 0;
  }

  /// The most values that the scanned text can have: tables, lists, numbers ...
  std::size_t values() const { return values_; }

 private:
  // Advances to the last quote of a string; a single-line string ends with its line at the latest.
  void skip_string() {
    const char quote = text_[at_];
    const std::string three(3, quote);
    const bool many_lines = text_.substr(at_).starts_with(three);
    at_ += many_lines ? 3 : 1;
    for (; at_ < text_.size(); ++at_) {
      if (text_[at_] == '\\' && quote == '"') {
        if (++at_ < text_.size() && text_[at_] == '\n') ++line_;
      } else if (text_[at_] == '\n') {
        if (!many_lines) {
          --at_;
          return;
        }
        ++line_;
      } else if (many_lines ? text_.substr(at_).starts_with(three) : text_[at_] == quote) {
        at_ += many_lines ? 2 : 0;
        return;
      }
    }
  }

  std::string_view text_;
  std::size_t at_ = 0, line_ = 1, values_ = 0;
  std::size_t parts_ = 1;          ///< of the key being read
  std::size_t outer_ = 0;          ///< sum of open_
  std::vector<std::size_t> open_;  ///< per open bracket, the parts of the key before it
};

// A fault that the library describes, "Error while parsing key-value pair: expected '=', saw ...", as the end
// of our sentence. Its own words are quoted only where they are plain.
std::string fault_in(std::string_view description) {
  constexpr std::string_view begin = "Error while parsing ";
  if (const auto colon = description.find(": "); description.starts_with(begin) && colon != description.npos)
    description.remove_prefix(colon + 2);
  static constexpr std::pair<const char*, const char*> ours[]{
      {"utf-8", ": its bytes are not UTF-8"},
      {"end-of-file", ": the file ends too early"},
      {"could not", ": a value is too large, or not written as TOML writes it"},
      {"trying to interpret", ": a value is too large, or not written as TOML writes it"},
      {"expected expected", ": expected a sign or a digit"}};
  for (const auto& [theirs, words] : ours)
    if (description.find(theirs) != description.npos) return words;
  static constexpr const char* plain[]{"expected ", "cannot ", "leading zeroes ", "underscores ", "unknown "};
  if (std::ranges::none_of(plain, [&](const char* words) { return description.starts_with(words); }))
    return ": what stands there has no meaning in TOML";
  std::string out = ": " + std::string(description);
  std::replace_if(
      out.begin(), out.end(), [](unsigned char c) { return c < ' '; }, ' ');
  return out;
}

}  // namespace

Result<toml::table> parse_toml(std::string_view text, const std::string& file) {
  constexpr double value_size = 300;  // bytes, in the library's tree and in what is made from it
  NestingScan scan(text);
  if (const std::size_t line = scan.line_too_deep(); line > 0)
    return bad_use(fmt::format("{}:{}", file, line),
                   fmt::format("tables and lists are nested deeper than {}", deepest));
  if (auto fits = admit_memory(file, fmt::format("its content of up to {} values", scan.values()),
                               value_size * static_cast<double>(scan.values()));
      !fits)
    return tl::unexpected(fits.error());
  try {
    return toml::parse(text);
  } catch (const toml::parse_error& e) {
    const auto& at = e.source().begin;
    return bad_use(fmt::format("{}:{}", file, at.line),
                   fmt::format("is not TOML at column {}{}", at.column, fault_in(e.description())));
  }
}

}  // namespace borelli
