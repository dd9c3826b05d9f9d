// The scene files of samples/.
#pragma once

#include <algorithm>
#include <filesystem>
#include <vector>

#include "tests/paths.hpp"

namespace borelli::test {

inline std::vector<std::filesystem::path> samples() {
  std::vector<std::filesystem::path> out;
  for (const auto& entry : std::filesystem::directory_iterator(source_folder() + "/samples"))
    if (entry.path().extension() == ".toml") out.push_back(entry.path());
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace borelli::test
