// Compressed streams: those of another program are read; damaged volumes are refused or read with the
// original values, never with others.
#include <gtest/gtest.h>
#include <zlib.h>

#include <random>
#include <span>

#include "grids.hpp"
#include "scratch_folder.hpp"
#include "segmentation/files/byte_stream.hpp"
#include "segmentation/files/read.hpp"
#include "segmentation/files/write.hpp"

namespace borelli {
namespace {

std::vector<char> packed(const ScratchFolder& folder, const std::vector<char>& plain) {
  auto sink = ByteSink::create(folder / "packed", ByteSink::Packing::gzip);
  EXPECT_TRUE(sink && sink->write(std::as_bytes(std::span(plain))) && sink->close());
  return file_bytes(folder / "packed");
}

// Four kilobytes follow the promised voxels; the checksum after them is wrong. gzip itself refuses such a
// file.
TEST(ByteStream, ChecksTheChecksumAfterSurplusBytes) {
  ScratchFolder folder;
  const GreyVolume volume = noise_volume(oblique_grid(false, 0), Quantity::hu);
  ASSERT_TRUE(write_volume(folder / "plain.nii", volume));
  auto plain = file_bytes(folder / "plain.nii");
  plain.resize(plain.size() + 4096, 'x');
  auto bytes = packed(folder, plain);
  put_bytes(folder / "a.nii.gz", bytes);
  ASSERT_TRUE(read_volume(folder / "a.nii.gz"));
  bytes[bytes.size() - 8] ^= 1;  // RFC 1952: the last eight bytes are CRC-32 and length
  put_bytes(folder / "a.nii.gz", bytes);
  const auto damaged = read_volume(folder / "a.nii.gz");
  ASSERT_FALSE(damaged);
  EXPECT_NE(damaged.error().what.find("damaged compressed data"), std::string::npos)
      << damaged.error().message();
  bytes[bytes.size() - 8] ^= 1;
  bytes[bytes.size() - 1] ^= 1;
  put_bytes(folder / "a.nii.gz", bytes);
  EXPECT_FALSE(read_volume(folder / "a.nii.gz")) << "its length is wrong";
}

// Packed by zlib at `level`: a gzip member (bits 15 + 16), with every field that its header may have (RFC
// 1952; bgzip's has some) or none, or a zlib stream (bits 15).
std::vector<char> packed_by_zlib(std::span<const char> plain, int level, int bits, bool every_field) {
  z_stream zlib{};
  EXPECT_EQ(deflateInit2(&zlib, level, Z_DEFLATED, bits, 8, Z_DEFAULT_STRATEGY), Z_OK);
  unsigned char extra[] = {'B', 'C', 2, 0, 7, 1}, name[] = "name", comment[] = "comment";
  gz_header header{};
  header.time = 1;
  header.extra = extra, header.extra_len = sizeof extra;
  header.name = name, header.comment = comment;
  header.hcrc = 1;
  EXPECT_TRUE(!every_field || deflateSetHeader(&zlib, &header) == Z_OK);
  std::vector<char> out(deflateBound(&zlib, plain.size()) + 100);
  zlib.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(plain.data()));
  zlib.avail_in = static_cast<uInt>(plain.size());
  zlib.next_out = reinterpret_cast<Bytef*>(out.data());
  zlib.avail_out = static_cast<uInt>(out.size());
  EXPECT_EQ(deflate(&zlib, Z_FINISH), Z_STREAM_END);
  out.resize(out.size() - zlib.avail_out);
  deflateEnd(&zlib);
  return out;
}

// The whole stream, read in pieces of `piece` bytes, or the error's text in `error`.
std::vector<char> unpacked(const std::string& path, std::size_t piece, std::string& error) {
  std::vector<char> out;
  auto source = ByteSource::open(path, ByteSource::Packing::deflated);
  EXPECT_TRUE(source);
  for (;;) {
    const std::size_t before = out.size();
    out.resize(before + piece);
    const auto got = source->read(std::as_writable_bytes(std::span(out).subspan(before)));
    if (!got) error = got.error().what;
    out.resize(before + (got ? *got : 0));
    if (!got || *got < piece) return out;
  }
}

TEST(ByteStream, ReadsStreamsOfOtherCompressors) {
  ScratchFolder folder;
  std::mt19937 random(5);
  std::vector<char> plain(400000);  // packed, more than one block of the file that is read at once
  for (std::size_t n = 0; n < plain.size(); ++n)
    plain[n] = static_cast<char>(n % 5000 < 2500 ? n / 100 : random());
  constexpr int gzip = 15 + 16, zlib = 15;
  const auto expect = [&](const std::vector<char>& stream, const std::vector<char>& whole) {
    put_bytes(folder / "a", stream);
    for (const std::size_t piece : {777u, 65536u, 1u << 20}) {
      std::string error;
      EXPECT_EQ(unpacked(folder / "a", piece, error), whole) << piece;
      EXPECT_EQ(error, "");
    }
    for (const std::size_t left : {stream.size() / 2, stream.size() - 1}) {
      put_bytes(folder / "cut", {stream.begin(), stream.begin() + std::ptrdiff_t(left)});
      std::string error;
      unpacked(folder / "cut", 1000, error);
      EXPECT_NE(error.find("cut off"), std::string::npos) << left << ": " << error;
    }
  };
  for (const int level : {0, 1, 6, 9}) {
    SCOPED_TRACE(level);
    expect(packed_by_zlib(plain, level, gzip, true), plain);
    expect(packed_by_zlib(plain, level, zlib, false), plain);
    std::vector<char> members, thrice;
    for (const std::size_t size : {std::size_t{0}, std::size_t{1}, plain.size()}) {
      const auto member = packed_by_zlib(std::span(plain).first(size), level, gzip, size > 0);
      members.insert(members.end(), member.begin(), member.end());
      thrice.insert(thrice.end(), plain.begin(), plain.begin() + std::ptrdiff_t(size));
    }
    expect(members, thrice);
  }
  // bytes after the last member do not belong to the stream
  auto followed = packed_by_zlib(plain, 6, gzip, false);
  followed.insert(followed.end(), 100, 'x');
  put_bytes(folder / "a", followed);
  std::string error;
  EXPECT_EQ(unpacked(folder / "a", 1 << 20, error), plain);
  EXPECT_EQ(error, "");
}

// The second member's header crosses the edge of a block of the file, at each of its bytes.
TEST(ByteStream, ReadsHeadersAcrossBlockEdges) {
  ScratchFolder folder;
  constexpr std::size_t edge = ByteSource::block;
  constexpr int gzip = 15 + 16;
  const std::vector<char> zeros(edge), second{'s', 'e', 'c', 'o', 'n', 'd'};
  const std::size_t around =
      packed_by_zlib(std::span(zeros).first(edge - 1000), 0, gzip, true).size() - (edge - 1000);
  for (std::size_t before = 0; before < 45; ++before) {
    const auto first = std::span(zeros).first(edge - before - around);
    auto stream = packed_by_zlib(first, 0, gzip, true);
    ASSERT_EQ(stream.size(), edge - before);
    const auto member = packed_by_zlib(second, 6, gzip, true);
    stream.insert(stream.end(), member.begin(), member.end());
    put_bytes(folder / "a", stream);
    std::vector<char> whole(first.begin(), first.end());
    whole.insert(whole.end(), second.begin(), second.end());
    std::string error;
    EXPECT_EQ(unpacked(folder / "a", 1 << 20, error), whole) << before << ": " << error;
  }
}

TEST(ByteStream, BytesAfterAZlibStreamAreNoMember) {
  ScratchFolder folder;
  const std::vector<char> plain(3000, 'a');
  for (const std::string& rest :
       {std::string("\x1f"), std::string("\x1f\x8b\b"), std::string("\0\0\0\x1f\0\0", 6)}) {
    auto stream = packed_by_zlib(plain, 6, 15, false);
    stream.insert(stream.end(), rest.begin(), rest.end());
    put_bytes(folder / "a", stream);
    std::string error;
    EXPECT_EQ(unpacked(folder / "a", 5000, error), plain);
    EXPECT_EQ(error, "");
  }
}

// One flipped bit in each byte of the compressed stream.
TEST(ByteStream, NoFlippedBitGoesUnnoticed) {
  for (const std::string name : {"a.nii.gz", "a.nrrd", "a.mha"}) {
    ScratchFolder folder;
    const GreyVolume volume = noise_volume(oblique_grid(false, 0), Quantity::hu);
    ASSERT_TRUE(write_volume(folder / name, volume));
    const auto whole = file_bytes(folder / name);
    // noise is hardly compressed, so the last 200 bytes are voxels and checksum, after all headers
    ASSERT_GT(whole.size(), 300u);
    int harmless = 0;
    for (std::size_t n = whole.size() - 200; n < whole.size(); ++n) {
      auto bytes = whole;
      bytes[n] = static_cast<char>(bytes[n] ^ (1 << (n % 8)));
      put_bytes(folder / name, bytes);
      const auto back = read_volume(folder / name);
      // padding bits in the last byte before the checksum have no meaning (RFC 1951): at most one such byte
      if (!back) continue;
      EXPECT_EQ(back->volume.voxels, volume.voxels) << name << " at " << n;
      EXPECT_EQ(++harmless, 1) << name << " at " << n;
    }
  }
}

}  // namespace
}  // namespace borelli
