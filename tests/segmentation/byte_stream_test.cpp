// Compressed volumes that were damaged after they were written: refused, or read as they were; never
// otherwise.
#include <gtest/gtest.h>

#include "grids.hpp"
#include "scratch_folder.hpp"
#include "segmentation/byte_stream.hpp"
#include "segmentation/read.hpp"
#include "segmentation/write.hpp"

namespace borelli {
namespace {

std::vector<char> packed(const ScratchFolder& folder, const std::vector<char>& plain) {
  auto sink = ByteSink::create(folder / "packed", ByteSink::Packing::gzip);
  EXPECT_TRUE(sink && sink->write(std::as_bytes(std::span(plain))) && sink->close());
  return file_bytes(folder / "packed");
}

// Four kilobytes follow the promised voxels; the checksum after them is wrong. gzip itself refuses such a
// file.
TEST(ByteStream, ChecksumAfterMoreThanThePromisedBytesIsCompared) {
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

// One flipped bit in each byte of the compressed stream.
TEST(ByteStream, NoFlippedBitChangesVoxelsUnseen) {
  for (const std::string name : {"a.nii.gz", "a.nrrd", "a.mha"}) {
    ScratchFolder folder;
    const GreyVolume volume = noise_volume(oblique_grid(false, 0), Quantity::hu);
    ASSERT_TRUE(write_volume(folder / name, volume));
    const auto whole = file_bytes(folder / name);
    // noise hardly packs: the last 200 bytes are voxels and checksum, behind every header
    ASSERT_GT(whole.size(), 300u);
    int harmless = 0;
    for (std::size_t n = whole.size() - 200; n < whole.size(); ++n) {
      auto bytes = whole;
      bytes[n] = static_cast<char>(bytes[n] ^ (1 << (n % 8)));
      put_bytes(folder / name, bytes);
      const auto back = read_volume(folder / name);
      // bits that fill up the last byte before the checksum mean nothing (RFC 1951): at most one such byte
      if (!back) continue;
      EXPECT_EQ(back->volume.voxels, volume.voxels) << name << " at " << n;
      EXPECT_EQ(++harmless, 1) << name << " at " << n;
    }
  }
}

}  // namespace
}  // namespace borelli
