// `borelli ik` and `borelli id` as a user runs them: what they refuse before the work, and what they tell.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "process/input_file.hpp"
#include "tests/pipeline/program_run.hpp"

namespace borelli::motion_verbs_test {
namespace {

/// A pendulum with two markers, at rest in all frames; frames 4 and 5 of eight show no marker.
class MotionVerbs : public testing::Test {
 protected:
  MotionVerbs() {
    std::string trc =
        "PathFileType\t4\t(X/Y/Z)\tm.trc\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\n"
        "100\t100\t8\t2\tm\nFrame#\tTime\tA\t\t\tB\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n\n";
    for (int i = 0; i < 8; ++i)
      trc += fmt::format("{}\t{}{}\n", i + 1, 0.01 * i, i == 3 || i == 4 ? "" : "\t0\t0\t-1\t0.5\t0\t-1");
    motion = folder.write("m.trc", trc);
    angles = folder.write("q.mot",
                          "q\nversion=1\nnRows=3\nnColumns=2\ninDegrees=yes\nendheader\ntime\tswing\n0\t0\n"
                          "0.1\t0\n0.2\t0\n");
    model = scene("swing");
  }

  std::string scene(const std::string& coordinate) const {
    return folder.write("model.toml", "[[solid]]\nname = 'bob'\njoint = {rotation = 'y', name = '" +
                                          coordinate +
                                          "'}\nmass = 1\ncentre = [0.5, 0, 0]\ntensor = [1, 1, 1]\n"
                                          "[[marker]]\nname = 'A'\nsolid = 'bob'\npoint = [0, 0, -1]\n"
                                          "[[marker]]\nname = 'B'\nsolid = 'bob'\npoint = [0.5, 0, -1]\n");
  }
  std::string path(const std::string& name) const { return (folder / name).string(); }
  void refuses(const std::string& arguments, const std::string& words) const {
    const ProgramRun run = run_program(arguments);
    EXPECT_NE(run.code, 0) << arguments;
    EXPECT_NE(run.err.find(words), std::string::npos) << run.err;
    EXPECT_EQ(run.err.find("inverse"), std::string::npos) << "refused after the work: " << run.err;
  }

  TestFolder folder;
  std::string motion, angles, model;
};

TEST_F(MotionVerbs, RefuseBeforeTheWork) {
  const std::string ik = "ik " + model + " --motion " + motion, id = "id " + model + " --motion " + angles;
  refuses(ik + " -o " + path("x.h5"), "x.h5: ends in '.h5', expected .mot, .sto, .bvh or .trc");
  refuses(ik + " --errors " + path("e.png"), "e.png: ends in '.png', expected .sto or .mot");
  refuses(id + " -o " + path("x.csv"), "x.csv: ends in '.csv', expected .sto or .mot");
  refuses(ik + " --bvh-unit 0.01", "--bvh-unit: applies only to a motion in .bvh");
  refuses(ik + " --from nan", "--from");
  refuses("ik " + scene("left swing") + " --motion " + motion + " -o " + path("x.mot"), "left swing");
  for (const char* name : {"x.h5", "e.png", "x.csv", "x.mot"})
    EXPECT_FALSE(std::filesystem::exists(path(name)));
}

TEST_F(MotionVerbs, TellsFramesThatBvhInterpolates) {
  const std::string ik = "ik " + model + " --motion " + motion + " -o ";
  const std::string said = "since BVH has no gaps";
  const ProgramRun bvh = run_program(ik + path("m.bvh")), mot = run_program(ik + path("m.mot"));
  EXPECT_EQ(bvh.code, 0) << bvh.err;
  EXPECT_EQ(mot.code, 0) << mot.err;
  EXPECT_NE(bvh.err.find(said), std::string::npos) << bvh.err;
  EXPECT_EQ(mot.err.find(said), std::string::npos) << mot.err;
}

// A hinge to the world carries the body: its moment is no residual, and no ground force is missing.
TEST_F(MotionVerbs, HingesToTheWorldAreNoRoots) {
  const ProgramRun run = run_program("id " + model + " --cut-off 0 --motion " + angles);
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(run.out.find("Residuals"), std::string::npos) << run.out;
  EXPECT_EQ(run.err.find("ground force"), std::string::npos) << run.err;
  EXPECT_NE(run.out.find("4.9 N m"), std::string::npos) << run.out;  // 1 kg, 0.5 m beside the hinge, g = 9.81
}

TEST_F(MotionVerbs, FramesOfBvhAndTrcEndWithTheRun) {
  const std::string simulate = "simulate " + model + " --end 1 --output-interval 0.3 -o ";
  EXPECT_EQ(run_program(simulate + path("s.bvh")).code, 0);
  EXPECT_NE(read_input_file(path("s.bvh")).value_or("").find("Frames: 5\nFrame Time: 0.25"),
            std::string::npos);
  EXPECT_EQ(run_program(simulate + path("s.trc")).code, 0);
  EXPECT_NE(read_input_file(path("s.trc")).value_or("").find("\n4\t4\t5\t2\tmm"), std::string::npos);
}

}  // namespace
}  // namespace borelli::motion_verbs_test
