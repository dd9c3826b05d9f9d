// What a verb tells people beside its answer.
#pragma once

#include <fmt/core.h>

#include <cstdio>
#include <string>
#include <utility>

namespace borelli {

/// On standard error, by {fmt}'s rules; where nothing can be written there (a full disk, nobody who reads),
/// nowhere: the work goes on.
template <class... T>
void say(fmt::format_string<T...> format, T&&... of) {
  const std::string text = fmt::format(format, std::forward<T>(of)...);
  std::fwrite(text.data(), 1, text.size(), stderr);
}

}  // namespace borelli
