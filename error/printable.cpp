#include "error/printable.hpp"

#include <fmt/core.h>

namespace borelli {

std::string printable(std::string_view text, std::size_t most) {
  std::string out;
  for (const char c : text.substr(0, most))
    out += c >= ' ' && c <= '~' ? std::string(1, c) : fmt::format("<{:02x}>", static_cast<unsigned char>(c));
  return text.size() > most ? out + "..." : out;
}

}  // namespace borelli
