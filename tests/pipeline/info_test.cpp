// `borelli info` on scenes and trajectories.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "tests/paths.hpp"
#include "tests/pipeline/program_run.hpp"

namespace borelli::info_test {
namespace {

using nlohmann::json;
const std::string samples = test::source_folder() + "/samples/";

TEST(Info, DescribesAScene) {
  const ProgramRun run = run_program("info --json " + samples + "shock.toml");
  ASSERT_EQ(run.code, 0) << run.err;
  const json info = json::parse(run.out, nullptr, false);
  EXPECT_EQ(info["holds"], "scene");
  EXPECT_EQ(info["name"], "shock");
  EXPECT_EQ(info["mass"], 201);
  EXPECT_EQ(info["degrees_of_freedom"], 2);
  EXPECT_EQ(info["constraint_rows"], 1);
  EXPECT_EQ(info["solids"][1]["parent"], "cube");
  EXPECT_EQ(info["constraints"][0]["kind"], "point_on_plane");
  const ProgramRun said = run_program("info " + samples + "shock.toml");
  EXPECT_TRUE(
      said.out.starts_with("scene 'shock': 2 solids of 201 kg, 2 degrees of freedom, 1 constraint rows\n"))
      << said.out;
}

TEST(Info, DescribesATrajectory) {
  const TestFolder folder;
  const std::string file = (folder / "a.h5").string();
  ASSERT_EQ(run_program("simulate " + samples + "pendulum.toml --end 0.5 -o " + file).code, 0);
  const ProgramRun run = run_program("info --json " + file);
  ASSERT_EQ(run.code, 0) << run.err;
  const json info = json::parse(run.out, nullptr, false);
  EXPECT_EQ(info["holds"], "trajectory");
  EXPECT_EQ(info["scene"], "pendulum");
  EXPECT_EQ(info["coordinates"][0]["name"], "swing");
  EXPECT_EQ(info["end"]["t"], 0.5);
  EXPECT_TRUE(info["certificate"]["trusted"]);
  const ProgramRun said = run_program("info " + file);
  EXPECT_NE(said.out.find("\ntrusted\n"), std::string::npos) << said.out;
  for (const std::string option : {"--floating", "--lock swing", "--minimum-mass 1"}) {
    const ProgramRun refused = run_program("info " + option + " " + file);
    EXPECT_EQ(refused.code, 2) << option;
    EXPECT_NE(refused.err.find(option.substr(0, option.find(' ')) + ": does not apply to trajectories"),
              std::string::npos)
        << refused.err;
  }
}

TEST(Info, BadScenesAndTrajectoriesAreRefusedInOneSentence) {
  const TestFolder folder;
  ProgramRun run = run_program("info " + folder.write("a.toml", "solid = 3\n").string());
  EXPECT_EQ(run.code, 2);
  EXPECT_NE(run.err.find("a.toml:1: "), std::string::npos) << run.err;
  // (compiling finds it, and names the file itself)
  run = run_program("info " + folder
                                  .write("b.toml",
                                         "[[solid]]\nname = 'a'\nmass = 1\ntensor = [1, 1, 1]\n"
                                         "[[solid.joint]]\nname = 'glide'\nellipsoid = true\n"
                                         "radii = [0.1, -1, 0.1]\n")
                                  .string());
  EXPECT_EQ(run.code, 2);
  EXPECT_EQ(run.err, "borelli: " + (folder / "b.toml").string() +
                         ":1: solid 'a', coordinate 'glide': has a radius of 0 or less; expected three "
                         "positive lengths\n");
  run = run_program("info " + folder.write("a.h5", "\x89HDF\r\n\x1a\n and no more").string());
  EXPECT_NE(run.code, 0);
  EXPECT_EQ(run.out, "");
  EXPECT_FALSE(run.err.empty());
  // info does not wait for a pipe without a writer
  const std::string pipe = folder.write("pipe.nii", "").string();
  ASSERT_EQ(unlink(pipe.c_str()) + mkfifo(pipe.c_str(), 0600), 0);
  run = run_program("info " + pipe, "timeout 20");
  EXPECT_EQ(run.code, 2);
  EXPECT_NE(run.err.find("is not a regular file"), std::string::npos) << run.err;
}

TEST(Info, NamesDamagedAndForeignTrajectories) {
  const TestFolder folder;
  const std::string command = "simulate " + samples + "pendulum.toml --end 1 -o ";
  ASSERT_EQ(run_program(command + (folder / "a.h5").string()).code, 0);
  ASSERT_EQ(run_program(command + (folder / "a.csv").string()).code, 0);
  std::filesystem::resize_file(folder / "a.h5", std::filesystem::file_size(folder / "a.h5") - 1);
  const ProgramRun cut = run_program("info " + (folder / "a.h5").string());
  EXPECT_EQ(cut.code, 1);
  EXPECT_NE(cut.err.find("damaged or cut short"), std::string::npos) << cut.err;
  const ProgramRun table = run_program("info " + (folder / "a.csv").string());
  EXPECT_EQ(table.code, 2);
  EXPECT_NE(table.err.find("is a table without the trajectory"), std::string::npos) << table.err;
}

}  // namespace
}  // namespace borelli::info_test
