// `borelli phantom` as a user runs it: the five files and what they hold, exit codes and sentences.
#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "inertia/table_file.hpp"
#include "samples/phantom_voxels.hpp"
#include "segmentation/files/landmarks_file.hpp"
#include "segmentation/files/read.hpp"
#include "tests/pipeline/program_run.hpp"

namespace borelli {
namespace {

namespace fs = std::filesystem;

ProgramRun run(const std::string& arguments) { return run_program("phantom " + arguments); }

std::string bytes_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

class PhantomVerb : public testing::Test {
 protected:
  std::string file(const char* name) const { return (folder / name).string(); }

  const TestFolder folder;
};

TEST_F(PhantomVerb, WritesScanLabelsTableAndLandmarks) {
  const ProgramRun answer =
      run("--spacing 6 7 8 --rotation-deg 3 4 5 --sex female --mass 60 --angle knee_left_flexion=20 "
          "--json -o " +
          file("deep/body.nrrd"));
  ASSERT_EQ(answer.code, 0) << answer.err;
  const auto said = nlohmann::json::parse(answer.out);
  PhantomOptions options{.sex = Sex::female, .mass_kg = 60, .pose_deg = {{"knee_left_flexion", 20}}};
  const Phantom phantom = build_phantom(options).value();
  GridOptions grid;
  grid.spacing = {6, 7, 8};
  grid.rotation_deg = {3, 4, 5};
  const Scan expected = voxelise(phantom, phantom_grid(phantom, grid));

  const auto scan = read_volume(file("deep/body.nrrd"));
  ASSERT_TRUE(scan) << scan.error().message();
  EXPECT_EQ(scan->volume.quantity, Quantity::hu);  // no need to say what the voxels are
  EXPECT_EQ(scan->volume.voxels, expected.grey.voxels);
  // the file keeps decimals: agreement to a billionth of a voxel over the volume
  EXPECT_LT((scan->volume.grid.axes - expected.grey.grid.axes).norm(), 1e-9);
  EXPECT_LT((scan->volume.grid.origin - expected.grey.grid.origin).norm(), 1e-9);
  const auto labels = read_labels(file("deep/body_labels.nrrd"));
  ASSERT_TRUE(labels) << labels.error().message();
  EXPECT_EQ(labels->voxels, expected.labels.voxels);
  EXPECT_EQ(labels->names, expected.labels.names);

  const auto table = read_table(file("deep/body_table.json"));
  ASSERT_TRUE(table) << table.error().message();
  ASSERT_EQ(table->rows.size(), parts.size() - 1);
  for (std::size_t label = 1; label < parts.size(); ++label) {
    const InertiaRow& row = table->rows[label - 1];
    EXPECT_EQ(row.part, parts[label].name);
    EXPECT_EQ(row.inertial.mass, phantom.exact[label].mass);  // JSON keeps doubles
    EXPECT_EQ(row.inertial.tensor, phantom.exact[label].tensor);
    EXPECT_GT(row.frame.value().length(), 0.07) << row.part;  // the hand's to the third knuckle
  }
  EXPECT_EQ(said.at("mass_kg").get<double>(), phantom.whole.mass);
  EXPECT_TRUE(fs::exists(file("deep/body_table.csv")));
  const auto landmarks = read_landmarks(file("deep/body_landmarks.json"));
  ASSERT_TRUE(landmarks) << landmarks.error().message();
  EXPECT_EQ(landmarks->size(), phantom.landmarks.size());
  for (const auto& [name, landmark] : phantom.landmarks)
    EXPECT_LT((landmarks->at(name).point - landmark.point).norm(), 1e-6) << name;
  // nothing else is left
  std::size_t files = 0;
  for ([[maybe_unused]] const auto& entry : fs::directory_iterator(folder / "deep")) ++files;
  EXPECT_EQ(files, 7u);  // with the labels' names and colours
}

TEST_F(PhantomVerb, SameSeedGivesTheSameFiles) {
  const auto made = [&](const std::string& words) {
    EXPECT_EQ(run("--spacing 10 --noise 30 --couch " + words + " -o " + file("body.nii.gz")).code, 0);
    return bytes_of(file("body.nii.gz")) + bytes_of(file("body_labels.nii.gz"));
  };
  const std::string one = made("--seed 4 --threads 1");
  EXPECT_GT(one.size(), 10000u);
  EXPECT_EQ(one, made("--seed 4 --threads 3"));
  EXPECT_NE(one, made("--seed 5"));
}

TEST_F(PhantomVerb, RefusesInvalidRequestsAndLeavesNothing) {
  const std::vector<std::array<std::string, 2>> asked{
      {{"--mass 200 -o body.nii.gz", "can weigh"},
       {"--angle knee=3 -o body.nii.gz", "knee_left_flexion"},
       {"--angle knee_left_flexion -o body.nii.gz", "is not a joint angle"},
       {"--angle knee_left_flexion=20 --angle knee_left_flexion=30 "
        "-o body.nii.gz",
        "twice"},
       {"--spacing 3 4 -o body.nii.gz", "--spacing"},
       {"--density-curve mine -o body.nii.gz", "schneider2000"},
       {"--offset nan 0 0 -o body.nii.gz", "offset"},
       {"--rotation-deg 0 nan 0 -o body.nii.gz", "rotation"},
       {"--spacing nan -o body.nii.gz", "spacing"},
       {"--spacing inf -o body.nii.gz", "spacing"},
       {"--tilt-deg nan -o body.nii.gz", "tilt"},
       {"--margin nan -o body.nii.gz", "margin"},
       {"--noise nan -o body.nii.gz", "noise"},
       {"--blur nan -o body.nii.gz", "blur"},
       {"--stature 0 -o body.nii.gz", "stature"},
       {"--stature nan -o body.nii.gz", "stature"},
       {"--mass 0 -o body.nii.gz", "mass"},
       {"--mass nan -o body.nii.gz", "mass"},
       {"--mass inf -o body.nii.gz", "mass"},
       {"--angle knee_left_flexion=nan -o body.nii.gz", "knee_left_flexion"},
       {"--seed 3 -o body.nii.gz", "add --noise"},
       {"--seed -3 -o body.nii.gz", "seed"},
       {"-o body.dcm", ".nii.gz"}}};
  for (const auto& [words, sentence] : asked) {
    const ProgramRun answer =
        run(std::string(words).replace(words.find("body."), 0, folder.path().string() + "/"));
    EXPECT_EQ(answer.code, 2) << words;
    EXPECT_NE(answer.err.find(sentence), std::string::npos) << answer.err;
  }
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

}  // namespace
}  // namespace borelli
