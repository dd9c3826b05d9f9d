// A checksum of an embedded data file, by which a test notices any changed digit.
#pragma once

#include <cstdint>
#include <string_view>

namespace borelli {

// FNV-1a, 64 bits (Fowler, Noll and Vo)
inline std::uint64_t checksum(std::string_view text) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  return hash;
}

}  // namespace borelli
