#include "pipeline/charts/picture.hpp"

#include <algorithm>

#include "pipeline/files/whole_file.hpp"
#include "pipeline/on_demand/rsvg.hpp"
#include "process/on_demand.hpp"

namespace borelli {

Result<void> write_png(std::string_view svg, const std::filesystem::path& path) {
  const auto rsvg = on_demand<RsvgFunctions>();
  if (!rsvg) return tl::unexpected(rsvg.error());
  return write_whole(
      path, [&](const std::filesystem::path& part) { return (*rsvg)->draw(svg, part, path.string()); });
}

std::vector<std::string> plot_files(const std::vector<std::string>& names) {
  std::vector<std::string> out;
  for (const std::string& name : names)
    for (const char* ending : {".svg", ".png"}) out.push_back(name + ending);
  return out;
}

Result<void> write_plots(const std::vector<std::pair<std::string, Plot>>& plots,
                         const std::filesystem::path& folder, const std::vector<std::string>& all) {
  for (const std::string& name : all)
    if (std::none_of(plots.begin(), plots.end(), [&](const auto& plot) { return plot.first == name; }))
      for (const std::string& file : plot_files({name})) {
        std::error_code ignored;  // a file that cannot be removed does no harm
        std::filesystem::remove(folder / file, ignored);
      }
  for (const auto& [name, plot] : plots) {
    const std::string drawing = svg(plot);
    if (auto done = write_whole(folder / (name + ".svg"), drawing); !done) return done;
    if (auto done = write_png(drawing, folder / (name + ".png")); !done) return done;
  }
  return {};
}

}  // namespace borelli
