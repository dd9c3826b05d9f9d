#include "segmentation/files/byte_stream.hpp"

#include <bzlib.h>
#include <isa-l/igzip_lib.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "process/input_file.hpp"

namespace borelli {
namespace {

// zlib's fastest level that still finds matches well: level 6 takes four times as long for files 10 % smaller
constexpr int level = 2;

std::string reason() { return std::generic_category().message(errno); }

const char* words(int inflate_status) {
  switch (inflate_status) {
    case ISAL_INVALID_WRAPPER:
      return "it does not begin with a compression header";
    case ISAL_UNSUPPORTED_METHOD:
      return "its compression method is unknown";
    case ISAL_INCORRECT_CHECKSUM:
      return "its checksum or length does not match";
    case ISAL_NEED_DICT:
      return "its dictionary is missing";
    default:
      return "it contains an impossible block, symbol or distance";
  }
}

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

}  // namespace

// ---------------------------------------------------------------- reading

struct ByteSource::State {
  std::string path;
  File file;
  std::uint64_t size = 0;
  bool packed = false, raw = false;
  bool begun = false, ended = false;  // state of the compressed stream; ended: complete
  bool bunzip = false, bzip2_open = false;
  bz_stream bzip2;
  inflate_state stream;
  isal_gzip_header header;  // of the member; may continue in the next block
  std::array<unsigned char, block> input;

  ~State() {
    if (bzip2_open) BZ2_bzDecompressEnd(&bzip2);
  }

  // next block of the file into `input`; 0 bytes at the file's end
  Result<std::size_t> next_block() {
    const std::size_t got = std::fread(input.data(), 1, input.size(), file.get());
    if (got == 0 && std::ferror(file.get())) return failure(path, "cannot be read: " + reason());
    return got;
  }

  // next block of the file into the stream's input; false at the file's end
  Result<bool> refill() {
    const auto got = next_block();
    if (!got) return tl::unexpected(got.error());
    stream.avail_in = static_cast<std::uint32_t>(*got);
    stream.next_in = input.data();
    return *got > 0;
  }

  // Called at the stream's start and after each member: begins a gzip or zlib stream or the next gzip member,
  // or ends the source. Other bytes after a member are ignored.
  Result<void> next_member() {
    if (raw) {
      isal_inflate_reset(&stream);
      stream.crc_flag = ISAL_DEFLATE;
      ended = begun, begun = true;
      return {};
    }
    if (stream.avail_in == 0) {
      const auto more = refill();
      if (!more) return tl::unexpected(more.error());
    }
    const bool gzip = stream.avail_in > 0 && stream.next_in[0] == 0x1f;
    if (begun && (!gzip || stream.crc_flag == ISAL_ZLIB)) {
      ended = true;
    } else {
      isal_inflate_reset(&stream);
      stream.crc_flag = gzip ? ISAL_GZIP : ISAL_ZLIB;
      header = {};  // in full: isal_gzip_header_init leaves fields unset that are read
      isal_gzip_header_init(&header);
      begun = true;
    }
    return {};
  }

  // (isal_inflate alone forgets a header that continues in the next block)
  int inflate() {
    if (stream.crc_flag == ISAL_GZIP && stream.wrapper_flag == 0)
      if (const int status = isal_read_gzip_header(&stream, &header); status != ISAL_DECOMP_OK) return status;
    return isal_inflate(&stream);
  }

  Result<std::size_t> inflate_into(std::span<std::byte> target) {
    if (!begun)
      if (const auto done = next_member(); !done) return tl::unexpected(done.error());
    std::size_t got = 0;
    while (got < target.size() && !ended) {
      const std::size_t room = std::min<std::size_t>(target.size() - got, std::size_t{1} << 30);
      stream.next_out = reinterpret_cast<std::uint8_t*>(target.data() + got);
      stream.avail_out = static_cast<std::uint32_t>(room);
      const int status = inflate();
      got += room - stream.avail_out;
      if (status < 0 || status == ISAL_NEED_DICT)
        return failure(path, std::string("contains damaged compressed data (") + words(status) + ")");
      if (stream.block_state == ISAL_BLOCK_FINISH) {
        if (const auto done = next_member(); !done) return tl::unexpected(done.error());
      } else if (stream.avail_in == 0 && stream.avail_out > 0) {
        const auto more = refill();
        if (!more) return tl::unexpected(more.error());
        if (!*more) return failure(path, "is cut off: its compressed data end too early");
      }
    }
    return got;
  }

  // next block of the file into bzip2's input; false at the file's end
  Result<bool> refill_bzip2() {
    const auto got = next_block();
    if (!got) return tl::unexpected(got.error());
    bzip2.next_in = reinterpret_cast<char*>(input.data()), bzip2.avail_in = static_cast<unsigned>(*got);
    return *got > 0;
  }

  // Opens the stream that begins at bzip2's input. Ends the source if none does.
  void next_bzip2_stream() {
    if (bzip2_open) BZ2_bzDecompressEnd(&bzip2);
    bzip2_open = false;
    if (begun && (bzip2.avail_in == 0 || *bzip2.next_in != 'B')) {
      ended = true;
      return;
    }
    bz_stream fresh{};
    if (begun) fresh.next_in = bzip2.next_in, fresh.avail_in = bzip2.avail_in;
    bzip2 = fresh;
    if (BZ2_bzDecompressInit(&bzip2, 0, 0) != BZ_OK) throw std::bad_alloc();  // the only failure here
    bzip2_open = begun = true;
  }

  Result<std::size_t> bunzip_into(std::span<std::byte> target) {
    if (!begun) next_bzip2_stream();
    std::size_t got = 0;
    while (got < target.size() && !ended) {
      if (bzip2.avail_in == 0) {
        const auto more = refill_bzip2();
        if (!more) return tl::unexpected(more.error());
        if (!*more) return failure(path, "is cut off: its compressed data end too early");
      }
      const std::size_t room = std::min<std::size_t>(target.size() - got, std::size_t{1} << 30);
      bzip2.next_out = reinterpret_cast<char*>(target.data() + got);
      bzip2.avail_out = static_cast<unsigned>(room);
      const int status = BZ2_bzDecompress(&bzip2);
      got += room - bzip2.avail_out;
      if (status == BZ_MEM_ERROR) throw std::bad_alloc();
      if (status != BZ_OK && status != BZ_STREAM_END)
        return failure(path, status == BZ_DATA_ERROR_MAGIC
                                 ? "does not contain bzip2 data where its header says so"
                                 : "contains damaged compressed data (bzip2)");
      if (status == BZ_STREAM_END) {
        if (bzip2.avail_in == 0) {
          const auto more = refill_bzip2();
          if (!more) return tl::unexpected(more.error());
        }
        next_bzip2_stream();
      }
    }
    return got;
  }
};

ByteSource::ByteSource(std::unique_ptr<State> state) : state_(std::move(state)) {}
ByteSource::ByteSource(ByteSource&&) noexcept = default;
ByteSource& ByteSource::operator=(ByteSource&&) noexcept = default;
ByteSource::~ByteSource() = default;

Result<ByteSource> ByteSource::open(const std::string& path, Packing packing, std::uint64_t offset) {
  if (auto fine = check_input_file(path); !fine) return tl::unexpected(fine.error());
  auto state = std::make_unique_for_overwrite<State>();  // buffers stay unset
  state->path = path;
  state->file.reset(std::fopen(path.c_str(), "rb"));
  if (!state->file) return bad_use(path, "cannot be opened: " + reason());
  std::error_code trouble;
  state->size = std::filesystem::file_size(path, trouble);
  if (offset > 0 && fseeko(state->file.get(), static_cast<off_t>(offset), SEEK_SET) != 0)
    return failure(path, "cannot be read: " + reason());
  if (packing != Packing::plain) {
    isal_inflate_init(&state->stream);
    state->packed = true, state->raw = packing == Packing::raw;
  }
  state->bunzip = packing == Packing::bzip2;
  return ByteSource(std::move(state));
}

Result<std::size_t> ByteSource::read(std::span<std::byte> target) {
  if (state_->bunzip) return state_->bunzip_into(target);
  if (state_->packed) return state_->inflate_into(target);
  const std::size_t got = std::fread(target.data(), 1, target.size(), state_->file.get());
  if (got < target.size() && std::ferror(state_->file.get()))
    return failure(state_->path, "cannot be read: " + reason());
  return got;
}

Result<std::uint64_t> ByteSource::skip(std::uint64_t count) {
  std::array<std::byte, 4096> dropped;
  std::uint64_t done = 0;
  while (done < count) {
    const auto step = std::min<std::uint64_t>(count - done, dropped.size());
    const auto got = read(std::span(dropped).first(static_cast<std::size_t>(step)));
    if (!got) return tl::unexpected(got.error());
    done += *got;
    if (*got < step) break;
  }
  return done;
}

std::uint64_t ByteSource::file_size() const { return state_->size; }

Result<bool> is_gzip(const std::string& path) {
  auto source = ByteSource::open(path, ByteSource::Packing::plain);
  if (!source) return tl::unexpected(source.error());
  std::array<std::byte, 2> magic{};
  const auto got = source->read(magic);
  if (!got) return tl::unexpected(got.error());
  return *got == 2 && magic[0] == std::byte{0x1f} && magic[1] == std::byte{0x8b};
}

// ---------------------------------------------------------------- writing

struct ByteSink::State {
  std::string path;
  File file;
  bool packed = false;
  std::uint64_t written = 0;
  z_stream zlib{};
  std::array<unsigned char, ByteSource::block> output;

  ~State() {
    if (packed) deflateEnd(&zlib);
  }

  Result<void> put(const void* bytes, std::size_t count) {
    if (count > 0 && std::fwrite(bytes, 1, count, file.get()) != count)
      return failure(path, "cannot be written: " + reason());
    written += count;
    return {};
  }

  Result<void> deflate_all(int flush) {
    int status = Z_OK;
    do {
      zlib.next_out = output.data();
      zlib.avail_out = static_cast<uInt>(output.size());
      status = deflate(&zlib, flush);
      if (const auto done = put(output.data(), output.size() - zlib.avail_out); !done) return done;
    } while (zlib.avail_in > 0 || (flush == Z_FINISH && status != Z_STREAM_END));
    return {};
  }
};

ByteSink::ByteSink(std::unique_ptr<State> state) : state_(std::move(state)) {}
ByteSink::ByteSink(ByteSink&&) noexcept = default;
ByteSink& ByteSink::operator=(ByteSink&&) noexcept = default;
ByteSink::~ByteSink() = default;

Result<ByteSink> ByteSink::create(const std::string& path, Packing packing) {
  auto state = std::make_unique<State>();
  state->path = path;
  state->file.reset(std::fopen(path.c_str(), "wb"));
  if (!state->file) return bad_use(path, "cannot be written: " + reason());
  ByteSink sink(std::move(state));
  if (packing == Packing::gzip) sink.start_packing();
  return sink;
}

void ByteSink::start_packing() {
  // 15 + 16: largest window, gzip header (its time stamp stays 0)
  if (deflateInit2(&state_->zlib, level, Z_DEFLATED, 15 + 16, 9, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::bad_alloc();  // the only failure here
  state_->packed = true;
}

Result<void> ByteSink::write(std::span<const std::byte> bytes) {
  if (!state_->packed) return state_->put(bytes.data(), bytes.size());
  while (!bytes.empty()) {
    const std::size_t step = std::min<std::size_t>(bytes.size(), std::size_t{1} << 30);
    state_->zlib.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(bytes.data()));
    state_->zlib.avail_in = static_cast<uInt>(step);
    if (const auto done = state_->deflate_all(Z_NO_FLUSH); !done) return done;
    bytes = bytes.subspan(step);
  }
  return {};
}

Result<void> ByteSink::write(std::string_view text) { return write(std::as_bytes(std::span(text))); }

Result<void> ByteSink::end_packing() {
  state_->zlib.avail_in = 0;
  const auto done = state_->deflate_all(Z_FINISH);
  deflateEnd(&state_->zlib);
  state_->packed = false;
  return done;
}

std::uint64_t ByteSink::size() const { return state_->written; }

Result<void> ByteSink::overwrite(std::uint64_t offset, std::string_view text) {
  std::FILE* const file = state_->file.get();
  if (fseeko(file, static_cast<off_t>(offset), SEEK_SET) != 0 ||
      std::fwrite(text.data(), 1, text.size(), file) != text.size() || fseeko(file, 0, SEEK_END) != 0)
    return failure(state_->path, "cannot be written: " + reason());
  return {};
}

Result<void> ByteSink::close() {
  if (state_->packed) {
    if (const auto done = end_packing(); !done) return done;
  }
  std::FILE* file = state_->file.release();
  if (std::fclose(file) != 0) return failure(state_->path, "cannot be written: " + reason());
  return {};
}

}  // namespace borelli
