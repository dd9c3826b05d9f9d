// A folder's files: links, placeholder files without images, and headers that other programs misread too.
#include "segmentation/files/dicom_files.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "segmentation/files/read.hpp"
#include "tests/segmentation/dicom_series.hpp"
#include "tests/segmentation/scratch_folder.hpp"
#include "tests/segmentation/test_data_set.hpp"

namespace borelli {
namespace dicom_files_test {
namespace {

namespace fs = std::filesystem;

void write_slices(const std::string& folder, int first, int last) {
  for (int k = first; k < last; ++k) {
    TestSlice slice;
    slice.columns = 3, slice.rows = 2;
    slice.position.z() = 2 * k;
    slice.instance = "1.2.3.1." + std::to_string(k + 1);
    slice.pixels.assign(6, static_cast<std::uint16_t>(1000 + k));
    slice.pixels[0] = 24;  // air
    write_slice(folder + "/" + std::to_string(k) + ".dcm", slice);
  }
}

void put_text(const std::string& path, const std::string& text) {
  put_bytes(path, {text.begin(), text.end()});
}

std::string preamble() { return std::string(128, '\0') + "DICM"; }

// One placeholder file of each kind.
void put_placeholders(const ScratchFolder& folder) {
  put_text(folder / "._0.dcm", std::string("\0\5\26\7", 4) + std::string(200, 'x'));
  put_text(folder / "stub.dcm", preamble());
  put_text(folder / "lfs.dcm", "version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 525382\n");
  put_text(folder / "annex.dcm", "/annex/objects/MD5E-s525382--0123456789abcdef.dcm\n");
  fs::create_symlink("../.git/annex/objects/xx/yy/MD5E-s525382--00.dcm", folder / "datalad.dcm");
}

TEST(DicomFiles, IgnoresPlaceholderFilesWithANote) {
  const ScratchFolder folder;
  write_slices(folder.path(), 0, 5);
  put_placeholders(folder);
  const auto read = read_volume(folder.path());
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->volume.grid.size[2], 5);
  ASSERT_EQ(read->warnings.size(), 3U);
  EXPECT_NE(read->warnings[0].find(
                "3 files (the first is datalad.dcm) point to content that has not been downloaded"),
            std::string::npos)
      << read->warnings[0];
  EXPECT_EQ(read->warnings[1], "stub.dcm holds only the start of a DICOM file; ignored");
  EXPECT_EQ(read->warnings[2], "._0.dcm holds macOS metadata (._*) and no image; ignored");
}

TEST(DicomFiles, FolderOfPlaceholdersNamesThem) {
  const ScratchFolder folder;
  put_placeholders(folder);
  for (const auto& refusal : {read_volume(folder.path()).error(), read_labels(folder.path()).error()}) {
    EXPECT_EQ(refusal.kind, Error::Kind::use);
    for (const char* part :
         {"git annex get", "git lfs pull", "stub.dcm holds only", "._0.dcm holds macOS metadata"})
      EXPECT_NE(refusal.message().find(part), std::string::npos) << refusal.message();
  }
}

// SOP classes of PS3.4, B.5, without pixels; a dose may have them.
TEST(DicomFiles, NamesObjectsThatAreNoSeriesOfImages) {
  const auto put = [](const std::string& path, const std::string& sop_class, const std::string& modality,
                      bool pixels) {
    DataSet object;
    object.add(0x00080016, "UI", sop_class).add(0x00080018, "UI", "1.2.3.5").add(0x00080060, "CS", modality);
    if (pixels) {
      object.number(0x00280002, 1).add(0x00280004, "CS", "MONOCHROME2").add(0x00280008, "IS", "2");
      object.number(0x00280010, 2).number(0x00280011, 2).number(0x00280100, 16).number(0x00280101, 16);
      object.number(0x00280102, 15).number(0x00280103, 0).add(0x7fe00010, "OW", std::string(16, '\0'));
    }
    object.write(path, sop_class);
  };
  struct Case {
    std::string sop_class, modality, kind;
    bool pixels = false;
  };
  for (const Case& c : {Case{"1.2.840.10008.5.1.4.1.1.481.2", "RTDOSE", "an RT dose"},
                        {"1.2.840.10008.5.1.4.1.1.481.2", "RTDOSE", "an RT dose", true},
                        {"1.2.840.10008.5.1.4.1.1.481.3", "RTSTRUCT", "an RT structure set"},
                        {"1.2.840.10008.5.1.4.1.1.88.22", "SR", "a structured report"},
                        {"1.2.3", "XX", "a DICOM file without an image (modality XX)"}}) {
    const ScratchFolder folder;
    put(folder / "a.dcm", c.sop_class, c.modality, c.pixels);
    const auto file = read_volume(folder / "a.dcm"), whole = read_volume(folder.path());
    ASSERT_FALSE(file);
    EXPECT_NE(file.error().message().find("is " + c.kind + ", no series of images"), std::string::npos)
        << file.error().message();
    ASSERT_FALSE(whole);
    EXPECT_NE(whole.error().message().find("contains no series of images, but " + c.kind + ";"),
              std::string::npos)
        << whole.error().message();
  }
}

TEST(DicomFiles, FollowsLinkedFoldersOnce) {
  const ScratchFolder folder, elsewhere;
  write_slices(elsewhere.path(), 0, 6);
  fs::create_directory(folder / "a");
  fs::create_directory_symlink(elsewhere.path(), folder / "a/slices");
  fs::create_directory_symlink(elsewhere.path(), folder / "a/again");
  fs::create_directory_symlink("..", folder / "a/up");                      // a cycle
  fs::create_directory_symlink(folder.path(), elsewhere / "back");          // another
  fs::create_directory_symlink(fs::temp_directory_path(), folder / "all");  // contains this folder and others
  const auto below = files_below(folder.path());
  ASSERT_TRUE(below) << below.error().message();
  EXPECT_EQ(below->files.size(), 6U);
  const auto read = read_volume(folder.path());
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->volume.grid.size[2], 6);
  EXPECT_TRUE(read->warnings.empty()) << read->warnings.front();
}

TEST(DicomFiles, NamesDecimalCommas) {
  const auto refusal = [](const std::function<void(TestSlice&)>& change) {
    const ScratchFolder folder;
    for (int k = 0; k < 3; ++k) {
      TestSlice slice;
      slice.columns = 3, slice.rows = 2;
      slice.position.z() = 2 * k;
      slice.instance = "1.2.3.1." + std::to_string(k + 1);
      slice.pixels.assign(6, 1000);
      change(slice);
      write_slice(folder / std::to_string(k), slice);
    }
    const auto read = read_volume(folder.path());
    return read ? "read" : read.error().message();
  };
  EXPECT_NE(refusal([](TestSlice& s) {
              s.pixel_spacing_text = "0,75\\0,75";
            }).find("contains numbers with decimal commas (PixelSpacing '0,75\\0,75')"),
            std::string::npos);
  EXPECT_NE(refusal([](TestSlice& s) {
              s.position_text = fmt::format("-10,5\\-20,5\\{},0", 2 * s.position.z());
            }).find("contains numbers with decimal commas (ImagePositionPatient '-10,5\\-20,5\\0,0')"),
            std::string::npos);
  EXPECT_NE(refusal([](TestSlice& s) { s.intercept_text = "-1024,0"; }).find("RescaleIntercept '-1024,0'"),
            std::string::npos);
  EXPECT_NE(refusal([](TestSlice& s) { s.thickness = "1,25"; }).find("SliceThickness '1,25'"),
            std::string::npos);
}

}  // namespace
}  // namespace dicom_files_test
}  // namespace borelli
