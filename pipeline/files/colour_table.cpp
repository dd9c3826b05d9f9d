#include "pipeline/files/colour_table.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>

#include "pipeline/files/palette.hpp"
#include "segmentation/files/read.hpp"

namespace borelli {

std::string colour_table(const LabelMap& labels) {
  std::string text = fmt::format("# Color table file\n# {} values\n", labels.names.size());
  std::size_t others = 0;
  for (std::size_t label = 0; label < labels.names.size(); ++label) {
    std::string name = labels.names[label].empty() ? fmt::format("label_{}", label) : labels.names[label];
    std::ranges::replace_if(
        name, [](char c) { return c == ' ' || c == '\t'; }, '_');
    const Colour c = label == 0 ? Colour{} : is_segment(name) ? part_colour(name) : other_colour(others++);
    text += fmt::format("{} {} {} {} {} {}\n", label, name, c.red, c.green, c.blue, label == 0 ? 0 : 255);
  }
  return text;
}

std::string colour_file(const std::string& path) {
  return std::filesystem::path(names_file(path)).replace_extension(".ctbl").string();
}

}  // namespace borelli
