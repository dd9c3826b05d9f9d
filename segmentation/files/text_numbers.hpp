// Reads voxels written as text: numbers with blanks or line ends between them; commas may stand beside those.
#pragma once

#include <string>
#include <vector>

#include "segmentation/files/byte_stream.hpp"

namespace borelli {

enum class Scalar;

class TextNumbers {
 public:
  /// `source` must outlive this.
  TextNumbers(std::string path, ByteSource& source, Scalar scalar);

  /// Fills `target` with the next numbers as the scalar type, in the machine's byte order. Returns the bytes
  /// filled, fewer than asked only at the end of the text. Errors: a word that is not a number of that type.
  Result<std::size_t> read(std::span<std::byte> target);

  /// Errors: a number is left.
  Result<void> finish();

 private:
  Result<std::string_view> next_word();

  std::string path_;
  ByteSource& source_;
  Scalar scalar_;
  std::vector<char> block_;
  std::size_t at_ = 0, end_ = 0;  // unread part of block_
};

}  // namespace borelli
