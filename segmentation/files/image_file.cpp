#include "segmentation/files/image_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <future>
#include <new>

#include "process/memory.hpp"
#include "segmentation/files/voxel_stream.hpp"
#include "threads/slabs.hpp"

namespace borelli {
namespace {

constexpr std::size_t chunk = std::size_t{1} << 22;  // bytes between two reports of progress

void reverse_bytes(std::byte* bytes, std::size_t count, std::size_t width) {
  for (std::byte* p = bytes; p < bytes + count * width; p += width) std::reverse(p, p + width);
}

double voxels_of(const ImageHeader& header) {
  double count = static_cast<double>(header.layers);
  for (const auto size : header.grid.size) count *= static_cast<double>(size);
  return count;
}

std::string in_words(const ImageHeader& header) {
  const auto& size = header.grid.size;
  return fmt::format("its volume of {} x {} x {} voxels of {}", size[0], size[1], size[2],
                     scalar_name(header.scalar));
}

// Bytes needed: voxels of two or more bytes become int16 in place, one-byte voxels in a second array.
double bytes_to_hold(const ImageHeader& header) {
  const auto width = static_cast<double>(scalar_bytes(header.scalar));
  return voxels_of(header) * (width > 1 ? width : 3);
}

}  // namespace

std::size_t scalar_bytes(Scalar scalar) {
  return with_scalar(scalar, []<class T>(T) { return sizeof(T); });
}

std::string_view scalar_name(Scalar scalar) {
  constexpr std::string_view names[] = {"uint8", "int8",   "uint16", "int16",   "uint32",
                                        "int32", "uint64", "int64",  "float32", "float64"};
  return names[static_cast<int>(scalar)];
}

double shear(const Grid& grid) {
  double worst = 0;
  for (int a = 0; a < 3; ++a)
    for (int b = a + 1; b < 3; ++b)
      worst = std::max(worst, std::abs(grid.axes.col(a).normalized().dot(grid.axes.col(b).normalized())));
  return worst;
}

Result<StoredVoxels> load_voxels(const ImageHeader& header, const Progress& progress, const Look& look) try {
  StoredVoxels voxels{header.scalar, header.grid.count() * static_cast<std::size_t>(header.layers), {}};
  const std::size_t width = scalar_bytes(header.scalar);
  const std::size_t bytes = voxels.count * width;

  VoxelStream stream(header, bytes);
  if (const auto opened = stream.open_next(); !opened) return tl::unexpected(opened.error());
  if (auto fits = admit_memory(header.data_file, in_words(header), bytes_to_hold(header)); !fits)
    return tl::unexpected(fits.error());

  // reserve, then grow by chunks: a wrong header then touches no more memory than the file fills
  voxels.storage.reserve((bytes + 1) / 2);
  const bool swap =
      width > 1 && !header.text && header.big_endian != (std::endian::native == std::endian::big);
  std::vector<std::future<void>> aside_of(static_cast<std::size_t>(all_threads));  // of the last chunks
  std::size_t chunks = 0;
  for (std::size_t done = 0; done < bytes;) {
    const std::size_t step = std::min(chunk, bytes - done);
    voxels.storage.resize((done + step + 1) / 2);
    std::byte* const target = reinterpret_cast<std::byte*>(voxels.storage.data()) + done;
    if (const auto got = stream.read({target, step}); !got) return tl::unexpected(got.error());
    if (swap || look) {
      auto& work = aside_of[chunks++ % aside_of.size()];
      if (work.valid()) work.get();
      work = std::async(aside(0), [&voxels, &look, target, step, swap, width, first = done / width] {
        if (swap) reverse_bytes(target, step / width, width);
        if (look) look(voxels, first, first + step / width);
      });
    }
    done += step;
    if (progress) progress(static_cast<double>(done) / static_cast<double>(bytes));
  }
  for (auto& work : aside_of)
    if (work.valid()) work.get();
  // checksum and length of a packed stream are only checked at its end
  if (const auto ended = stream.finish(); !ended) return tl::unexpected(ended.error());
  voxels.warnings = stream.warnings();
  return voxels;
} catch (const std::bad_alloc&) {
  return out_of_memory(header.data_file, in_words(header));
}

}  // namespace borelli
