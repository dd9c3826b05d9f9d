// Drawings as pixels.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "error/error.hpp"
#include "pipeline/charts/plot.hpp"

namespace borelli {

/// Draws an SVG document (by librsvg) at twice its own size, and writes it whole as PNG.
Result<void> write_png(std::string_view svg, const std::filesystem::path& path);

/// Writes each plot as NAME.svg and NAME.png into the folder, and removes those of `all` names that are not
/// among them: what an earlier call left there of something else. Errors: not writable.
Result<void> write_plots(const std::vector<std::pair<std::string, Plot>>& plots,
                         const std::filesystem::path& folder, const std::vector<std::string>& all = {});

/// The files that write_plots makes of plots of these names.
std::vector<std::string> plot_files(const std::vector<std::string>& names);

}  // namespace borelli
