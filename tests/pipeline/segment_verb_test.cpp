// borelli segment from the command line: its files, its refusals.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "pipeline/segmentation_files.hpp"
#include "samples/phantom_voxels.hpp"
#include "segmentation/landmarks_file.hpp"
#include "segmentation/read.hpp"
#include "segmentation/write.hpp"
#include "tests/pipeline/program_run.hpp"

namespace borelli {
namespace {

namespace fs = std::filesystem;

TEST(SegmentVerb, LeavesLabelsLandmarksAndAccount) {
  const TestFolder folder;
  const auto body = build_phantom({});
  ASSERT_TRUE(body) << body.error().message();
  GridOptions coarse;
  coarse.spacing = Eigen::Vector3d::Constant(4);
  const Grid grid = phantom_grid(*body, coarse);
  ASSERT_TRUE(write_volume(folder / "scan.nii.gz", voxelise(*body, grid).grey));

  const auto run = run_program("segment " + (folder / "scan.nii.gz").string() + " --step 4 --json -o " +
                               (folder / "out").string());
  ASSERT_EQ(run.code, 0) << run.err;
  const auto answer = nlohmann::json::parse(run.out);
  EXPECT_EQ(answer.at("parts").at("thigh_left").at("coverage"), "whole");

  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator(folder / "out")) files.push_back(entry.path().filename());
  std::sort(files.begin(), files.end());
  EXPECT_EQ(files,
            (std::vector<std::string>{"labels.nii.gz", "labels.tsv", "landmarks.json", "segmentation.json"}));

  const auto labels = read_labels((folder / "out/labels.nii.gz").string());
  ASSERT_TRUE(labels) << labels.error().message();
  std::array<std::int64_t, 256> count{};
  for (const auto v : labels->voxels) ++count[v];
  const auto findings = read_findings(folder / "out/segmentation.json");
  ASSERT_TRUE(findings) << findings.error().message();
  for (std::size_t n = 1; n < parts.size(); ++n) {
    EXPECT_EQ((*findings)[n].coverage, Coverage::whole) << parts[n].name;
    // the account's volume is that of the labels in the file, to float32's rounding of the grid
    EXPECT_NEAR((*findings)[n].volume, static_cast<double>(count[n]) * 64, 1e-5 * (*findings)[n].volume);
  }
  const auto landmarks = read_landmarks((folder / "out/landmarks.json").string());
  ASSERT_TRUE(landmarks) << landmarks.error().message();
  EXPECT_LT((landmarks->at("shoulder_left").point - body->landmarks.at("shoulder_left").point).norm(), 4);
}

TEST(RunOptions, WithoutEffectAreRefused) {
  const TestFolder folder;
  const std::string run = "run " + (folder / "scan.nii.gz").string() + " -o " + (folder / "out").string();
  for (const char* options : {" --label-names names.tsv", " --labels map.nii.gz --work-grid 4"}) {
    const auto refused = run_program(run + options);
    EXPECT_EQ(refused.code, 2) << options;
    EXPECT_NE(refused.err.find("--labels"), std::string::npos) << refused.err;
  }
  EXPECT_EQ(folder.count(), 0);
}

TEST(SegmentVerb, GridTooCoarseForAnklesIsRefusedAndRunRefusesItToo) {
  const TestFolder folder;
  const std::string output = " -o " + (folder / "out").string();
  for (const char* asked : {"segment x.nii --step 10", "run x.nii --work-grid 10"}) {
    const auto refused = run_program(asked + output);
    EXPECT_EQ(refused.code, 2) << asked;
    EXPECT_NE(refused.err.find("is 10, expected a number from 1 to 8"), std::string::npos) << refused.err;
  }
}

TEST(SegmentVerb, BadUseAndFailureAreTold) {
  const TestFolder folder;
  const auto missing =
      run_program("segment " + (folder / "none.nii.gz").string() + " -o " + (folder / "out").string());
  EXPECT_EQ(missing.code, 2);
  EXPECT_NE(missing.err.find("none.nii.gz"), std::string::npos);
  const auto unknown = run_program("segment x.nii --quantity colour -o " + (folder / "out").string());
  EXPECT_EQ(unknown.code, 2);
  EXPECT_FALSE(fs::exists(folder / "out"));
}

TEST(SegmentationFiles, DamagedAccountsAreRefused) {
  const TestFolder folder;
  const std::string path = (folder / "segmentation.json").string();
  for (const auto& [text, expected] : {std::pair{"{", "account"},
                                       {"{}", "account"},
                                       {R"({"parts": {"tail": {}}})", "tail"},
                                       {R"({"parts": {"head": {"coverage": "half"}}})", "half"}}) {
    std::ofstream(path) << text;
    const auto read = read_findings(path);
    ASSERT_FALSE(read) << text;
    EXPECT_NE(read.error().message().find(expected), std::string::npos) << read.error().message();
  }
}

}  // namespace
}  // namespace borelli
