// Finds the known name that a misspelt one stands for.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace borelli {

/// Letters to insert, delete or replace (Levenshtein distance), in bytes.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The name with the least edit distance to `word`, the first of several. Empty if that distance exceeds a
/// third of the word's length plus one, or if `word` is longer than 40 bytes.
std::optional<std::string> nearest_name(std::string_view word, const std::vector<std::string>& names);

}  // namespace borelli
