// `--segments` of run, segment and inertia as a user gives it: files with those segments alone.
#include <fmt/core.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "dynamics/formats/scene_file.hpp"
#include "inertia/table_file.hpp"
#include "pipeline/files/whole_file.hpp"
#include "process/input_file.hpp"
#include "samples/phantom.hpp"
#include "samples/phantom_voxels.hpp"
#include "segmentation/files/landmarks_file.hpp"
#include "segmentation/files/read.hpp"
#include "segmentation/files/write.hpp"
#include "tests/pipeline/program_run.hpp"

namespace borelli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class SegmentsVerbs : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder = new TestFolder;
    const Phantom body = build_phantom({}).value();
    GridOptions grid;
    grid.spacing.setConstant(6);
    ScanOptions options;
    options.partial_volume = true;
    const Scan scan = voxelise(body, phantom_grid(body, grid), options);
    ASSERT_TRUE(write_volume(path("scan.nii.gz"), scan.grey));
    ASSERT_TRUE(write_labels(path("labels.nii.gz"), scan.labels));
    ASSERT_TRUE(write_landmarks(path("joints.json"), body.landmarks));
  }
  static void TearDownTestSuite() { delete folder; }
  static std::string path(const std::string& name) { return (*folder / name).string(); }
  static ProgramRun run(const std::string& subject, const std::string& segments) {
    return run_program("run " + path("scan.nii.gz") + " --quantity hu --labels " + path("labels.nii.gz") +
                       " --landmarks " + path("joints.json") +
                       " --sex male --flight-time 0.1 --mesh-tolerance-mm 3 --subject " + subject +
                       (segments.empty() ? "" : " --segments " + segments) + " -o " + path("out"));
  }
  static std::set<std::string> names_in(const LabelMap& labels) {
    std::set<std::string> names;
    for (const auto label : labels.voxels)
      if (label) names.insert(labels.names[label]);
    return names;
  }
  static void expect_refused(const ProgramRun& done, const std::string& said) {
    EXPECT_EQ(done.code, 2) << done.err;
    EXPECT_NE(done.err.find(said), std::string::npos) << done.err;
    EXPECT_EQ(std::count(done.err.begin(), done.err.end(), '\n'), 1) << done.err;
  }

  static inline TestFolder* folder = nullptr;
};

TEST_F(SegmentsVerbs, RunOfSomeSegmentsKeepsTheNumbersOfTheWholeRun) {
  ASSERT_EQ(run("all", "").code, 0);
  const ProgramRun done = run("some", "trunk,thigh_left,hand_right");
  ASSERT_EQ(done.code, 0) << done.err;
  const fs::path some = fs::path(path("out")) / "some", all = fs::path(path("out")) / "all";
  const std::set<std::string> asked{"trunk", "thigh_left", "hand_right"};

  EXPECT_EQ(names_in(read_labels((some / "segmentation/labels.nii.gz").string()).value()), asked);
  EXPECT_EQ(names_in(read_labels((some / "segmentation/parts.nii.gz").string()).value()).size(), 16u);
  const auto table = read_table(some / "inertia/table.json").value();
  const auto whole = read_table(all / "inertia/table.json").value();
  ASSERT_EQ(table.rows.size(), 3u);
  for (const InertiaRow& row : table.rows) {
    if (row.part == "trunk") continue;
    const auto& known = *std::ranges::find(whole.rows, row.part, &InertiaRow::part);
    EXPECT_EQ(row.inertial.mass, known.inertial.mass) << row.part;
    EXPECT_EQ(row.inertial.centre, known.inertial.centre) << row.part;
    EXPECT_EQ(row.inertial.tensor, known.inertial.tensor) << row.part;
  }
  EXPECT_EQ(table.whole.inertial.mass, whole.whole.inertial.mass);

  const auto scene = read_scene(some / "model/scene.toml").value();
  std::map<std::string, std::string> parent;
  for (const Solid& solid : scene.solids) parent[solid.name] = solid.parent;
  EXPECT_EQ(parent, (std::map<std::string, std::string>{
                        {"trunk", "world"}, {"thigh_left", "trunk"}, {"hand_right", "world"}}));
  std::set<std::string> meshes;
  for (const auto& entry : fs::directory_iterator(some / "mesh")) meshes.insert(entry.path().stem());
  EXPECT_EQ(meshes, asked);
  const auto account = json::parse(read_input_file(some / "segmentation/segmentation.json").value());
  EXPECT_EQ(account["parts"].size(), 5u);
  EXPECT_EQ(account["segments"]["trunk"].size(), 3u);

  // the labels alone do not tell skin from what was left out
  const std::string inertia = "inertia --volume " + path("scan.nii.gz") + " --segments thigh_left --labels ";
  const std::string folder_of = (some / "segmentation").string();
  EXPECT_NE(run_program(inertia + folder_of + "/labels.nii.gz").err.find("parts.nii.gz with --segments"),
            std::string::npos);
  const ProgramRun right = run_program(inertia + folder_of + "/parts.nii.gz -o " + path("right.json"));
  EXPECT_EQ(right.err, "");
  EXPECT_EQ(read_table(path("right.json")).value().rows.at(0).inertial.mass, table.rows.at(1).inertial.mass);

  // from the files it left, the same again
  const std::string before = read_input_file(some / "inertia/table.json").value();
  fs::remove(some / "inertia/table.csv");
  ASSERT_EQ(run("some", "trunk,thigh_left,hand_right").code, 0);
  EXPECT_EQ(read_input_file(some / "inertia/table.json").value(), before);
  // another choice in the same folder leaves nothing of this one
  ASSERT_EQ(run("some", "").code, 0);
  EXPECT_FALSE(fs::exists(some / "segmentation/parts.nii.gz"));
  EXPECT_FALSE(fs::exists(some / "mesh/trunk.stl"));
  EXPECT_EQ(read_input_file(some / "inertia/table.csv").value(),
            read_input_file(all / "inertia/table.csv").value());
}

TEST_F(SegmentsVerbs, InertiaTakesSegmentsFromTheLabels) {
  const std::string inputs = "inertia --volume " + path("scan.nii.gz") + " --labels " +
                             path("labels.nii.gz") + " --landmarks " + path("joints.json");
  const ProgramRun done = run_program(inputs + " --segments arm_left,foot_right -o " + path("arm.json"));
  ASSERT_EQ(done.code, 0) << done.err;
  EXPECT_NE(done.out.find("arm_left"), std::string::npos);
  EXPECT_EQ(done.out.find("thigh_left"), std::string::npos);
  EXPECT_EQ(read_table(path("arm.json")).value().rows.size(), 2u);
  expect_refused(run_program(inputs + " --segments arms"), "unknown segment 'arms'; choose from head, ");
}

TEST_F(SegmentsVerbs, UnknownSegmentsAreRefusedBeforeAnyWork) {
  expect_refused(run_program("segment nowhere.nii.gz --segments thigh -o " + path("no")), "'thigh'");
  expect_refused(run_program("run nowhere.nii.gz --segments trunk,head,middle_trunk -o " + path("no")),
                 "trunk and middle_trunk share middle_trunk");
  EXPECT_FALSE(fs::exists(path("no")));
}

}  // namespace
}  // namespace borelli
