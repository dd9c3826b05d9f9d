// `borelli convert`: formats by file ending, named losses.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tests/pipeline/program_run.hpp"

namespace borelli::convert_test {
namespace {

using nlohmann::json;

const std::string pendulum = test::source_folder() + "/samples/double_pendulum.toml";

json answer(const std::string& arguments) {
  const ProgramRun run = run_program(arguments + " --json");
  EXPECT_EQ(run.code, 0) << run.err;
  return json::parse(run.out, nullptr, false);
}

TEST(Convert, ReadsItsOwnFilesBackWithTheSameAccelerations) {
  const TestFolder folder;
  const json wanted = answer("evaluate " + pendulum);
  for (const std::string name : {"a.xml", "a.mjcf", "a.toml"}) {
    const std::string file = folder / name;
    const json told = answer("convert " + pendulum + " -o " + file);
    EXPECT_EQ(told["file"], file);
    EXPECT_EQ(told["velocities"], wanted["coordinates"].size());
    const json found = answer("evaluate " + file);
    EXPECT_EQ(found["coordinates"], wanted["coordinates"]) << name;
    for (std::size_t i = 0; i < wanted["acceleration"].size(); ++i)
      EXPECT_NEAR(found["acceleration"][i].get<double>(), wanted["acceleration"][i].get<double>(), 1e-12)
          << name;
  }
}

TEST(Convert, NamesLossesInWarningsAndInTheAnswer) {
  const TestFolder folder;
  const std::string scene =
      folder.write("s.toml",
                   "[[solid]]\nname = \"arm\"\njoint = {rotation = \"y\", name = \"swing\", "
                   "value = 0.5}\nmass = 1\ncentre = [0, 0, -1]\ntensor = [0.1, 0.1, 0.1, 0, 0, 0]\n"
                   "[[effort]]\nname = \"push\"\nkind = \"force\"\nat = {solid = \"arm\", "
                   "point = [0, 0, 0]}\nforce = [1, 0, 0]\n");
  const std::string file = folder / "s.urdf";
  const ProgramRun run = run_program("convert " + scene + " -o " + file);
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_NE(run.err.find("warning: the written file lacks or changes: efforts are not written: push (force)"),
            std::string::npos)
      << run.err;
  EXPECT_NE(run.err.find("swing"), std::string::npos) << run.err;
  const json told = answer("convert " + scene + " -o " + file);
  EXPECT_EQ(told["omissions"].size(), 2u) << told.dump();
  EXPECT_EQ(told["warnings"].size(), 2u) << told.dump();
}

TEST(Convert, RefusesEndingsItDoesNotKnow) {
  const TestFolder folder;
  for (const std::string name : {"a.txt", "a", "a.xmlx"}) {
    const ProgramRun run = run_program("convert " + pendulum + " -o " + (folder / name).string());
    EXPECT_EQ(run.code, 2);
    EXPECT_NE(run.err.find("expected .xml or .mjcf (MuJoCo), .urdf (ROS), .osim (OpenSim) or .toml"),
              std::string::npos)
        << run.err;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  }
  EXPECT_EQ(folder.count(), 0);
}

TEST(Convert, EndingsMayBeInCapitals) {
  const TestFolder folder;
  for (const std::string ending : {".TOML", ".XML", ".Urdf", ".OSIM"}) {
    const std::string file = folder / ("arm" + ending);
    const ProgramRun made = run_program("convert " + pendulum + " -o " + file);
    EXPECT_EQ(made.code, 0) << made.err;
    for (const char* verb : {"info ", "evaluate "}) {
      const ProgramRun read = run_program(verb + file);
      EXPECT_EQ(read.code, 0) << read.err;
    }
  }
  for (const std::string ending : {".CSV", ".H5", ".Html", ".BVH"}) {
    const ProgramRun made =
        run_program("simulate " + pendulum + " --end 0.1 -o " + (folder / ("motion" + ending)).string());
    EXPECT_EQ(made.code, 0) << made.err;
  }
  EXPECT_EQ(run_program("info " + (folder / "motion.H5").string()).code, 0);
}

TEST(Convert, DoesNotOverwriteItsInput) {
  const TestFolder folder;
  const std::string scene =
      folder.write("s.xml",
                   "<mujoco><worldbody><body><freejoint/><inertial pos='0 0 0' mass='1' "
                   "diaginertia='1 1 1'/></body></worldbody></mujoco>");
  EXPECT_EQ(run_program("convert " + scene + " -o " + scene).code, 2);
}

}  // namespace
}  // namespace borelli::convert_test
