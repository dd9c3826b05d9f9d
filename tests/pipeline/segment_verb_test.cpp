// `borelli segment` from the command line: files and refusals.
#include <gtest/gtest.h>

#include <fmt/core.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "pipeline/body/segmentation_files.hpp"
#include "samples/phantom_voxels.hpp"
#include "segmentation/files/landmarks_file.hpp"
#include "segmentation/files/read.hpp"
#include "segmentation/files/write.hpp"
#include "tests/pipeline/program_run.hpp"

namespace borelli {
namespace {

namespace fs = std::filesystem;

TEST(SegmentVerb, WritesLabelsLandmarksAndFindings) {
  const TestFolder folder;
  const auto body = build_phantom({});
  ASSERT_TRUE(body) << body.error().message();
  GridOptions coarse;
  coarse.spacing = Eigen::Vector3d::Constant(4);
  const Grid grid = phantom_grid(*body, coarse);
  ASSERT_TRUE(write_volume(folder / "scan.nii.gz", voxelise(*body, grid).grey));

  const auto run = run_program("segment " + (folder / "scan.nii.gz").string() + " --work-grid 4 --json -o " +
                               (folder / "out").string());
  ASSERT_EQ(run.code, 0) << run.err;
  const auto answer = nlohmann::json::parse(run.out);
  EXPECT_EQ(answer.at("parts").at("thigh_left").at("coverage"), "whole");

  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator(folder / "out")) files.push_back(entry.path().filename());
  std::sort(files.begin(), files.end());
  EXPECT_EQ(files, (std::vector<std::string>{"labels.ctbl", "labels.nii.gz", "labels.tsv", "landmarks.json",
                                             "landmarks.mrk.json", "segmentation.json"}));

  const auto labels = read_labels((folder / "out/labels.nii.gz").string());
  ASSERT_TRUE(labels) << labels.error().message();
  std::array<std::int64_t, 256> count{};
  for (const auto v : labels->voxels) ++count[v];
  const auto findings = read_findings(folder / "out/segmentation.json");
  ASSERT_TRUE(findings) << findings.error().message();
  for (std::size_t n = 1; n < parts.size(); ++n) {
    EXPECT_EQ((*findings)[n].coverage, Coverage::whole) << parts[n].name;
    // the volume in segmentation.json is that of the labels in the file, to float32 rounding of the grid
    EXPECT_NEAR((*findings)[n].volume, static_cast<double>(count[n]) * 64, 1e-5 * (*findings)[n].volume);
  }
  const auto landmarks = read_landmarks((folder / "out/landmarks.json").string());
  ASSERT_TRUE(landmarks) << landmarks.error().message();
  EXPECT_LT((landmarks->at("shoulder_left").point - body->landmarks.at("shoulder_left").point).norm(), 4);
}

TEST(SegmentVerb, WritesItsLabelsAsDicomToo) {
  const TestFolder folder;
  const auto body = build_phantom({});
  ASSERT_TRUE(body) << body.error().message();
  GridOptions coarse;
  coarse.spacing = Eigen::Vector3d::Constant(5);
  ASSERT_TRUE(write_volume(folder / "scan.nrrd", voxelise(*body, phantom_grid(*body, coarse)).grey));
  const std::string command = "segment " + (folder / "scan.nrrd").string() + " --work-grid 5 -o " +
                              (folder / "out").string() + " --dicom";
  const auto patient = run_program(command + " --patient");
  EXPECT_EQ(patient.code, 2);
  EXPECT_NE(patient.err.find("DICOM scan"), std::string::npos) << patient.err;
  EXPECT_EQ(folder.count(), 1);
  const auto run = run_program(command);
  ASSERT_EQ(run.code, 0) << run.err;
  const auto labels = read_labels((folder / "out/labels.nii.gz").string());
  ASSERT_TRUE(labels) << labels.error().message();
  const auto dicom = read_labels((folder / "out/labels.dcm").string(), "", {}, &labels->grid);
  ASSERT_TRUE(dicom) << dicom.error().message();
  EXPECT_EQ(dicom->voxels, labels->voxels);
}

// Another program's label map on its own grid, and a knee landmark moved in 3D Slicer.
TEST(SegmentVerb, UsesClassesAndLandmarksOfOtherPrograms) {
  const TestFolder folder;
  const auto body = build_phantom({});
  GridOptions coarse;
  coarse.spacing = Eigen::Vector3d::Constant(5);
  const Scan scan = voxelise(*body, phantom_grid(*body, coarse));
  ASSERT_TRUE(write_volume(folder / "scan.nii.gz", scan.grey));
  LabelMap classes = scan.labels;
  classes.names.assign(classes.names.size(), "");
  for (std::size_t n = 1; n < parts.size(); ++n) classes.names[n] = "My " + std::string(parts[n].name);
  ASSERT_TRUE(write_labels(folder / "classes.nrrd", classes));
  std::string table = "name\tpart\n";
  for (std::size_t n = 2; n < parts.size(); ++n) table += fmt::format("my-{0}\t{0}\n", parts[n].name);
  folder.write("mapping.tsv", table);
  folder.write("moved.fcsv", "# CoordinateSystem = LPS\n1,10,20,500,0,0,0,1,1,1,0,KNEE LEFT,,,2,0\n");
  const std::string command = "segment " + (folder / "scan.nii.gz").string() + " --labels " +
                              (folder / "classes.nrrd").string() + " --work-grid 5 -o " +
                              (folder / "out").string();
  const auto needs = run_program(command);
  EXPECT_EQ(needs.code, 2);
  EXPECT_NE(needs.err.find("--label-mapping"), std::string::npos) << needs.err;
  const auto run = run_program(command + " --json --label-mapping " + (folder / "mapping.tsv").string() +
                               " --landmarks " + (folder / "moved.fcsv").string());
  ASSERT_EQ(run.code, 0) << run.err;
  const auto answer = nlohmann::json::parse(run.out);
  EXPECT_NE(answer.at("warnings").dump().find("1 of its classes are not in the mapping (My head)"),
            std::string::npos);
  const auto labels = read_labels((folder / "out/labels.nii.gz").string());
  ASSERT_TRUE(labels) << labels.error().message();
  std::size_t own = 0, all = 0;
  for (std::size_t o = 0; o < labels->voxels.size(); ++o) {
    all += scan.labels.voxels[o] > 1;
    own += scan.labels.voxels[o] > 1 && labels->voxels[o] == scan.labels.voxels[o];
  }
  EXPECT_EQ(own, all);
  const auto marks = read_landmarks((folder / "out/landmarks.json").string());
  ASSERT_TRUE(marks) << marks.error().message();
  EXPECT_EQ(marks->at("knee_left").point, Eigen::Vector3d(10, 20, 500));
  EXPECT_EQ(marks->at("knee_left").source, "placed by hand");
}

// The same body as MR: tissues and their densities; without classes or landmarks no parts. Messages state all
// this.
TEST(SegmentVerb, MrGivesTissuesWithAWarning) {
  const TestFolder folder;
  const auto body = build_phantom({});
  GridOptions coarse;
  coarse.spacing = Eigen::Vector3d::Constant(5);
  Scan scan = voxelise(*body, phantom_grid(*body, coarse));
  // bright fat and marrow, medium flesh, dark cortex, lungs and air
  for (auto& v : scan.grey.voxels)
    v = static_cast<std::int16_t>(v < -500 ? 5 : v < 0 ? 900 : v < 200 ? 330 : v < 1000 ? 850 : 20);
  scan.grey.quantity = Quantity::mr;
  ASSERT_TRUE(write_volume(folder / "mr.nii.gz", scan.grey));
  const std::string mr = (folder / "mr.nii.gz").string(), out = (folder / "out").string();
  const auto tissues = run_program("segment " + mr + " --json -o " + out);
  ASSERT_EQ(tissues.code, 0) << tissues.err;
  EXPECT_NE(tissues.err.find("MR alone does not show the parts"), std::string::npos) << tissues.err;
  const auto table = run_program("inertia --json --volume " + mr + " --labels " + out + "/labels.nii.gz");
  ASSERT_EQ(table.code, 0) << table.err;
  const auto answer = nlohmann::json::parse(table.out);
  const double mass = answer.at("body").at("mass_kg").get<double>();
  EXPECT_NEAR(mass, body->whole.mass, 0.06 * body->whole.mass);  // see mr_tissues_test.cpp; voxels of 5 mm
  const auto whole = run_program("run " + mr + " -o " + (folder / "run").string());
  EXPECT_EQ(whole.code, 1);
  EXPECT_NE(whole.err.find("hold its tissues"), std::string::npos) << whole.err;

  // parts from given joints
  ASSERT_TRUE(write_landmarks(folder / "joints.json", body->landmarks));
  const auto parted = run_program("segment " + mr + " --json --landmarks " +
                                  (folder / "joints.json").string() + " -o " + out);
  ASSERT_EQ(parted.code, 0) << parted.err;
  const auto parts_found = nlohmann::json::parse(parted.out).at("parts");
  const double litres = parts_found.at("thigh_left").at("volume_mm3").get<double>() * 1e-6;
  EXPECT_NEAR(litres, 1e3 * body->volume[static_cast<std::size_t>(part_label("thigh_left"))], 0.05 * litres);
}

TEST(RunOptions, WithoutEffectAreRefused) {
  const TestFolder folder;
  const std::string run = "run " + (folder / "scan.nii.gz").string() + " -o " + (folder / "out").string();
  for (const char* options :
       {" --label-names names.tsv", " --labels map.nii.gz --work-grid 4", " --label-mapping icrp110"}) {
    const auto refused = run_program(run + options);
    EXPECT_EQ(refused.code, 2) << options;
    EXPECT_NE(refused.err.find("--labels"), std::string::npos) << refused.err;
  }
  EXPECT_EQ(folder.count(), 0);
}

TEST(SegmentVerb, TooCoarseGridIsRefusedBySegmentAndRun) {
  const TestFolder folder;
  const std::string output = " -o " + (folder / "out").string();
  for (const char* asked : {"segment x.nii --work-grid 10", "run x.nii --work-grid 10"}) {
    const auto refused = run_program(asked + output);
    EXPECT_EQ(refused.code, 2) << asked;
    EXPECT_NE(refused.err.find("is 10, expected a number from 1 to 6"), std::string::npos) << refused.err;
  }
}

TEST(SegmentVerb, BadUseAndFailureAreReported) {
  const TestFolder folder;
  const auto missing =
      run_program("segment " + (folder / "none.nii.gz").string() + " -o " + (folder / "out").string());
  EXPECT_EQ(missing.code, 2);
  EXPECT_NE(missing.err.find("none.nii.gz"), std::string::npos);
  const auto unknown = run_program("segment x.nii --quantity colour -o " + (folder / "out").string());
  EXPECT_EQ(unknown.code, 2);
  EXPECT_FALSE(fs::exists(folder / "out"));
}

TEST(SegmentationFiles, DamagedFindingsAreRefused) {
  const TestFolder folder;
  const std::string path = (folder / "segmentation.json").string();
  for (const auto& [text, expected] : {std::pair{"{", "ends too early"},
                                       {"{}", "record"},
                                       {R"({"parts": {"tail": {}}})", "tail"},
                                       {R"({"parts": {"head": {"coverage": "half"}}})", "half"}}) {
    std::ofstream(path) << text;
    const auto read = read_findings(path);
    ASSERT_FALSE(read) << text;
    EXPECT_NE(read.error().message().find(expected), std::string::npos) << read.error().message();
  }
}

// A body without its left foot, stated by --absent: all outputs say so and give the same verdict.
TEST(SegmentVerb, VerdictAndAbsentPartsReachAllOutputs) {
  const TestFolder folder;
  const auto body = build_phantom({});
  GridOptions coarse;
  coarse.spacing = Eigen::Vector3d::Constant(4);
  Scan scan = voxelise(*body, phantom_grid(*body, coarse));
  for (std::size_t o = 0; o < scan.grey.voxels.size(); ++o)
    if (scan.labels.voxels[o] == part_label("foot_left")) scan.grey.voxels[o] = -1000;
  ASSERT_TRUE(write_volume(folder / "scan.nii.gz", scan.grey));
  const std::string out = (folder / "out").string(), volume = (folder / "scan.nii.gz").string();
  const auto refused = run_program("segment " + volume + " --absent head -o " + out);
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.err.find("foot_left"), std::string::npos) << refused.err;

  const auto run = run_program("segment " + volume + " --absent foot_left --json -o " + out);
  ASSERT_EQ(run.code, 0) << run.err;
  const auto answer = nlohmann::json::parse(run.out);
  EXPECT_EQ(answer.at("absent"), "foot_left");
  EXPECT_EQ(answer.at("parts").at("foot_left").at("note"), "stated as absent");
  EXPECT_EQ(answer.at("parts").at("shank_left").at("note"), "stump: foot is stated as absent");
  EXPECT_EQ(answer.at("verdict"), "good") << answer.at("verdict_reasons");
  std::ifstream file(folder / "out/segmentation.json");
  const auto account = nlohmann::json::parse(file);
  EXPECT_EQ(account.at("verdict"), answer.at("verdict"));
  for (const auto& warning : account.at("single_warnings")) EXPECT_EQ(warning.at("severity"), "note");
  EXPECT_EQ(*read_verdict(folder / "out/segmentation.json"), "good");
  EXPECT_TRUE((*read_absent(folder / "out/segmentation.json"))[15]);

  const auto table = run_program("inertia --volume " + volume + " --labels " + out +
                                 "/labels.nii.gz --landmarks " + out + "/landmarks.json --findings " + out +
                                 "/segmentation.json --json -o " + out + "/table.json");
  ASSERT_EQ(table.code, 0) << table.err;
  const auto inertia = nlohmann::json::parse(table.out);
  EXPECT_EQ(inertia.at("source").at("segmentation"), "good");
  EXPECT_EQ(inertia.at("parts").at(14).at("notes"), nlohmann::json({"stated as absent"}));
  const auto scene = run_program("skeleton " + out + "/table.json --landmarks " + out +
                                 "/landmarks.json -o " + out + "/scene.toml");
  ASSERT_EQ(scene.code, 0) << scene.err;
  std::ifstream toml(folder / "out/scene.toml");
  const std::string text((std::istreambuf_iterator<char>(toml)), {});
  EXPECT_NE(text.find("Stated as absent: foot_left."), std::string::npos);
  EXPECT_EQ(scene.err.find("shank_left"), std::string::npos) << scene.err;
}

}  // namespace
}  // namespace borelli
