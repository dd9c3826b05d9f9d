// Every verb that reads a volume, labels, a table or a scene passes on all warnings of its reader: as text,
// in its JSON answer and in its output files.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "inertia/table_file.hpp"
#include "pipeline/charts/chart_page.hpp"
#include "pipeline/files/whole_file.hpp"
#include "process/input_file.hpp"
#include "samples/phantom.hpp"
#include "samples/phantom_voxels.hpp"
#include "segmentation/files/landmarks_file.hpp"
#include "segmentation/files/write.hpp"
#include "tests/pipeline/program_run.hpp"

namespace borelli::warnings_test {
namespace {

using nlohmann::json;

const Phantom& body() {
  static const Phantom made = build_phantom({}).value();
  return made;
}

Scan scan_of_body() {
  GridOptions grid;
  grid.spacing.setConstant(10);
  Scan scan = voxelise(body(), phantom_grid(body(), grid));
  scan.labels.names.assign(1, "outside");
  for (std::size_t label = 1; label < parts.size(); ++label)
    scan.labels.names.emplace_back(parts[label].name);
  return scan;
}

class Warnings : public testing::Test {
 protected:
  void SetUp() override {
    const Scan scan = scan_of_body();
    ASSERT_TRUE(write_volume((folder / "scan.nrrd").string(), scan.grey));
    ASSERT_TRUE(write_labels((folder / "labels.nrrd").string(), scan.labels));
    for (const char* name : {"scan.nrrd", "labels.nrrd"}) contradict_spacing(name);
    ASSERT_TRUE(write_landmarks((folder / "joints.json").string(), body().landmarks));
  }

  /// Makes the header claim slices of 20 mm, 10 mm apart.
  void contradict_spacing(const std::string& name) const {
    std::string bytes = read_input_file(folder / name).value();
    bytes.insert(bytes.find("dimension"), "thicknesses: nan nan 20\n");
    ASSERT_TRUE(write_whole(folder / name, bytes));
  }

  std::string path(const std::string& name) const { return (folder / name).string(); }

  /// Expects each of these on standard error and in "warnings" of the answer.
  void expect_warned(const std::string& arguments, const std::vector<std::string>& of) const {
    SCOPED_TRACE(arguments);
    const ProgramRun run = run_program(arguments + " --json");
    EXPECT_EQ(run.code, 0) << run.err;
    const std::string answered = json::parse(run.out, nullptr, false).value("warnings", json()).dump();
    for (const std::string& one : of) {
      EXPECT_NE(run.err.find("warning: " + one), std::string::npos) << run.err;
      EXPECT_NE(answered.find(one), std::string::npos) << answered;
    }
  }
  void expect_in_files(const std::vector<std::string>& names, const std::vector<std::string>& of) const {
    for (const std::string& name : names)
      for (const std::string& one : of)
        EXPECT_NE(read_input_file(folder / name).value_or("").find(one), std::string::npos)
            << name << ": " << one;
  }

  const TestFolder folder;
  const std::string said = "the header gives different voxel sizes";
  const std::string of_labels = path("labels.nrrd") + ": " + said;
  const std::string without_folder = "labels.nrrd: " + said;  // as outputs write it
};

TEST_F(Warnings, OfVolumesAndLabelsReachTextAnswersAndTables) {
  const std::string scan = path("scan.nrrd"), labels = " --labels " + path("labels.nrrd");
  expect_warned("info " + scan, {said});
  expect_warned("info " + path("labels.nrrd") + " --quantity labels", {of_labels});
  expect_warned("export " + path("labels.nrrd") + " --stl -o " + path("meshes"), {of_labels});
  expect_warned("inertia --volume " + scan + labels + " -o " + path("t.json") + " -o " + path("t.csv"),
                {said, of_labels});
  expect_in_files({"t.json", "t.csv"}, {said, without_folder});
  EXPECT_EQ(read_table(folder / "t.json").value().warnings.size(), 2u);
  const std::string of_table = path("t.json") + ": " + said;
  expect_warned(
      "skeleton " + path("t.json") + " --landmarks " + path("joints.json") + " -o " + path("s.toml"),
      {of_table});
  expect_warned("inertia --compare " + path("t.json") + " " + path("t.json"), {of_table});
}

TEST_F(Warnings, OfVolumesAndClassesReachSegmentations) {
  std::string classes = "name\tpart\n";
  for (std::size_t label = 1; label < parts.size(); ++label)
    classes += std::string(parts[label].name) + "\t" + std::string(parts[label].name) + "\n";
  const std::string map = folder.write("map.tsv", classes).string();
  expect_warned("segment " + path("scan.nrrd") + " --labels " + path("labels.nrrd") + " --label-mapping " +
                    map + " --work-grid 6 -o " + path("parts"),
                {said, of_labels});
  expect_in_files({"parts/segmentation.json"}, {said, without_folder});
}

TEST_F(Warnings, ReachRunsAndTheirReports) {
  const std::string run = "run " + path("scan.nrrd") + " --labels " + path("labels.nrrd") + " --landmarks " +
                          path("joints.json") + " --flight-time 0.1 --mesh-tolerance-mm 3 --subject s -o " +
                          path("out");
  for (int time = 0; time < 2; ++time) {  // the second time there is nothing to do
    expect_warned(run, {"segmentation: " + said, "segmentation: " + without_folder});
    expect_in_files({"out/s/run.json", "out/s/segmentation/segmentation.json", "out/s/inertia/table.json",
                     "out/s/report.html"},
                    {said, without_folder});
  }
  std::filesystem::remove(folder / "out/s/run.json");
  std::filesystem::remove(folder / "out/s/segmentation/segmentation.json");
  expect_warned("report " + path("out/s") + " --volume " + path("scan.nrrd"), {said});
  expect_in_files({"out/s/report.html"}, {said});
}

// A scan of air: nothing can be segmented, and the header's contradiction may be the reason.
TEST_F(Warnings, ReachTheUserOfARunThatFails) {
  Scan scan = scan_of_body();
  std::ranges::fill(scan.grey.voxels, std::int16_t{-1000});
  ASSERT_TRUE(write_volume(path("air.nrrd"), scan.grey));
  contradict_spacing("air.nrrd");
  const ProgramRun run = run_program("run " + path("air.nrrd") + " --subject s -o " + path("out"));
  EXPECT_EQ(run.code, 1) << run.err;
  EXPECT_NE(run.err.find("warning: segmentation: " + said), std::string::npos) << run.err;
}

// Voxels a quarter as long: 75 kg become 1.2 kg, too light for a scan of a whole body.
TEST_F(Warnings, TooLightBodyIsWarnedOf) {
  Scan scan = scan_of_body();
  scan.grey.grid.axes /= 4, scan.labels.grid.axes /= 4;
  scan.grey.grid.origin /= 4, scan.labels.grid.origin /= 4;
  ASSERT_TRUE(write_volume(path("small.nrrd"), scan.grey));
  ASSERT_TRUE(write_labels(path("small_labels.nrrd"), scan.labels));
  const std::string doubt = "the body has 1.1";
  ASSERT_NEAR(body().whole.mass / 64, 1.15, 0.05);
  expect_warned("inertia --volume " + path("small.nrrd") + " --labels " + path("small_labels.nrrd") + " -o " +
                    path("t.json"),
                {doubt});
  const InertiaTable table = read_table(folder / "t.json").value();
  EXPECT_EQ(table.whole.completeness, Completeness::whole);
  ASSERT_EQ(table.whole.notes.size(), 1u);
  EXPECT_EQ(table.whole.notes[0].find(doubt), 0u) << table.whole.notes[0];
  const std::string out = path("out");
  expect_warned("run " + path("small.nrrd") + " --labels " + path("small_labels.nrrd") +
                    " --flight-time 0.1 --subject s -o " + out,
                {"segmentation: the body has 1.1", "inertia: " + doubt});
  expect_in_files({"out/s/segmentation/segmentation.json", "out/s/inertia/table.json"}, {doubt});
}

TEST_F(Warnings, OfVolumesReachEconomy) {
  expect_warned("economy " + path("scan.nrrd") + " -o " + path("e"), {said});
  expect_in_files({"e/economy.html"}, {said});
}

TEST(WarningsOfScenes, UnmodelledElementsAreInEveryVerbsAnswer) {
  const TestFolder folder;
  const std::string file = folder.write(
      "arm.urdf",
      "<robot name='arm'><link name='base'/><link name='upper'><inertial><origin xyz='0 0 -1'/><mass "
      "value='1'/><inertia "
      "ixx='0.1' iyy='0.1' izz='0.1' ixy='0' ixz='0' iyz='0'/></inertial></link><joint name='shoulder' "
      "type='revolute'><parent link='base'/><child link='upper'/><axis xyz='0 1 0'/><limit lower='-3' "
      "upper='3' effort='9' "
      "velocity='9'/></joint></robot>");
  const std::string out = " -o " + (folder / "out").string();
  for (const std::string& verb : {"info " + file, "evaluate " + file, "equilibrium " + file, "modes " + file,
                                  "simulate --end 0.1 " + file, "economy --end 0.1 " + file + out,
                                  "chart --end 0.1 --methods dop853 --repeats 1 " + file + out,
                                  "stability --methods rk4 --steps 0.01:0.1 " + file + out}) {
    const ProgramRun run = run_program(verb + " --json");
    EXPECT_EQ(run.code, 0) << verb << "\n" << run.err;
    const json answer = json::parse(run.out, nullptr, false);
    EXPECT_NE(answer.value("not_modelled", json()).dump().find("effort"), std::string::npos) << verb;
    EXPECT_TRUE(answer.contains("warnings")) << verb;
  }
}

TEST(WarningsOfScenes, AreInTheFilesOfASimulationAndAConversion) {
  const TestFolder folder;
  const std::string file =
      folder.write("arm.xml",
                   "<mujoco><worldbody><body name='arm'><joint name='hinge' axis='0 1 0' frictionloss='2'/>"
                   "<geom type='capsule' fromto='0 0 0 0 0 -1' size='.05'/></body></worldbody></mujoco>");
  const std::string said = "frictionloss of <joint>";
  for (const std::string name : {"motion.html", "motion.h5"})
    EXPECT_EQ(run_program("simulate --end 0.1 " + file + " -o " + (folder / name).string()).code, 0) << name;
  for (const std::string name : {"arm.toml", "arm.osim", "arm.urdf", "copy.xml"})
    EXPECT_EQ(run_program("convert " + file + " -o " + (folder / name).string()).code, 0) << name;
  EXPECT_NE(run_program("info " + (folder / "motion.h5").string()).out.find(said), std::string::npos);
  for (const std::string name : {"motion.html", "arm.toml", "arm.osim", "arm.urdf", "copy.xml"}) {
    const std::string text = read_input_file(folder / name).value_or("");
    EXPECT_TRUE(text.find(said) != text.npos || text.find("frictionloss of \\u003cjoint") != text.npos)
        << name;
    EXPECT_EQ(text.find(folder.path().string()), text.npos) << name;
  }
}

TEST(WarningsOfScenes, AppearOnTheirPages) {
  const TestFolder folder;
  const std::string file =
      folder.write("tendon.xml",
                   "<mujoco><worldbody><body name='arm'><joint name='hinge' axis='0 1 0' frictionloss='2'/>"
                   "<geom type='capsule' fromto='0 0 0 0 0 -1' size='.05'/></body></worldbody></mujoco>");
  const std::string out = (folder / "out").string();
  for (const auto& [verb, page] :
       {std::pair("economy --end 0.1 ", "economy.html"),
        std::pair("chart --end 0.1 --methods dop853 --repeats 1 ", "chart.html"),
        std::pair("stability --methods rk4 --steps 0.01:0.1 ", "stability.html"),
        std::pair("stability --methods rk4 --steps 0.01 --long 20 ", "long.html")}) {
    const ProgramRun run = run_program(verb + file + " -o " + out + " --json");
    EXPECT_EQ(run.code, 0) << verb << "\n" << run.err;
    const json warnings = json::parse(run.out, nullptr, false).value("warnings", json::array());
    ASSERT_FALSE(warnings.empty()) << verb;
    const std::string text = read_input_file(folder / "out" / page).value_or("");
    EXPECT_NE(text.find("<h1>tendon.xml: "), std::string::npos) << page;  // the model has no name of its own
    for (const json& given : warnings) {
      std::string warning = given;  // the page leaves out the file's folder
      if (const auto at = warning.find(file); at != warning.npos)
        warning.replace(at, file.size(), "tendon.xml");
      EXPECT_NE(text.find("Warning: " + html_text(warning)), std::string::npos) << page << ": " << warning;
    }
  }
}

}  // namespace
}  // namespace borelli::warnings_test
