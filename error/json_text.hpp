// Strict JSON for all readers: malformed, too deeply nested or unexpected values are refused with file and
// line. Neither messages nor exceptions of the JSON library reach the caller.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "error/error.hpp"

namespace borelli {

/// Parses a text. Errors at file:line: malformed JSON (with what was found), text that was cut off, a number
/// beyond the range of a double. Errors about the file: two members of one name, nesting deeper than 100.
Result<nlohmann::json> parse_json(std::string_view text, const std::string& file);
/// The same; objects keep the order of their members.
Result<nlohmann::ordered_json> parse_ordered_json(std::string_view text, const std::string& file);

/// Checks that each value of `document` has the kind (number, text, list, object, boolean) that `pattern` has
/// there. Members are compared by name, list entries with the pattern's first entry. Null in the pattern
/// allows any kind. Members that only one of the two has are ignored. Errors: "stages[2].seconds is the text
/// "x", expected a number", about `file`.
Result<void> check_kinds(const nlohmann::json& document, const nlohmann::json& pattern,
                         const std::string& file);

/// Writes a value as text. Invalid UTF-8, as in file names and DICOM texts, becomes U+FFFD.
template <class Json>
std::string json_text(const Json& value, int indent) {
  return value.dump(indent, ' ', false, Json::error_handler_t::replace);
}

/// Describes a value in an error: "a list of 3", "the number 7".
std::string kind_of_json(const nlohmann::json& value);

}  // namespace borelli
