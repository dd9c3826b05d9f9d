// Drawings as PNG files.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "error/error.hpp"
#include "pipeline/charts/plot.hpp"

namespace borelli {

/// Renders an SVG document (by librsvg) at twice its size and writes it as PNG, whole or not at all.
Result<void> write_png(std::string_view svg, const std::filesystem::path& path);

/// Writes each plot as NAME.svg and NAME.png into the folder. Removes files of names in `all` that are not
/// among the plots: an earlier call left them. Errors: not writable.
Result<void> write_plots(const std::vector<std::pair<std::string, Plot>>& plots,
                         const std::filesystem::path& folder, const std::vector<std::string>& all = {});

/// The files that write_plots makes for plots of these names.
std::vector<std::string> plot_files(const std::vector<std::string>& names);

}  // namespace borelli
