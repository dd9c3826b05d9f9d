#include "pipeline/on_demand/rsvg.hpp"

#include <librsvg/rsvg.h>

#include <memory>

#include "process/on_demand.hpp"

namespace borelli {
namespace {

Result<void> draw(std::string_view svg, const std::filesystem::path& file, const std::string& name) {
  GError* error = nullptr;
  const std::unique_ptr<RsvgHandle, void (*)(RsvgHandle*)> drawing(
      rsvg_handle_new_from_data(reinterpret_cast<const guint8*>(svg.data()), svg.size(), &error),
      [](RsvgHandle* h) {
        if (h) g_object_unref(h);
      });
  const auto fails = [&] {
    const std::string why = error ? error->message : "it has no size in pixels";
    g_clear_error(&error);
    return failure(name, "cannot be drawn: " + why);
  };
  double width = 0, height = 0;
  if (!drawing || !rsvg_handle_get_intrinsic_size_in_pixels(drawing.get(), &width, &height)) return fails();
  const RsvgRectangle frame{0, 0, 2 * width, 2 * height};
  const std::unique_ptr<cairo_surface_t, void (*)(cairo_surface_t*)> surface(
      cairo_image_surface_create(CAIRO_FORMAT_RGB24, int(frame.width), int(frame.height)),
      cairo_surface_destroy);
  const std::unique_ptr<cairo_t, void (*)(cairo_t*)> pen(cairo_create(surface.get()), cairo_destroy);
  if (!rsvg_handle_render_document(drawing.get(), pen.get(), &frame, &error)) return fails();
  const cairo_status_t status = cairo_surface_write_to_png(surface.get(), file.c_str());
  if (status != CAIRO_STATUS_SUCCESS) return failure(name, cairo_status_to_string(status));
  return {};
}

}  // namespace
}  // namespace borelli

BORELLI_ON_DEMAND(borelli::RsvgFunctions){.draw = borelli::draw};
