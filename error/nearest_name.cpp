#include "error/nearest_name.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace borelli {

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t corner = std::exchange(row[0], i + 1);
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t changed = corner + (a[i] != b[j]);
      corner = row[j + 1];
      row[j + 1] = std::min({changed, row[j] + 1, corner + 1});
    }
  }
  return row.back();
}

std::optional<std::string> nearest_name(std::string_view word, const std::vector<std::string>& names) {
  const auto nearest = std::min_element(names.begin(), names.end(), [&](const auto& a, const auto& b) {
    return edit_distance(word, a) < edit_distance(word, b);
  });
  constexpr std::size_t most = 40;  // bytes: no name is longer
  if (nearest == names.end() || word.size() > most || 3 * edit_distance(word, *nearest) > word.size() + 1)
    return std::nullopt;
  return *nearest;
}

}  // namespace borelli
