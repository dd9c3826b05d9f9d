// Drawings as pixels.
#pragma once

#include <filesystem>
#include <string_view>

#include "error/error.hpp"

namespace borelli {

/// Draws an SVG document (by librsvg) at twice its own size, and writes it whole as PNG.
Result<void> write_png(std::string_view svg, const std::filesystem::path& path);

}  // namespace borelli
