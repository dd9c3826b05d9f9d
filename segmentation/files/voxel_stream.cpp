#include "segmentation/files/voxel_stream.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>

namespace borelli {
namespace {

// Checks that the file can hold `need` bytes of voxels. Deflate packs at most 1032 to 1 (zlib's technical
// notes); a number as text takes at least one byte.
Result<void> check_length(const ImageHeader& header, const VoxelFile& file, std::uint64_t size,
                          std::uint64_t need) {
  const std::uint64_t have = size > file.offset ? size - file.offset : 0;
  const bool packed = header.packing != ByteSource::Packing::plain;
  std::uint64_t least = need;
  if (header.text) least = need / scalar_bytes(header.scalar);
  if (header.packing == ByteSource::Packing::deflated) least = need / 1032 > 0 ? need / 1032 - 1 : 0;
  if (header.packing == ByteSource::Packing::bzip2) least = 0;
  if (least <= have) return {};
  return failure(
      file.path,
      fmt::format(
          "is cut off or has a damaged header: the header states {} bytes of voxels{}, but the file has {}{}",
          need, packed ? " unpacked" : "", have, packed ? " packed" : ""));
}

}  // namespace

VoxelStream::VoxelStream(const ImageHeader& header, std::uint64_t bytes)
    : header_(header), files_(header.voxel_files()), share_(bytes / files_.size()) {}

Result<void> VoxelStream::open_next() {
  if (auto ended = finish(); !ended) return ended;
  const VoxelFile& file = files_[next_++];
  auto source = ByteSource::open(file.path, header_.packing, file.offset);
  if (!source) return tl::unexpected(source.error());
  if (auto fine = check_length(header_, file, source->file_size(), header_.stream_offset + share_); !fine)
    return fine;
  if (const auto skipped = source->skip(header_.stream_offset); !skipped)
    return tl::unexpected(skipped.error());
  source_.emplace(std::move(*source));
  if (header_.text) text_.emplace(file.path, *source_, header_.scalar);
  left_ = share_;
  return {};
}

Result<void> VoxelStream::read(std::span<std::byte> target) {
  while (!target.empty()) {
    if (left_ == 0)
      if (auto opened = open_next(); !opened) return opened;
    const auto step = target.first(static_cast<std::size_t>(std::min<std::uint64_t>(left_, target.size())));
    const auto got = text_ ? text_->read(step) : source_->read(step);
    if (!got) return tl::unexpected(got.error());
    left_ -= *got;
    if (*got < step.size())
      return failure(files_[next_ - 1].path,
                     fmt::format("is cut off: it has {} of {} bytes of voxels", share_ - left_, share_));
    target = target.subspan(step.size());
  }
  return {};
}

Result<void> VoxelStream::finish() {
  if (text_) return text_->finish();
  if (!source_) return {};
  if (header_.packing == ByteSource::Packing::plain) {
    note_surplus(source_->file_size() - files_[next_ - 1].offset - header_.stream_offset - share_);
    return {};
  }
  // Damage can make a stream longer, even endless: stop after twice the expected bytes.
  const std::uint64_t most = share_ + (std::uint64_t{1} << 20);
  const auto rest = source_->skip(most);
  if (!rest) return tl::unexpected(rest.error());
  if (*rest == most)
    return failure(
        files_[next_ - 1].path,
        fmt::format("unpacks to more than twice the {} bytes of voxels that its header states; it is damaged",
                    share_));
  note_surplus(*rest);
  return {};
}

void VoxelStream::note_surplus(std::uint64_t bytes) {
  const auto& size = header_.grid.size;
  const std::uint64_t slice = static_cast<std::uint64_t>(size[0] * size[1]) * scalar_bytes(header_.scalar);
  if (bytes >= slice)
    warnings_.push_back(fmt::format(
        "{} holds {} bytes more than its header describes (a slice has {}); check the sizes in the "
        "header",
        std::filesystem::path(files_[next_ - 1].path).filename().string(), bytes, slice));
}

}  // namespace borelli
