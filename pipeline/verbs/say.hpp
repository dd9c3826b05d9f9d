// Messages of a verb to people, beside its answer.
#pragma once

#include <fmt/core.h>

#include <cstdio>
#include <string>
#include <utility>

namespace borelli {

/// Prints on standard error, by {fmt}'s rules. If that fails (a full disk, a closed pipe), the message is
/// lost and the work goes on.
template <class... T>
void say(fmt::format_string<T...> format, T&&... of) {
  const std::string text = fmt::format(format, std::forward<T>(of)...);
  std::fwrite(text.data(), 1, text.size(), stderr);
}

}  // namespace borelli
