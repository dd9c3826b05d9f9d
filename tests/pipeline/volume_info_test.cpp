// `borelli info` on volumes with known contents.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "segmentation/files/write.hpp"
#include "segmentation/vocabulary/parts.hpp"
#include "tests/pipeline/program_run.hpp"

namespace borelli {
namespace {

class VolumeInfo : public ::testing::Test {
 protected:
  std::string file(const std::string& name) const { return (folder_ / name).string(); }

  const TestFolder folder_;
};

TEST_F(VolumeInfo, DescribesGridAndLabels) {
  LabelMap map;
  map.grid.size = {4, 3, 2};
  map.grid.axes = Eigen::Vector3d(-2, 2, 5).asDiagonal();  // i runs to the Right
  map.voxels.assign(24, 0);
  map.voxels[5] = map.voxels[6] = static_cast<std::uint8_t>(part_label("head"));
  for (const Part& part : parts) map.names.emplace_back(part.name);
  ASSERT_TRUE(write_labels(file("labels.nii.gz"), map));
  const ProgramRun answer = run_program("info --json " + file("labels.nii.gz"));
  ASSERT_EQ(answer.code, 0) << answer.err;
  const auto info = nlohmann::json::parse(answer.out);
  EXPECT_EQ(info["voxels"], (std::array{4, 3, 2}));
  EXPECT_EQ(info["spacing_mm"], (std::array{2.0, 2.0, 5.0}));
  EXPECT_EQ(info["axes_run_to"], (std::array<std::string, 3>{"Right", "Posterior", "Superior"}));
  EXPECT_EQ(info["quantity"], "labels");
  ASSERT_EQ(info["labels"].size(), 1u);
  EXPECT_EQ(info["labels"][0]["name"], "head");
  EXPECT_EQ(info["labels"][0]["voxels"], 2);
  EXPECT_DOUBLE_EQ(info["labels"][0]["volume_ml"], 2 * 20 * 1e-3);  // two voxels of 20 mm^3
  const ProgramRun text = run_program("info " + file("labels.nii.gz"));
  EXPECT_NE(text.out.find("i runs to Right"), std::string::npos) << text.out;
}

// the grid is described even if the quantity is unknown
TEST_F(VolumeInfo, DescribesTheGridWithoutAQuantity) {
  GreyVolume volume;
  volume.grid.size = {4, 4, 4};
  volume.voxels.assign(64, 1050);
  volume.quantity = Quantity::mr;
  ASSERT_TRUE(write_volume(file("a.mha"), volume));
  // erases our writer's fields, as in a file of another program
  std::FILE* f = std::fopen(file("a.mha").c_str(), "r+b");
  std::string start(200, ' ');
  ASSERT_EQ(std::fread(start.data(), 1, start.size(), f), start.size());
  std::fseek(f, static_cast<long>(start.find("borelli mr")), SEEK_SET);
  std::fwrite("anybody's.", 1, 10, f);
  std::fclose(f);
  const ProgramRun answer = run_program("info --json " + file("a.mha"));
  ASSERT_EQ(answer.code, 0) << answer.err;
  const auto info = nlohmann::json::parse(answer.out);
  EXPECT_TRUE(info["holds"].is_null());
  EXPECT_EQ(info["voxels"], (std::array{4, 4, 4}));
  EXPECT_EQ(run_program("info --json --quantity mr " + file("a.mha")).code, 0);
}

TEST_F(VolumeInfo, BadUseGivesTwoAndDamageOne) {
  EXPECT_EQ(run_program("info " + file("absent.nii")).code, 2);
  EXPECT_EQ(run_program("info --quantity weight " + file(".")).code, 2);
  std::FILE* f = std::fopen(file("damaged.nii").c_str(), "wb");
  std::fwrite("damaged", 1, 7, f);
  std::fclose(f);
  const ProgramRun damaged = run_program("info " + file("damaged.nii"));
  EXPECT_EQ(damaged.code, 1);
  EXPECT_NE(damaged.err.find("damaged.nii: is not a NIfTI file"), std::string::npos) << damaged.err;
}

}  // namespace
}  // namespace borelli
