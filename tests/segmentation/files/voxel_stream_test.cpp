// Files that hold more voxels than their header describes.
#include "segmentation/files/voxel_stream.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "segmentation/files/read.hpp"
#include "segmentation/files/write.hpp"
#include "tests/segmentation/scratch_folder.hpp"

namespace borelli::voxel_stream_test {
namespace {

// 4 x 4 x 6 labels, of one byte each
LabelMap made() {
  LabelMap map;
  map.grid.size = {4, 4, 6};
  map.grid.axes *= 2;
  map.voxels.assign(map.grid.count(), 1);
  map.names = {"outside", "one"};
  return map;
}

void replace(std::vector<char>& bytes, const std::string& from, const std::string& to) {
  const auto at = std::search(bytes.begin(), bytes.end(), from.begin(), from.end());
  ASSERT_NE(at, bytes.end()) << from;
  std::ranges::copy(to, at);
}

std::string told(const std::string& path) {
  const auto read = read_labels(path);
  if (!read) return read.error().message();
  std::string all;
  for (const std::string& warning : read->warnings) all += warning;
  return all;
}

// The header states 3 of 6 slices of 16 bytes.
TEST(VoxelStream, TellsOfSlicesThatTheHeaderDoesNotDescribe) {
  const ScratchFolder folder;
  for (const std::string name : {"a.nii", "a.nrrd", "a.mha"}) {
    ASSERT_TRUE(write_labels(folder / name, made()));
    EXPECT_EQ(told(folder / name), "");
    auto bytes = file_bytes(folder / name);
    if (name == "a.nii") {
      ASSERT_EQ(bytes[46], 6);  // dim[3]
      bytes[46] = 3;
    } else {
      replace(bytes, "4 4 6", "4 4 3");
    }
    put_bytes(folder / name, bytes);
    EXPECT_EQ(told(folder / name), name +
                                       " holds 48 bytes more than its header describes (a slice has 16); "
                                       "check the sizes in the header");
  }
  auto sink = ByteSink::create(folder / "b.nii.gz", ByteSink::Packing::gzip);
  ASSERT_TRUE(sink);
  const auto plain = file_bytes(folder / "a.nii");
  ASSERT_TRUE(sink->write(std::string_view(plain.data(), plain.size())));
  ASSERT_TRUE(sink->close());
  EXPECT_NE(told(folder / "b.nii.gz").find("b.nii.gz holds 48 bytes more"), std::string::npos);
}

TEST(VoxelStream, IgnoresPaddingShorterThanASlice) {
  const ScratchFolder folder;
  ASSERT_TRUE(write_labels(folder / "a.nii", made()));
  auto bytes = file_bytes(folder / "a.nii");
  bytes.resize(bytes.size() + 15);
  put_bytes(folder / "a.nii", bytes);
  EXPECT_EQ(told(folder / "a.nii"), "");
  bytes.resize(bytes.size() + 1);
  put_bytes(folder / "a.nii", bytes);
  EXPECT_NE(told(folder / "a.nii").find("a.nii holds 16 bytes more"), std::string::npos);
}

// A file of voxels beside its header; with -1 the voxels are its last bytes.
TEST(VoxelStream, TellsOfRawFilesThatAreTooLong) {
  const ScratchFolder folder;
  const std::string header =
      "NDims = 3\nBinaryData = True\nElementSpacing = 2 2 2\nDimSize = 4 4 3\nElementType = MET_UCHAR\n";
  const std::string end = "ElementDataFile = a.raw\n";
  put_bytes(folder / "a.raw", std::vector<char>(96, 1));
  const auto put = [&](const std::string& text) {
    put_bytes(folder / "a.mhd", {text.begin(), text.end()});
    return told(folder / "a.mhd");
  };
  EXPECT_NE(put(header + end).find("a.raw holds 48 bytes more"), std::string::npos);
  EXPECT_EQ(put(header + "HeaderSize = -1\n" + end), "");
  EXPECT_EQ(put(header + "HeaderSize = 48\n" + end), "");
}

}  // namespace
}  // namespace borelli::voxel_stream_test
