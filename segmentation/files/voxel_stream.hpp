// Reads the voxels of a volume as one stream of bytes, from one file or from slice files, plain, packed or
// written as text.
#pragma once

#include <optional>

#include "segmentation/files/image_file.hpp"
#include "segmentation/files/text_numbers.hpp"

namespace borelli {

class VoxelStream {
 public:
  /// `bytes`: size of all voxels. `header` must outlive the stream.
  VoxelStream(const ImageHeader& header, std::uint64_t bytes);

  /// Opens the next file. read() calls it when needed; call it first to check the first file before voxels
  /// are allocated. Errors: a file that cannot be opened or cannot hold its share of the voxels.
  Result<void> open_next();

  /// Fills `target` (whole voxels) in the file's byte order; text in the machine's. Errors: as open_next; a
  /// file that ends too early, damaged packed data, a number that its type cannot hold.
  Result<void> read(std::span<std::byte> target);

  /// Reads the open file to its end, where its checksum stands. Errors: damaged packed data; far more data,
  /// or more numbers in text, than the header promises.
  Result<void> finish();

  /// One sentence per finished file with at least a slice of bytes behind its voxels. Padding is shorter.
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  void note_surplus(std::uint64_t bytes);

  const ImageHeader& header_;
  std::vector<VoxelFile> files_;
  std::uint64_t share_;     // bytes of voxels in each file
  std::uint64_t left_ = 0;  // in the open file
  std::size_t next_ = 0;    // index in files_ of the file to open next
  std::optional<ByteSource> source_;
  std::optional<TextNumbers> text_;
  std::vector<std::string> warnings_;
};

}  // namespace borelli
