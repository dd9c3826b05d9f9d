// The ending of a file's name, by which formats are chosen.
#pragma once

#include <algorithm>
#include <filesystem>
#include <initializer_list>
#include <string>

#include "error/error.hpp"

namespace borelli {

/// The last ending with its dot, in small letters: ".toml" of "A.B.TOML"; empty if there is none.
inline std::string ending_of(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return ending;
}

/// Errors: the file ends otherwise; the message names the endings.
inline Result<void> expect_ending(const std::string& file, std::initializer_list<const char*> endings) {
  const std::string ending = ending_of(file);
  std::string all;
  for (const char* one : endings) {
    if (ending == one) return {};
    all += (all.empty() ? "" : one == *(endings.end() - 1) ? " or " : ", ") + std::string(one);
  }
  return bad_use(file, "ends in '" + ending + "', expected " + all);
}

}  // namespace borelli
