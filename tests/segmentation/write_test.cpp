// Errors name files that cannot be read or written, in one sentence.
#include <fmt/core.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <fstream>

#include "grids.hpp"
#include "scratch_folder.hpp"
#include "segmentation/files/read.hpp"
#include "segmentation/files/volume_formats.hpp"
#include "segmentation/files/write.hpp"

namespace borelli {
namespace {

TEST(Write, NamesAnObstacle) {
  ScratchFolder folder;
  const GreyVolume volume = noise_volume(oblique_grid(false, 0), Quantity::hu);
  const auto refusal = [&](const std::string& path) {
    const auto written = write_volume(path, volume);
    return written ? std::string("was written") : written.error().message();
  };
  EXPECT_NE(refusal(folder / "no/such/folder/a.nii.gz").find("No such file or directory"), std::string::npos);
  EXPECT_NE(refusal(folder / "a.jpg").find(".nii.gz, .nii, .nrrd or .mha"), std::string::npos);
  EXPECT_NE(refusal(folder / "a").find(".nii.gz"), std::string::npos);
  auto short_of = volume;
  short_of.voxels.pop_back();
  const auto refused = write_volume(folder / "a.nii", short_of);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().what.find("140 voxels, and the volume has 139"), std::string::npos)
      << refused.error().what;
}

TEST(Write, EveryEndingIsReadBackInCapitalsToo) {
  ScratchFolder folder;
  const GreyVolume volume = noise_volume(oblique_grid(false, 0), Quantity::hu);
  int written = 0;
  for (const VolumeFormat& format : volume_formats())
    for (const std::string_view ending : format.written)
      for (const bool capitals : {false, true}) {
        std::string name = fmt::format("a{}", ending);
        if (capitals) std::transform(name.begin(), name.end(), name.begin(), ::toupper);
        const auto done = write_volume(folder / name, volume);
        ASSERT_TRUE(done) << done.error().message();
        const auto read = read_volume(folder / name);
        ASSERT_TRUE(read) << name << ": " << read.error().message();
        EXPECT_EQ(read->volume.voxels, volume.voxels) << name;
        EXPECT_EQ(std::ifstream(folder / name).peek() == 0x1f, ending.ends_with(".gz")) << name;
        ++written;
      }
  EXPECT_EQ(written, 8);
}

// writes to /dev/full fail as on a full disk
TEST(Write, NamesAFullDisk) {
  ScratchFolder folder;
  for (const std::string name : {"a.nii", "a.nii.gz", "a.nrrd", "a.mha"}) {
    std::filesystem::create_symlink("/dev/full", folder / name);
    const auto written = write_volume(folder / name, noise_volume(oblique_grid(false, 0), Quantity::hu));
    ASSERT_FALSE(written) << name;
    EXPECT_NE(written.error().message().find("No space left on device"), std::string::npos)
        << written.error().message();
  }
}

TEST(Read, NamesMissingAndWrongFiles) {
  ScratchFolder folder;
  put_bytes(folder / "a.jpg", {'x'});
  put_bytes(folder / "secret.nii", {'x'});
  const auto refusal = [&](const std::string& name) {
    const auto read = read_volume(folder / name);
    return read ? std::string("was read") : read.error().message();
  };
  EXPECT_NE(refusal("absent.nii").find("no such file"), std::string::npos);
  EXPECT_NE(refusal("a.jpg").find("is not a supported volume"), std::string::npos);
  std::filesystem::permissions(folder / "secret.nii", std::filesystem::perms::none);
  if (geteuid() != 0) {  // root may read everything
    EXPECT_NE(refusal("secret.nii").find("Permission denied"), std::string::npos);
  }
  std::filesystem::create_symlink("/dev/zero", folder / "endless.nii");
  EXPECT_NE(refusal("endless.nii").find("not a regular file"), std::string::npos) << refusal("endless.nii");
}

}  // namespace
}  // namespace borelli
