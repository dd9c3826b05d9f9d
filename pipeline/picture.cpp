#include "pipeline/picture.hpp"

#include <librsvg/rsvg.h>

#include <algorithm>
#include <memory>

#include "pipeline/whole_file.hpp"

namespace borelli {

Result<void> write_png(std::string_view svg, const std::filesystem::path& path) {
  GError* error = nullptr;
  const std::unique_ptr<RsvgHandle, void (*)(RsvgHandle*)> drawing(
      rsvg_handle_new_from_data(reinterpret_cast<const guint8*>(svg.data()), svg.size(), &error),
      [](RsvgHandle* h) {
        if (h) g_object_unref(h);
      });
  const auto fails = [&] {
    const std::string why = error ? error->message : "it has no size in pixels";
    g_clear_error(&error);
    return failure(path.string(), "cannot be drawn: " + why);
  };
  double width = 0, height = 0;
  if (!drawing || !rsvg_handle_get_intrinsic_size_in_pixels(drawing.get(), &width, &height)) return fails();
  const RsvgRectangle frame{0, 0, 2 * width, 2 * height};
  const std::unique_ptr<cairo_surface_t, void (*)(cairo_surface_t*)> surface(
      cairo_image_surface_create(CAIRO_FORMAT_RGB24, int(frame.width), int(frame.height)),
      cairo_surface_destroy);
  const std::unique_ptr<cairo_t, void (*)(cairo_t*)> pen(cairo_create(surface.get()), cairo_destroy);
  if (!rsvg_handle_render_document(drawing.get(), pen.get(), &frame, &error)) return fails();
  return write_whole(path, [&](const std::filesystem::path& part) -> Result<void> {
    if (const cairo_status_t status = cairo_surface_write_to_png(surface.get(), part.c_str());
        status != CAIRO_STATUS_SUCCESS)
      return failure(path.string(), cairo_status_to_string(status));
    return {};
  });
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
        std::error_code ignored;  // (what cannot be removed does no harm)
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
