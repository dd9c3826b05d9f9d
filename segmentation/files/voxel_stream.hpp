// The voxels of a volume as one stream of bytes, from one file or from a list of slices' files, plain, packed
// or written as text.
#pragma once

#include <optional>

#include "segmentation/files/text_numbers.hpp"
#include "segmentation/image_file.hpp"

namespace borelli {

class VoxelStream {
 public:
  /// `bytes`: of all voxels together. `header` must outlive the stream.
  VoxelStream(const ImageHeader& header, std::uint64_t bytes);

  /// Opens the first file. Errors: as read, without memory taken: a file that cannot hold as many voxels.
  Result<void> start() { return open_next(); }

  /// Fills `target`, whole voxels, in the file's byte order (text: in the machine's). Errors: a file that
  /// ends before, damaged packed data, a number that its type cannot hold.
  Result<void> read(std::span<std::byte> target);

  /// Reads the last file to its end, where its checksum is. Errors: damaged packed data; far more data than
  /// the header promises.
  Result<void> finish();

 private:
  Result<void> open_next();

  const ImageHeader& header_;
  std::uint64_t share_;     // bytes of voxels in each file
  std::uint64_t left_ = 0;  // of the file that is open
  std::size_t next_ = 0;    // file to open
  std::optional<ByteSource> source_;
  std::optional<TextNumbers> text_;
};

}  // namespace borelli
