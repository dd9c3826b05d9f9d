// The ending of a file's name, by which formats are chosen.
#pragma once

#include <algorithm>
#include <filesystem>
#include <string>

namespace borelli {

/// The last ending with its dot, in small letters: ".toml" of "A.B.TOML"; empty if there is none.
inline std::string ending_of(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return ending;
}

}  // namespace borelli
