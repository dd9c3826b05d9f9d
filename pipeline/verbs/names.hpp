// Lists of names on the command line.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

namespace borelli {

/// Removes duplicates; the first occurrence stays.
inline std::vector<std::string> each_once(const std::vector<std::string>& names) {
  std::vector<std::string> out;
  for (const std::string& name : names)
    if (std::find(out.begin(), out.end(), name) == out.end()) out.push_back(name);
  return out;
}

}  // namespace borelli
