// Text headers of volume files (NRRD, MetaImage): their lines, and numbers in them whatever the locale.
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
  std::uint64_t end = 0;           ///< bytes of the file before what follows the header
};

/// Reads lines up to and including the first for which `last` holds, or to the file's end. Errors: not
/// readable; a line or a header too long for a text.
Result<HeaderText> read_header_text(const std::string& path,
                                    const std::function<bool(std::string_view)>& last);

std::string_view trimmed(std::string_view text);
std::string lower_case(std::string_view text);

/// All numbers in `text`, which may be separated by blanks, commas and brackets; fewer where something else
/// stands there.
std::vector<double> numbers_in(std::string_view text);

/// The number that `text` is; NaN if it is anything else, nothing if it is empty.
std::optional<double> number_in(std::string_view text);

/// A header's number without its fraction, at most 1e15 either way; NaN as 0.
std::int64_t whole_number(double value);

/// The shortest decimal that reads back as the same double.
std::string exact(double value);

}  // namespace borelli
