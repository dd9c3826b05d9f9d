// Parsing of TOML for all readers: invalid or too deeply nested text is refused with file and line.
#pragma once

#include <toml++/toml.h>

#include <string>
#include <string_view>

#include "error/error.hpp"

namespace borelli {

/// Parses a text as a TOML table. Errors, at file:line: invalid TOML (with what was found), or more than 100
/// nested tables and lists; more values than the memory limit allows. Each part of a dotted key is a table:
/// the library would follow them by recursion.
Result<toml::table> parse_toml(std::string_view text, const std::string& file);

}  // namespace borelli
