// `borelli export` on a small label map: the files it leaves, and what it says of them.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "pipeline/display.hpp"
#include "segmentation/parts.hpp"
#include "segmentation/write.hpp"

namespace borelli {
namespace {

namespace fs = std::filesystem;

class Export : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "borelli-export-XXXXXX").string();
    ASSERT_TRUE(mkdtemp(name.data()));
    folder_ = name;
    LabelMap map;  // two blocks of 6 x 6 x 6 voxels of 2 mm, one above the other
    map.grid.size = {8, 8, 14};
    map.grid.axes = Eigen::Vector3d(2, 2, 2).asDiagonal();
    map.voxels.assign(map.grid.count(), 0);
    for (int k = 1; k < 13; ++k)
      for (int j = 1; j < 7; ++j)
        for (int i = 1; i < 7; ++i)
          map.at(i, j, k) = static_cast<std::uint8_t>(part_label(k < 7 ? "upper_trunk" : "head"));
    for (const Part& part : parts) map.names.emplace_back(part.name);
    ASSERT_TRUE(write_labels((folder_ / "labels.nii.gz").string(), map));
  }
  void TearDown() override { fs::remove_all(folder_); }

  int run(const std::string& arguments) {
    const std::string command = BORELLI_PROGRAM " export " + (folder_ / "labels.nii.gz").string() + " -o " +
                                (folder_ / "out").string() + " " + arguments;
    std::FILE* pipe = popen((command + " 2>&1").c_str(), "r");
    std::array<char, 4096> block;
    answer_.clear();
    while (const std::size_t got = std::fread(block.data(), 1, block.size(), pipe))
      answer_.append(block.data(), got);
    return WEXITSTATUS(pclose(pipe));
  }

  fs::path folder_;
  std::string answer_;
};

TEST_F(Export, WritesAMeshPerPartInBothFormats) {
  ASSERT_EQ(run("--json"), 0) << answer_;
  const auto said = nlohmann::json::parse(answer_);
  ASSERT_EQ(said["parts"].size(), 2u);
  for (const auto& part : said["parts"]) {
    EXPECT_TRUE(part["closed"]);
    EXPECT_NEAR(part["volume_m3"].get<double>() / (216 * 8e-9), 1, 0.005);  // the voxels'
  }
  for (const char* file : {"head.stl", "head.vtp", "upper_trunk.stl", "upper_trunk.vtp"})
    EXPECT_TRUE(fs::exists(folder_ / "out" / file)) << file;
  EXPECT_EQ(said["files"].size(), 4u);
}

TEST_F(Export, WritesOnlyWhatIsNamed) {
  ASSERT_EQ(run("--stl"), 0) << answer_;
  EXPECT_NE(answer_.find("upper_trunk"), std::string::npos);
  EXPECT_FALSE(fs::exists(folder_ / "out/head.vtp"));
  if (!display_answers()) {
    EXPECT_EQ(run("--picture"), 2);
    EXPECT_NE(answer_.find("xvfb-run -a"), std::string::npos) << answer_;
    GTEST_SKIP() << "no X display answers; run the tests under xvfb-run -a";
  }
  ASSERT_EQ(run("--picture"), 0) << answer_;
  EXPECT_GT(fs::file_size(folder_ / "out/body.png"), 1000u);
  EXPECT_FALSE(fs::exists(folder_ / "out/head.vtp"));
}

}  // namespace
}  // namespace borelli
