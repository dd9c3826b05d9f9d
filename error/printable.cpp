#include "error/printable.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <ranges>

namespace borelli {

std::string printable(std::string_view text, std::size_t most) {
  std::string out;
  for (const char c : text.substr(0, most))
    out += c >= ' ' && c <= '~' ? std::string(1, c) : fmt::format("<{:02x}>", static_cast<unsigned char>(c));
  return text.size() > most ? out + "..." : out;
}

std::string name_list(const std::vector<std::string>& names, std::size_t most) {
  const std::string out = fmt::format("{}", fmt::join(names | std::views::take(most), ", "));
  return names.size() > most ? out + fmt::format(" and {} more", names.size() - most) : out;
}

}  // namespace borelli
