#include "segmentation/files/mask_folder.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <new>

#include "process/memory.hpp"
#include "segmentation/files/class_labels.hpp"
#include "segmentation/files/volume_formats.hpp"

namespace borelli {
namespace {

namespace fs = std::filesystem;

// a file's name without its format's extension; empty: another extension, or hidden
std::string class_in(const fs::path& file) {
  const std::string name = file.filename();
  if (name.starts_with('.')) return "";  // macOS metadata
  const NamedFormat named = format_of(name, &VolumeFormat::endings);
  return named.format ? name.substr(0, name.size() - named.ending.size()) : "";
}

// Adds a mask to the map as `number`. Answers its voxels. A mask has one value beside 0.
Result<std::size_t> lay(const std::string& file, const StoredVoxels& mask, const ImageHeader& header,
                        std::uint8_t number, SegmentOverlaps& overlaps, std::uint8_t* map) {
  std::size_t voxels = 0;
  double inside = 0, second = 0;
  with_scalar(mask.scalar, [&]<class T>(T) {
    const std::byte* at = mask.bytes();
    T before{};
    bool is_set = false;
    for (std::size_t o = 0; o < mask.count; ++o, at += sizeof(T)) {
      T stored;
      std::memcpy(&stored, at, sizeof stored);
      if (o == 0 || stored != before) {
        const double value = header.slope * static_cast<double>(stored) + header.intercept;
        is_set = value != 0;
        if (is_set && inside == 0) inside = value;
        if (is_set && value != inside && second == 0) second = value;
        before = stored;
      }
      if (!is_set) continue;
      ++voxels;
      map[o] = static_cast<std::uint8_t>(overlaps.winner(map[o], number));
    }
  });
  if (second != 0 || inside != inside)
    return bad_use(file, fmt::format("is not a mask: besides 0 it contains {} and {}; a mask has one value, "
                                     "and each file of the folder must be the mask of one class",
                                     inside, second));
  return voxels;
}

}  // namespace

std::vector<std::string> masks_in(const std::string& folder) {
  std::vector<std::string> files;
  std::error_code trouble;
  for (const auto& entry : fs::directory_iterator(folder, trouble))
    if (entry.is_regular_file(trouble) && !class_in(entry.path()).empty()) files.push_back(entry.path());
  std::ranges::sort(files);
  return files;
}

Result<MaskFolder> read_mask_folder(const std::string& folder,
                                    const std::function<Result<void>(const Grid&)>& accept,
                                    const IsUsed& is_used, const Progress& progress) try {
  const auto files = masks_in(folder);
  if (files.empty()) return bad_use(folder, "contains no mask");
  MaskFolder out;
  std::uint8_t* map = nullptr;
  std::map<std::string, std::string> seen;
  SegmentOverlaps overlaps;
  for (std::size_t n = 0; n < files.size(); ++n) {
    const std::string& file = files[n];
    const std::string name = class_in(file);
    if (!seen.emplace(name, file).second)
      return bad_use(
          folder, fmt::format("contains two masks of {}: {} and {}", name,
                              fs::path(seen[name]).filename().string(), fs::path(file).filename().string()));
    auto header = read_image_header(file);
    if (!header) return tl::unexpected(header.error());
    if (header->layers > 1) return bad_use(file, "has layers; a folder of masks needs one class per file");
    if (n == 0) {
      out.grid = header->grid;
      if (accept)
        if (auto fine = accept(out.grid); !fine) return tl::unexpected(fine.error());
      const auto count = out.grid.count();
      if (auto fits = admit_memory(folder, "its label map", static_cast<double>(count)); !fits)
        return tl::unexpected(fits.error());
      out.voxels = {Scalar::u8, count, std::vector<std::int16_t>((count + 1) / 2, 0)};
      map = reinterpret_cast<std::uint8_t*>(out.voxels.storage.data());
    } else if (!same_grid(header->grid, out.grid)) {
      return bad_use(file, "lies on another grid than " + fs::path(files[0]).filename().string() +
                               "; all masks of a folder must share one grid");
    }
    const auto mask = load_voxels(*header);
    if (!mask) return tl::unexpected(mask.error());
    std::ranges::copy(mask->warnings, std::back_inserter(out.warnings));
    const auto number = std::min(std::ssize(out.names) + 1, std::ptrdiff_t{255});
    overlaps.add(number, name, is_used && is_used(number, name, {}));
    const auto laid = lay(file, *mask, *header, static_cast<std::uint8_t>(number), overlaps, map);
    if (!laid) return tl::unexpected(laid.error());
    if (progress) progress(static_cast<double>(n + 1) / static_cast<double>(files.size()));
    if (*laid == 0) continue;
    if (out.names.size() == 255) return bad_use(folder, "contains more than 255 masks with voxels");
    out.names[number] = name;
  }
  if (out.names.empty()) return bad_use(folder, "contains only masks without voxels");
  auto told = overlaps.warnings(folder);
  if (!told) return tl::unexpected(told.error());
  std::ranges::move(*told, std::back_inserter(out.warnings));
  for (const auto number : overlaps.emptied()) out.names.erase(number);
  return out;
} catch (const std::bad_alloc&) {
  return out_of_memory(folder, "its label map");
}

}  // namespace borelli
