// What librsvg does for this program: SVG to PNG.
#pragma once

#include <filesystem>
#include <string_view>

#include "error/error.hpp"

namespace borelli {

struct RsvgFunctions {
  static constexpr const char* library = "borelli_rsvg";
  /// Draws `svg` at twice its size in pixels into the PNG `file`. Errors, about `name`: no drawing, or
  /// without a size; not writable.
  Result<void> (*draw)(std::string_view svg, const std::filesystem::path& file, const std::string& name);
};

}  // namespace borelli
