#include "segmentation/files/write.hpp"

#include "error/plain_cell.hpp"
#include "segmentation/files/quantity.hpp"
#include "segmentation/files/read.hpp"
#include "segmentation/files/volume_formats.hpp"

namespace borelli {
namespace {

Result<void> write_image(const std::string& path, const Grid& grid, Scalar scalar,
                         std::span<const std::byte> voxels, const std::string& quantity) {
  if (voxels.size() != grid.count() * scalar_bytes(scalar)) {
    return failure(path, "was not written: the grid has " + std::to_string(grid.count()) +
                             " voxels, and the volume has " +
                             std::to_string(voxels.size() / scalar_bytes(scalar)));
  }
  if (const VolumeFormat* format = format_of(path, &VolumeFormat::written).format)
    return format->write(path, grid, scalar, voxels, quantity);
  return bad_use(path, "is not a supported file name for a volume; end it in " +
                           endings_in_words(&VolumeFormat::written));
}

}  // namespace

Result<void> write_volume(const std::string& path, const GreyVolume& volume) {
  return write_image(path, volume.grid, Scalar::i16, std::as_bytes(std::span(volume.voxels)),
                     std::string(quantity_name(volume.quantity)));
}

Result<void> write_labels(const std::string& path, const LabelMap& labels) {
  const auto done =
      write_image(path, labels.grid, Scalar::u8, std::as_bytes(std::span(labels.voxels)), "labels");
  if (!done) return done;
  auto table = ByteSink::create(names_file(path), ByteSink::Packing::plain);
  if (!table) return tl::unexpected(table.error());
  std::string text = "label\tname\n";
  for (std::size_t label = 0; label < labels.names.size(); ++label)
    if (!labels.names[label].empty())
      text += std::to_string(label) + "\t" + plain_cell(labels.names[label]) + "\n";
  if (const auto written = table->write(std::string_view(text)); !written) return written;
  return table->close();
}

}  // namespace borelli
