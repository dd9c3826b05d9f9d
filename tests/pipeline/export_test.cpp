// `borelli export` on a small label map: the files it leaves, and what it says of them.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "segmentation/files/read.hpp"
#include "segmentation/files/write.hpp"
#include "segmentation/vocabulary/parts.hpp"
#include "tests/pipeline/program_run.hpp"

namespace borelli {
namespace {

namespace fs = std::filesystem;

class Export : public ::testing::Test {
 protected:
  void SetUp() override {
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

  ProgramRun run(const std::string& arguments) const {
    return run_program("export " + (folder_ / "labels.nii.gz").string() + " -o " +
                       (folder_ / "out").string() + " " + arguments);
  }

  const TestFolder folder_;
};

TEST_F(Export, WritesAMeshPerPartInBothFormats) {
  const ProgramRun answer = run("--json");
  ASSERT_EQ(answer.code, 0) << answer.err;
  const auto said = nlohmann::json::parse(answer.out);
  ASSERT_EQ(said["parts"].size(), 2u);
  for (const auto& part : said["parts"]) {
    EXPECT_TRUE(part["closed"]);
    EXPECT_NEAR(part["volume_m3"].get<double>() / (216 * 8e-9), 1, 0.005);  // the voxels'
  }
  for (const char* file : {"head.stl", "head.vtp", "upper_trunk.stl", "upper_trunk.vtp"})
    EXPECT_TRUE(fs::exists(folder_ / "out" / file)) << file;
  EXPECT_EQ(said["files"].size(), 4u);
}

TEST_F(Export, WritesLabelsAsDicom) {
  const ProgramRun answer = run("--dicom --json");
  ASSERT_EQ(answer.code, 0) << answer.err;
  const auto said = nlohmann::json::parse(answer.out);
  EXPECT_EQ(said["files"], nlohmann::json::array({(folder_ / "out/labels.dcm").string()}));
  const auto labels = read_labels((folder_ / "labels.nii.gz").string());
  ASSERT_TRUE(labels) << labels.error().message();
  const auto back = read_labels((folder_ / "out/labels.dcm").string(), "", {}, &labels->grid);
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(back->voxels, labels->voxels);
  EXPECT_FALSE(fs::exists(folder_ / "out/head.stl"));
  EXPECT_EQ(run("--dicom --stl").code, 0);
  EXPECT_TRUE(fs::exists(folder_ / "out/head.stl"));
}

TEST_F(Export, SaysWhyLabelsDoNotBecomeDicom) {
  const auto refused = [&](const std::string& arguments, int code, const std::string& why) {
    const ProgramRun answer = run(arguments);
    EXPECT_EQ(answer.code, code) << arguments;
    EXPECT_NE(answer.err.find(why), std::string::npos) << answer.err;
    EXPECT_FALSE(fs::exists(folder_ / "out/labels.dcm")) << arguments;
  };
  refused("--dicom --volume " + (folder_ / "labels.nii.gz").string(), 2, "is not a DICOM scan");
  refused("--dicom --volume " + (folder_ / "none").string(), 2, "no such file");
  refused("--volume " + folder_.path().string(), 2, "--dicom");
  refused("--dicom --patient", 2, "--volume");
  fs::create_directories(folder_ / "out/labels.dcm/inner");
  const ProgramRun answer = run("--dicom");
  EXPECT_EQ(answer.code, 2);
  EXPECT_NE(answer.err.find("labels.dcm"), std::string::npos) << answer.err;
}

TEST_F(Export, WritesOnlyRequestedFormats) {
  const ProgramRun meshes = run("--stl");
  ASSERT_EQ(meshes.code, 0) << meshes.err;
  EXPECT_NE(meshes.out.find("upper_trunk"), std::string::npos);
  EXPECT_FALSE(fs::exists(folder_ / "out/head.vtp"));
  const ProgramRun picture = run("--picture");
  ASSERT_EQ(picture.code, 0) << picture.err;
  EXPECT_GT(fs::file_size(folder_ / "out/body.png"), 1000u);
  EXPECT_FALSE(fs::exists(folder_ / "out/head.vtp"));
}

}  // namespace
}  // namespace borelli
