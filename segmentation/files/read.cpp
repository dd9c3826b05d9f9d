#include "segmentation/files/read.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <mutex>

#include "process/input_file.hpp"
#include "segmentation/files/dicom.hpp"
#include "segmentation/files/dicom_elements.hpp"
#include "segmentation/files/dicom_files.hpp"
#include "segmentation/files/plausibility.hpp"
#include "segmentation/files/volume_formats.hpp"

namespace borelli {
namespace {

bool is_folder(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::is_directory(path, ignored);
}

bool is_multi_frame(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return false;
  const auto elements = read_dicom_elements(path);
  return elements && *elements && ((*elements)->item(0x52009230) || (*elements)->text(0x00080060) == "SEG");
}

// mm: no unit error makes a body's voxel this large
constexpr double largest_voxel = 1e5;

Result<ScannedVolume> read_file(const std::string& path, const ReadOptions& options) {
  auto header = read_image_header(path);
  if (!header) return tl::unexpected(header.error());
  if (header->layers > 1)
    return bad_use(
        path,
        "is a segmentation with " + std::to_string(header->layers) +
            " layers; give its scan as the volume (run, segment and inertia take this file with --labels)");
  ValueRange range;
  std::mutex mutex;
  auto voxels = load_voxels(
      *header, options.progress, [&](const StoredVoxels& some, std::size_t first, std::size_t last) {
        const ValueRange own = value_range(some, header->slope, header->intercept, first, last);
        const std::lock_guard lock(mutex);
        range += own;
      });
  if (!voxels) return tl::unexpected(voxels.error());
  const auto reading = decide_quantity(path, *voxels, header->slope, header->intercept, range,
                                       options.quantity, header->recorded_quantity);
  if (!reading) return tl::unexpected(reading.error());

  ScannedVolume scanned;
  scanned.format = header->format + ", " + std::string(scalar_name(header->scalar));
  scanned.series_description = header->description;
  scanned.reading = reading->statement;
  scanned.warnings = std::move(header->warnings);
  std::ranges::move(voxels->warnings, std::back_inserter(scanned.warnings));
  scanned.volume.grid = header->grid;
  scanned.volume.quantity = held_as(reading->quantity);
  scanned.volume.voxels = to_int16(std::move(*voxels), header->slope, header->intercept, range,
                                   reading->quantity, scanned.warnings, &scanned.clamped);
  return scanned;
}

}  // namespace

namespace {

Result<ImageHeader> header_by_ending(const std::string& path) {
  if (auto fine = check_input_file(path); !fine) return tl::unexpected(fine.error());
  for (const Endings endings : {&VolumeFormat::endings, &VolumeFormat::halves})
    if (const VolumeFormat* format = format_of(path, endings).format) return format->read_header(path);
  if (const auto object = read_dicom_elements(path); object && *object) {
    const std::string kind = kind_without_series(**object);
    return bad_use(path, kind.empty() ? "is one slice of a DICOM series; give its folder"
                                      : "is " + kind + ", no series of images; give a CT or MR series");
  }
  return bad_use(
      path, "is not a supported volume; give a DICOM folder, " + endings_in_words(&VolumeFormat::endings));
}

}  // namespace

Result<ImageHeader> read_image_header(const std::string& path) {
  auto header = header_by_ending(path);
  if (!header) return header;
  if (header->header_file.empty()) header->header_file = path;
  // the axes must span a voxel: at least a thousandth of the volume of the box of their lengths
  const double box = header->grid.spacing().prod();
  if (!header->grid.axes.allFinite() || !header->grid.origin.allFinite() ||
      !(header->grid.voxel_volume() > 1e-3 * box))
    return failure(path, "has a damaged header: its axes do not span a voxel");
  if (!std::isfinite(header->slope) || header->slope == 0 || !std::isfinite(header->intercept))
    return failure(path,
                   "has a damaged header: its slope or intercept is not a number, or the slope is zero");
  if (const double largest = header->grid.spacing().maxCoeff(); !(largest <= largest_voxel))
    return failure(path,
                   fmt::format("has voxels of {:.3g} mm, larger than any body; check the unit", largest));
  return header;
}

Result<ScannedVolume> read_volume(const std::string& path, const ReadOptions& options) {
  const bool dicom = is_folder(path) || is_multi_frame(path);
  auto scanned = dicom ? read_dicom_folder(path, options) : read_file(path, options);
  if (!scanned) return scanned;
  const ValueCounts counts(scanned->volume);
  scanned->least = counts.least(), scanned->greatest = counts.greatest();
  if (auto doubt = doubt_of_size(scanned->volume.grid); !doubt.empty())
    scanned->warnings.push_back(std::move(doubt));
  if (auto fine = check_values(path, scanned->volume, counts, scanned->clamped, scanned->warnings); !fine)
    return tl::unexpected(fine.error());
  return scanned;
}

}  // namespace borelli
