// A phantom with labels and joint centres as input of `borelli run`.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <sstream>
#include <string>

#include "pipeline/files/whole_file.hpp"
#include "process/input_file.hpp"
#include "samples/phantom.hpp"
#include "samples/phantom_voxels.hpp"
#include "segmentation/files/landmarks_file.hpp"
#include "segmentation/files/write.hpp"
#include "tests/pipeline/program_run.hpp"

namespace borelli::run_verb_test {

namespace fs = std::filesystem;

// one body for all tests; a coarse grid suffices to see which stages run
inline const Phantom& body() {
  static const Phantom made = build_phantom({}).value();
  return made;
}

inline const Scan& scan() {
  static const Scan made = [] {
    GridOptions grid;
    grid.spacing.setConstant(10);
    Scan drawn = voxelise(body(), phantom_grid(body(), grid));
    drawn.labels.names.assign(1, "outside");
    for (std::size_t label = 1; label < parts.size(); ++label)
      drawn.labels.names.emplace_back(parts[label].name);
    return drawn;
  }();
  return made;
}

class RunVerb : public testing::Test {
 protected:
  void SetUp() override {
    const Grid& g = scan().grey.grid;
    const auto voxels = std::as_bytes(std::span(scan().grey.voxels));
    ASSERT_TRUE(write_whole(folder / "scan.raw",
                            std::string_view(reinterpret_cast<const char*>(voxels.data()), voxels.size())));
    folder.write("scan.mhd",
                 fmt::format("ObjectType = Image\nNDims = 3\nDimSize = {} {} {}\nElementSpacing = 10 10 10\n"
                             "Offset = {} {} {}\nElementType = MET_SHORT\nElementDataFile = scan.raw\n",
                             g.size[0], g.size[1], g.size[2], g.origin[0], g.origin[1], g.origin[2]));
    folder.write(
        "scan.nhdr",
        fmt::format("NRRD0004\ntype: int16\ndimension: 3\nspace: left-posterior-superior\nsizes: {} {} {}\n"
                    "space directions: (10,0,0) (0,10,0) (0,0,10)\nspace origin: ({},{},{})\n"
                    "endian: little\nencoding: raw\ndata file: scan.raw\n",
                    g.size[0], g.size[1], g.size[2], g.origin[0], g.origin[1], g.origin[2]));
    ASSERT_TRUE(write_labels((folder / "labels.nrrd").string(), scan().labels));
    ASSERT_TRUE(write_landmarks((folder / "joints.json").string(), body().landmarks));
  }

  std::string path(const std::string& name) const { return (folder / name).string(); }
  /// All arguments except the volume; results go to out/<subject>.
  std::string words(const std::string& subject = "s", const std::string& landmarks = "joints.json") const {
    return " --quantity hu --labels " + path("labels.nrrd") + " --landmarks " + path(landmarks) +
           " --flight-time 0.1 --mesh-tolerance-mm 3 --subject " + subject + " -o " + path("out");
  }
  fs::path result(const std::string& name) const { return folder / "out/s" / name; }

  /// Runs to the end and returns the executed stages, except the picture's, which every run tries again
  /// without a display.
  std::set<std::string> stages_done(const std::string& arguments) const {
    const ProgramRun run = run_program("run " + arguments);
    EXPECT_EQ(run.code, 0) << run.err;
    std::set<std::string> done;
    std::istringstream said(run.err);
    for (std::string line; std::getline(said, line);) {
      const std::string stage = line.substr(0, line.find(' '));
      if (line.ends_with(" ...")) done.insert(stage);
      if (line.ends_with("already done")) done.erase(stage);
    }
    done.erase("picture");
    return done;
  }
  /// Expects one line on standard error that contains `said`, and no other output.
  void expect_refused(const std::string& arguments, int code, const std::string& said) const {
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.code, code) << arguments << "\n" << run.err;
    EXPECT_TRUE(run.err.starts_with("borelli: ")) << run.err;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    EXPECT_NE(run.err.find(said), std::string::npos) << run.err;
    EXPECT_EQ(run.out, "");
  }

  const TestFolder folder;
};

using Names = std::set<std::string>;

/// Files in a run's folder, and those that its run.json records as outputs of a stage.
inline std::pair<Names, Names> found_and_recorded(const fs::path& run) {
  Names found, recorded;
  for (const auto& entry : fs::recursive_directory_iterator(run))
    if (entry.is_regular_file()) found.insert(entry.path().lexically_relative(run).string());
  const auto record = nlohmann::json::parse(read_input_file(run / "run.json").value());
  for (const auto& stage : record["stages"])
    for (const auto& [file, bytes] : stage["outputs"].items()) recorded.insert(file);
  return {found, recorded};
}

inline const Names all{"segmentation", "inertia", "skeleton", "motion", "mesh",
                       "models",       "glb",     "slices",   "report"};

}  // namespace borelli::run_verb_test
