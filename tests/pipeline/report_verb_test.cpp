// `borelli report FOLDER` from the files that a run leaves.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "pipeline/export/glb.hpp"
#include "pipeline/export/trajectory_file.hpp"
#include "pipeline/files/digest.hpp"
#include "pipeline/files/whole_file.hpp"
#include "process/input_file.hpp"
#include "segmentation/files/landmarks_file.hpp"
#include "segmentation/files/write.hpp"
#include "tests/pipeline/capsule_body.hpp"
#include "tests/pipeline/program_run.hpp"

namespace borelli {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

struct ReportVerb : testing::Test {
  const TestFolder runs;
  const fs::path folder = runs / "Subject 7 & co";
  CapsuleScan scan = capsule_scan(capsule_grid(16));

  void SetUp() override {
    for (const char* name : {"segmentation", "inertia", "motion", "mesh"})
      fs::create_directories(folder / name);
  }

  void write_run() {
    ASSERT_TRUE(write_labels((folder / "segmentation/labels.nii.gz").string(), scan.labels));
    ASSERT_TRUE(write_landmarks((folder / "segmentation/landmarks.json").string(), capsule_joints()));
    ASSERT_TRUE(write_volume((runs / "scan.nii.gz").string(), scan.grey));
    const json account = {{"input", (runs / "scan.nii.gz").string()},
                          {"reading", "CT numbers (hu): as the user says"},
                          {"parts", {{"head", {{"confidence", 0.75}, {"note", "a capsule"}}}}},
                          {"warnings", {"made of capsules"}}};
    ASSERT_TRUE(write_whole(folder / "segmentation/segmentation.json", account.dump()));
    ASSERT_TRUE(write_whole(folder / "inertia/table.json", capsule_table().dump()));
    ASSERT_TRUE(write_trajectory(capsule_motion(), "", folder / "motion/trajectory.h5"));
    ASSERT_TRUE(
        write_whole(folder / "body.glb", *glb(capsule_meshes(), capsule_scan_poses(), capsule_motion())));
    ASSERT_TRUE(write_whole(folder / "mesh/head.stl", "solid"));
  }

  int exit_code = -1;
  std::string said;  // standard error
  json answer;
  void run(const std::string& options = "") {
    const ProgramRun run = run_program("report '" + folder.string() + "' --json " + options);
    exit_code = run.code;
    answer = json::parse(run.out, nullptr, false);
    said = run.err;
  }
  /// The packed block of the page with this name; empty: it has none.
  std::string page_block(const std::string& name) {
    const std::string page = read_input_file(folder / "report.html").value_or("");
    const auto tag = page.find("id=\"block-" + name + "\"");
    if (tag == std::string::npos) return {};
    const auto from = page.find('>', tag) + 1;
    return page.substr(from, page.find("</script>", from) - from);
  }
  json data() {
    const std::string page = read_input_file(folder / "report.html").value_or("");
    const auto from = page.find('>', page.find("id=\"report\"")) + 1;
    return json::parse(page.substr(from, page.find("</script>", from) - from), nullptr, false);
  }
};

TEST_F(ReportVerb, DrawsTheFolderOfARun) {
  write_run();
  run();
  ASSERT_EQ(exit_code, 0) << said;
  EXPECT_EQ(answer["report"], (folder / "report.html").string());
  EXPECT_EQ(answer["bytes"], fs::file_size(folder / "report.html"));
  EXPECT_TRUE(said.empty()) << said;
  const json page = data();
  EXPECT_EQ(page["subject"], "Subject 7 & co");
  EXPECT_EQ(page["source"]["quantity"], "hu");
  EXPECT_EQ(page["source"]["size"], json(scan.grey.grid.size));
  EXPECT_EQ(page["table"]["parts"].size(), 16u);
  EXPECT_EQ(page["joints"].size(), 15u);
  EXPECT_EQ(page["motion"]["times"].size(), capsule_motion().times.size());
  EXPECT_EQ(page["segmentation"]["warnings"][0], "made of capsules");
  std::vector<std::string> files;
  for (const auto& file : page["files"]) files.push_back(file["path"]);
  EXPECT_EQ(files, (std::vector<std::string>{"segmentation/labels.nii.gz", "segmentation/labels.tsv",
                                             "segmentation/landmarks.json", "inertia/table.json",
                                             "motion/trajectory.h5", "body.glb", "mesh/head.stl"}));
}

TEST_F(ReportVerb, WorksWithoutAMissingScan) {
  write_run();
  fs::remove(runs / "scan.nii.gz");
  run("--subject 'Another name'");
  ASSERT_EQ(exit_code, 0) << said;
  EXPECT_NE(said.find("scan.nii.gz), so the report shows the parts without it"), std::string::npos);
  EXPECT_EQ(data()["source"]["quantity"], "labels");
  EXPECT_EQ(data()["subject"], "Another name");
}

TEST_F(ReportVerb, RefusesAnotherScan) {
  write_run();
  const std::string digest = *digest_of(runs / "scan.nii.gz");
  const json account = {{"inputs", {{"volume", {{{"file", "scan.nii.gz"}, {"sha256", digest}}}}}}};
  ASSERT_TRUE(write_whole(folder / "run.json", account.dump()));
  run();
  ASSERT_EQ(exit_code, 0) << said;
  EXPECT_FALSE(page_block("grey").empty());
  ++scan.grey.voxels[0];
  ASSERT_TRUE(write_volume((runs / "other.nii.gz").string(), scan.grey));
  run("--volume " + (runs / "other.nii.gz").string());
  EXPECT_EQ(exit_code, 2);
  EXPECT_NE(said.find("other.nii.gz: differs from the scan that the run read"), std::string::npos) << said;
  fs::rename(runs / "scan.nii.gz", runs / "moved.nii.gz");
  fs::rename(runs / "other.nii.gz", runs / "scan.nii.gz");
  run();
  EXPECT_EQ(exit_code, 0);
  EXPECT_NE(answer["warnings"].dump().find("differs from the scan that the run read"), std::string::npos)
      << answer;
  EXPECT_TRUE(page_block("grey").empty());
  run("--volume " + (runs / "moved.nii.gz").string());
  EXPECT_EQ(exit_code, 0) << said;
  EXPECT_FALSE(page_block("grey").empty());
}

TEST_F(ReportVerb, RemovesTheFace) {
  write_run();
  run();
  ASSERT_EQ(exit_code, 0) << said;
  const json before = data();
  EXPECT_FALSE(before.contains("face"));
  const std::string whole = page_block("body"), labels = page_block("labels");
  run("--deface");
  ASSERT_EQ(exit_code, 0) << said;
  EXPECT_TRUE(said.empty()) << said;
  json after = data();
  EXPECT_EQ(after["face"], "taken");
  EXPECT_NE(page_block("body"), whole);
  EXPECT_NE(page_block("labels"), labels);
  for (const char* same : {"table", "histogram", "joints", "motion", "segmentation", "files", "volume"})
    EXPECT_EQ(after[same], before[same]) << same;

  fs::remove(folder / "segmentation/landmarks.json");  // without them nobody knows where solids were scanned
  run("--deface");
  ASSERT_EQ(exit_code, 0) << said;
  EXPECT_EQ(data()["face"], "taken");
  EXPECT_EQ(page_block("body"), "");
  EXPECT_NE(said.find("shows no moving body"), std::string::npos) << said;
}

TEST_F(ReportVerb, WarnsIfNoHeadIsFound) {
  for (auto& voxel : scan.labels.voxels)
    if (voxel == part_label("head")) voxel = 0;
  write_run();
  run("--deface");
  ASSERT_EQ(exit_code, 0) << said;
  EXPECT_EQ(data()["face"], "hidden");
  EXPECT_NE(said.find("found no head"), std::string::npos) << said;
}

TEST_F(ReportVerb, RefusesMissingAndDamagedFiles) {
  run();
  EXPECT_EQ(exit_code, 2);
  EXPECT_NE(said.find("contains no results of a run"), std::string::npos);
  write_run();
  run("--volume nowhere.nii.gz");
  EXPECT_EQ(exit_code, 2);
  EXPECT_NE(said.find("nowhere.nii.gz"), std::string::npos);
  const auto body = read_input_file(folder / "body.glb").value();
  for (const std::string& damaged : {body.substr(0, body.size() - 4), std::string(500, 'x'), std::string()}) {
    ASSERT_TRUE(write_whole(folder / "body.glb", damaged));
    run();
    EXPECT_EQ(exit_code, 1);
    EXPECT_NE(said.find("body.glb: is not a binary glTF file, or is damaged"), std::string::npos) << said;
  }
  ASSERT_TRUE(write_whole(folder / "body.glb", body));
  const auto whole = read_input_file(folder / "inertia/table.json").value();
  std::ofstream(folder / "inertia/table.json") << whole.substr(0, whole.size() / 2);
  run();
  EXPECT_EQ(exit_code, 1);
  EXPECT_NE(said.find("table.json:"), std::string::npos) << said;
  EXPECT_NE(said.find("is not JSON"), std::string::npos) << said;
  EXPECT_FALSE(fs::exists(folder / "report.html"));
  fs::remove_all(folder);
  run();
  EXPECT_EQ(exit_code, 2);
}

}  // namespace
}  // namespace borelli
