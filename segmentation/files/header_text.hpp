// Text headers of volume files (NRRD, MetaImage): their lines, and their numbers, independent of the locale.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "error/error.hpp"

namespace borelli {

struct HeaderText {
  std::vector<std::string> lines;  ///< without line ends
  std::uint64_t end = 0;           ///< file offset of the first byte after the header
};

/// Reads lines up to and including the first for which `last` holds, or to the file's end. Errors: not
/// readable; a line or header that is too long for text.
Result<HeaderText> read_header_text(const std::string& path,
                                    const std::function<bool(std::string_view)>& last);

std::string_view trimmed(std::string_view text);
std::string lower_case(std::string_view text);

/// The numbers in `text`, separated by blanks; a comma may follow a number. Empty if a word is no number.
std::optional<std::vector<double>> numbers_in(std::string_view text);

/// The numbers of the header field `name`, whose text is `text`; none if it is empty. Errors: a word that is
/// no number, e.g. with a decimal comma; another count than `count` (0: any).
Result<std::vector<double>> field_numbers(const std::string& path, std::string_view name,
                                          std::string_view text, std::size_t count = 0);

/// `text` as a number; NaN if it is not one, empty if `text` is empty.
std::optional<double> number_in(std::string_view text);

/// A header's number truncated to an integer, clamped to +-1e15; NaN becomes 0.
std::int64_t whole_number(double value);

/// The shortest decimal that reads back as the same double.
std::string exact(double value);

}  // namespace borelli
