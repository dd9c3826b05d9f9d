// Reading JSON strictly, the same for every reader: what is no JSON, nested without end or of another kind
// than expected is refused with its file and place. The library's own words and exceptions stay inside.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "error/error.hpp"

namespace borelli {

/// A text as a JSON value. Errors, at file:line: no JSON (what was found), cut off, a number beyond the range
/// of a double, a name that stands twice in an object, more than 100 lists and objects in each other.
Result<nlohmann::json> parse_json(std::string_view text, const std::string& file);
/// The same, with the members of objects in the text's order.
Result<nlohmann::ordered_json> parse_ordered_json(std::string_view text, const std::string& file);

/// Whether `document` holds values of the same kinds as `pattern` wherever both hold one: members by name,
/// each entry of a list like the pattern's first; null in the pattern stands for any kind. What is not in the
/// pattern, or missing from the document, is not looked at.
/// Errors: "stages[2].seconds is a text, expected a number", about `file`.
Result<void> check_kinds(const nlohmann::json& document, const nlohmann::json& pattern,
                         const std::string& file);

/// A value as text. Bytes that are no UTF-8, which names of files and DICOM's texts may hold, become U+FFFD.
template <class Json>
std::string json_text(const Json& value, int indent) {
  return value.dump(indent, ' ', false, Json::error_handler_t::replace);
}

/// What a value is, for errors: "a list of 3", "the number 7".
std::string kind_of_json(const nlohmann::json& value);

}  // namespace borelli
