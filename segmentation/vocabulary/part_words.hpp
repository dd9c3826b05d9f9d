// Part and joint names in plain words.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>

namespace borelli {

/// "upper_arm_left" as "left upper arm".
inline std::string in_words(std::string_view name) {
  std::string out;
  for (const std::string_view side : {"_left", "_right"})
    if (name.ends_with(side)) {
      name.remove_suffix(side.size());
      out = std::string(side.substr(1)) + "_";
    }
  out += name;
  std::replace(out.begin(), out.end(), '_', ' ');
  return out;
}

}  // namespace borelli
