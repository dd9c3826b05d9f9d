// Reads the bytes of a C3D file through a temporary file.
#pragma once

#include <filesystem>
#include <fstream>
#include <random>
#include <string>

#include "pipeline/recordings/c3d_file.hpp"

namespace borelli::test {

inline Result<C3dFile> read_c3d_bytes(const std::string& bytes) {
  const auto path =
      std::filesystem::temp_directory_path() / ("borelli_" + std::to_string(std::random_device{}()) + ".c3d");
  std::ofstream(path, std::ios::binary) << bytes;
  auto out = read_c3d(path);
  std::filesystem::remove(path);
  return out;
}

inline bool has_warning(const std::vector<std::string>& warnings, const std::string& words) {
  for (const std::string& warning : warnings)
    if (warning.find(words) != std::string::npos) return true;
  return false;
}

}  // namespace borelli::test
