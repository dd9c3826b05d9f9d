// Functions of the library that calls librsvg: SVG to PNG.
#pragma once

#include <filesystem>
#include <string_view>

#include "error/error.hpp"

namespace borelli {

struct RsvgFunctions {
  static constexpr const char* library = "borelli_rsvg";
  /// Renders `svg` to the PNG `file`, with two pixels for each unit of length. Error messages call the
  /// drawing `name`. Errors: `svg` is not SVG, or states no size; `file` cannot be written.
  Result<void> (*draw)(std::string_view svg, const std::filesystem::path& file, const std::string& name);
};

}  // namespace borelli
