#include "segmentation/image_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <filesystem>
#include <future>
#include <limits>
#include <new>

#include "threads/slabs.hpp"

namespace borelli {
namespace {

constexpr std::size_t chunk = std::size_t{1} << 22;  // bytes between two reports of progress

void reverse_bytes(std::byte* bytes, std::size_t count, std::size_t width) {
  for (std::byte* p = bytes; p < bytes + count * width; p += width) std::reverse(p, p + width);
}

// Before memory is taken: can the file hold that much at all? Deflate packs at most 1032 to 1 (zlib's
// technical notes), so a header that promises more than that is damaged.
Result<void> check_length(const ImageHeader& header, std::uint64_t file_size, std::uint64_t need) {
  const std::uint64_t have = file_size > header.file_offset ? file_size - header.file_offset : 0;
  const bool packed = header.packing == ByteSource::Packing::deflated;
  if (packed ? need / 1032 > have + 1 : need > have) {
    return failure(header.data_file, "is cut off or its header is damaged: the header promises " +
                                         std::to_string(need) + " bytes" + (packed ? " unpacked" : "") +
                                         ", the file has " + std::to_string(have) +
                                         (packed ? " packed" : ""));
  }
  return {};
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

  auto source = ByteSource::open(header.data_file, header.packing, header.file_offset);
  if (!source) return tl::unexpected(source.error());
  if (const auto long_enough = check_length(header, source->file_size(), header.stream_offset + bytes);
      !long_enough)
    return tl::unexpected(long_enough.error());
  if (const auto skipped = source->skip(header.stream_offset); !skipped)
    return tl::unexpected(skipped.error());

  // reserve, then grow by chunks: a header that lies touches no more memory than the file can fill
  voxels.storage.reserve((bytes + 1) / 2);
  const bool swap = width > 1 && header.big_endian != (std::endian::native == std::endian::big);
  std::vector<std::future<void>> aside_of(static_cast<std::size_t>(all_threads));  // of the latest chunks
  std::size_t chunks = 0;
  for (std::size_t done = 0; done < bytes;) {
    const std::size_t step = std::min(chunk, bytes - done);
    voxels.storage.resize((done + step + 1) / 2);
    std::byte* const target = reinterpret_cast<std::byte*>(voxels.storage.data()) + done;
    const auto got = source->read({target, step});
    if (!got) return tl::unexpected(got.error());
    if (*got < step) {
      return failure(header.data_file, "is cut off: it holds " + std::to_string(done + *got) + " of " +
                                           std::to_string(bytes) + " bytes of voxels");
    }
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
  // checksum and length are compared at the stream's end only; damage can also make the stream longer
  if (header.packing == ByteSource::Packing::deflated) {
    if (const auto rest = source->skip(std::numeric_limits<std::uint64_t>::max()); !rest)
      return tl::unexpected(rest.error());
  }
  return voxels;
} catch (const std::bad_alloc&) {
  return failure(header.data_file, "does not fit into memory: " + std::to_string(header.grid.count()) +
                                       " voxels of " + std::string(scalar_name(header.scalar)));
}

Result<std::string> named_data_file(const std::string& path, std::string_view file, std::string_view joined) {
  if (file.starts_with("LIST") || file.find('%') != std::string_view::npos)
    return failure(path, fmt::format("keeps its slices in separate files; join them into one {}", joined));
  return (std::filesystem::path(path).parent_path() / file).string();
}

Result<std::uint64_t> voxels_at_end(const ImageHeader& header) {
  const auto source = ByteSource::open(header.data_file, ByteSource::Packing::plain);
  if (!source) return tl::unexpected(source.error());
  const std::uint64_t need =
      header.grid.count() * static_cast<std::uint64_t>(header.layers) * scalar_bytes(header.scalar);
  if (source->file_size() < need)
    return failure(header.data_file, fmt::format("is cut off: its header promises {} bytes, it has {}", need,
                                                 source->file_size()));
  return source->file_size() - need;
}

}  // namespace borelli
