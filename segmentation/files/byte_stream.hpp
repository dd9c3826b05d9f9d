// Reads and writes the bytes of a file, plain or compressed, as a stream: a volume is never in memory twice.
//
// Reading: a plain file, a gzip or bzip2 file (also with several members, as pigz, bgzip and pbzip2 write
// them), or a zlib stream at some offset. Writing: plain or gzip, without a time stamp, so that equal input
// gives equal bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "error/error.hpp"

namespace borelli {

class ByteSource {
 public:
  static constexpr std::size_t block = std::size_t{1} << 18;  ///< bytes of a packed file read at a time
  /// deflated: gzip or zlib, told apart by the stream's header; raw: deflate without a header (RFC 1951)
  enum class Packing { plain, deflated, raw, bzip2 };

  /// Opens `path` at `offset` bytes from its start. Errors: missing, a folder, not readable.
  static Result<ByteSource> open(const std::string& path, Packing packing, std::uint64_t offset = 0);

  /// Fills `target` as far as the stream reaches; returns the bytes read, fewer than requested only at the
  /// stream's end. Errors: damaged or cut compressed data, a failing disk.
  Result<std::size_t> read(std::span<std::byte> target);

  /// Reads and drops `count` bytes; returns how many there were. Errors as `read`. Only reading a compressed
  /// stream to its end checks its checksum and length.
  Result<std::uint64_t> skip(std::uint64_t count);

  std::uint64_t file_size() const;  ///< bytes of the file on disk

  ByteSource(ByteSource&&) noexcept;
  ByteSource& operator=(ByteSource&&) noexcept;
  ~ByteSource();

 private:
  struct State;
  explicit ByteSource(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// Whether a file starts with gzip's two magic bytes. Errors as ByteSource::open.
Result<bool> is_gzip(const std::string& path);

class ByteSink {
 public:
  enum class Packing { plain, gzip };

  /// Creates or replaces `path`. Errors: the folder is missing or not writable.
  static Result<ByteSink> create(const std::string& path, Packing packing);

  Result<void> write(std::span<const std::byte> bytes);
  Result<void> write(std::string_view text);

  /// Compresses everything written from here on (NRRD and MetaImage have a plain header before packed
  /// voxels).
  void start_packing();
  Result<void> end_packing();

  std::uint64_t size() const;  ///< bytes in the file so far, as packed

  /// Overwrites bytes that were written uncompressed, from `offset` on.
  Result<void> overwrite(std::uint64_t offset, std::string_view text);

  /// Flushes and closes. The file is complete only if this returns no error.
  Result<void> close();

  ByteSink(ByteSink&&) noexcept;
  ByteSink& operator=(ByteSink&&) noexcept;
  ~ByteSink();

 private:
  struct State;
  explicit ByteSink(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace borelli
