// Part and joint names in plain words.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>

namespace borelli {

/// "upper_arm_left" as "upper arm left".
inline std::string in_words(std::string_view name) {
  std::string out(name);
  std::replace(out.begin(), out.end(), '_', ' ');
  return out;
}

}  // namespace borelli
