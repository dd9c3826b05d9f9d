#include "segmentation/files/mask_folder.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
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

// voxel counts of the mask being added to the map
struct LaidMask {
  std::int64_t voxels = 0;
  std::array<std::int64_t, 256> on{};  // its voxels that are already taken, by number
};

// Adds a mask to the map: its free voxels get `number`. A mask has one value beside 0.
Result<LaidMask> lay(const std::string& file, const StoredVoxels& mask, const ImageHeader& header,
                     std::uint8_t number, std::uint8_t* map) {
  LaidMask laid;
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
      ++laid.voxels;
      if (map[o])
        ++laid.on[map[o]];
      else
        map[o] = number;
    }
  });
  if (second != 0 || inside != inside)
    return bad_use(file, fmt::format("is not a mask: besides 0 it contains {} and {}; a mask has one value, "
                                     "and each file of the folder must be the mask of one class",
                                     inside, second));
  return laid;
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
                                    const Progress& progress) try {
  constexpr double most_overlap = 0.05;  // of the smaller
  const auto files = masks_in(folder);
  if (files.empty()) return bad_use(folder, "contains no mask");
  MaskFolder out;
  std::uint8_t* map = nullptr;
  std::map<std::string, std::string> seen;
  std::vector<std::int64_t> voxels{0};
  std::int64_t shared = 0;
  std::string sharing;
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
    const std::size_t number = std::min<std::size_t>(voxels.size(), 255);
    const auto laid = lay(file, *mask, *header, static_cast<std::uint8_t>(number), map);
    if (!laid) return tl::unexpected(laid.error());
    if (progress) progress(static_cast<double>(n + 1) / static_cast<double>(files.size()));
    if (laid->voxels == 0) continue;
    if (voxels.size() > 255) return bad_use(folder, "contains more than 255 masks with voxels");
    for (std::size_t other = 1; other < voxels.size(); ++other) {
      if (laid->on[other] == 0) continue;
      const double share =
          static_cast<double>(laid->on[other]) / static_cast<double>(std::min(laid->voxels, voxels[other]));
      const std::string& theirs = out.names[static_cast<std::int64_t>(other)];
      if (share > most_overlap)
        return bad_use(
            folder,
            fmt::format(
                "contains masks that overlap: {} and {} by {:.0f} % of the smaller one; remove one of them",
                theirs, name, 100 * share));
      if (shared == 0) sharing = theirs + " and " + name;
      shared += laid->on[other];
    }
    voxels.push_back(laid->voxels);
    out.names[static_cast<std::int64_t>(number)] = name;
  }
  if (out.names.empty()) return bad_use(folder, "contains only masks without voxels");
  if (shared > 0)
    out.warnings.push_back(fmt::format(
        "{} voxels are in two masks ({}); they were given to the first by name", shared, sharing));
  return out;
} catch (const std::bad_alloc&) {
  return out_of_memory(folder, "its label map");
}

}  // namespace borelli
