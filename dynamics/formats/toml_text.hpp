// Reading TOML, the same for every reader: what is no TOML or nested without end is refused with file and
// line.
#pragma once

#include <toml++/toml.h>

#include <string>
#include <string_view>

#include "error/error.hpp"

namespace borelli {

/// A text as a TOML table. Errors, at file:line: no TOML (what was found), more than 100 tables and lists in
/// each other (each part of a dotted key is a table: the library would follow them by recursion).
Result<toml::table> parse_toml(std::string_view text, const std::string& file);

}  // namespace borelli
