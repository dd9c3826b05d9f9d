// `borelli stability` as a user runs it, and scenes at which methods fail and must keep failing.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>
#include <tuple>

#include "dynamics/formats/scene_file.hpp"
#include "dynamics/methods/integrator.hpp"
#include "pipeline/charts/outcome.hpp"
#include "process/input_file.hpp"
#include "tests/paths.hpp"
#include "tests/pipeline/program_run.hpp"

namespace borelli::stability_verb_test {
namespace {

using nlohmann::json;
const std::string samples = test::source_folder() + "/samples/";

TEST(StabilityVerb, MapsASceneNumberAgainstTheStep) {
  const TestFolder folder;
  const ProgramRun run = run_program("stability " + samples +
                                     "heavy_top.toml --vary top.mass=1:10:2 --steps 1e-3:0.1:5 --methods "
                                     "rk4,dop853 --tolerances 1e-6,1e-4 --failing --json -o " +
                                     folder.path().string());
  ASSERT_EQ(run.code, 0) << run.err;
  const json answer = json::parse(run.out, nullptr, false);
  EXPECT_EQ(answer["runs"], 14);
  ASSERT_EQ(answer["limits"].size(), 4u);
  // the top's fast nutation, which the exact derivatives at the start include
  for (int i = 0; i < 2; ++i) {
    const double stable = answer["limits"][i]["stable"], linear = answer["limits"][i]["linear"];
    EXPECT_NEAR(stable / linear, 1, 0.02);
  }
  for (const char* file :
       {"stability.html", "stability.csv", "limits.csv", "rk4.svg", "rk4.png", "dop853.svg", "limits.svg"})
    EXPECT_TRUE(std::filesystem::exists(folder / file)) << file;
  int failing = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "failing"))
    failing += read_scene(entry.path()).has_value();
  EXPECT_GT(failing, 0);
}

TEST(StabilityVerb, AcceptsSeveralScenesAndForeignModels) {
  const TestFolder folder;
  const ProgramRun run =
      run_program("stability " + samples + "pendulum_3.toml " + samples +
                  "pendulum_4.toml --end 1 --steps 1e-2,1e-1 --methods rk4 -o " + folder.path().string());
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_NE(run.out.find("pendulum of 4 bars"), std::string::npos);
  const std::string model = folder.write("m.xml", R"(<mujoco><worldbody><body name="b">
      <joint name="j" type="hinge" axis="0 1 0" stiffness="5"/><geom type="sphere" size=".1" pos="0 0 -1" mass="1"/>
      </body></worldbody></mujoco>)");
  const ProgramRun mjcf =
      run_program("stability " + model + " --vary \"effort[0].stiffness=1,100\" --steps 0.01 " +
                  "--methods rk4 --json -o " + folder.path().string());
  ASSERT_EQ(mjcf.code, 0) << mjcf.err;
  EXPECT_EQ(json::parse(mjcf.out, nullptr, false)["runs"], 2);
}

TEST(StabilityVerb, ContinuesAfterAnInterruption) {
  const TestFolder folder;
  const std::string asked = "stability " + samples +
                            "heavy_top.toml --vary top.mass=1:10:4 --methods rk4,verlet,dopri5 "
                            "--json -o ";
  const auto text = [&](const std::string& name) { return read_input_file(folder / name).value(); };
  ASSERT_EQ(run_program(asked + (folder / "whole").string()).code, 0);
  // killed after ever longer times, in steps of 0.1 s, until it finishes
  const std::string partial = "broken/stability.partial.json";
  bool was_partial = false;
  std::string kept;
  for (int tenths = 1; tenths < 600 && !std::filesystem::exists(folder / "broken/stability.html"); ++tenths) {
    const ProgramRun run = run_program(asked + (folder / "broken").string(),
                                       fmt::format("timeout -s KILL {:.1f}", 0.1 * tenths));
    if (run.code != 0 && std::filesystem::exists(folder / partial)) {
      was_partial = true;
      const auto now = json::parse(text(partial));
      EXPECT_GE(now["limits"].size(), kept.empty() ? 0 : json::parse(kept)["limits"].size());
      kept = now.dump();
    }
  }
  EXPECT_TRUE(was_partial);
  EXPECT_FALSE(std::filesystem::exists(folder / partial));
  for (const char* name : {"stability.csv", "limits.csv"})
    EXPECT_EQ(text("broken/" + std::string(name)), text("whole/" + std::string(name))) << name;
}

TEST(StabilityVerb, IgnoresDamagedAndOlderResults) {
  const TestFolder folder;
  const std::string asked =
      "stability " + samples + "heavy_top.toml --steps 1e-2 -o " + folder.path().string();
  ASSERT_EQ(run_program(asked + " --methods rk4,verlet").code, 0);
  EXPECT_TRUE(std::filesystem::exists(folder / "verlet.svg"));
  for (const char* spoilt : {"[1,2]", "{\"asked\":3}", "7"}) {
    folder.write("stability.partial.json", spoilt);
    const ProgramRun run = run_program(asked + " --methods rk4");
    EXPECT_EQ(run.code, 0) << run.err;
  }
  for (const char* older : {"verlet.svg", "verlet.png"})
    EXPECT_FALSE(std::filesystem::exists(folder / older));
  EXPECT_TRUE(std::filesystem::exists(folder / "rk4.svg"));
}

TEST(StabilityVerb, ScenesOfOneNameAreNamedByTheirFiles) {
  const TestFolder folder;
  const std::string scene = read_input_file(samples + "pendulum.toml").value();
  std::filesystem::create_directories(folder / "other");
  std::string files;
  for (const char* name : {"soft.toml", "stiff.toml", "other/stiff.toml"})
    files += " " + folder.write(name, scene).string();
  const ProgramRun run =
      run_program("stability" + files + " " + samples +
                  "shock.toml --end 0.1 --steps 1e-2 --methods rk4 --json -o " + (folder / "out").string());
  ASSERT_EQ(run.code, 0) << run.err;
  const json limits = json::parse(run.out, nullptr, false)["limits"];
  ASSERT_EQ(limits.size(), 4u);
  const std::string own = read_scene(samples + "pendulum.toml").value().name;
  EXPECT_EQ(limits[0]["name"], own + " (soft.toml)");
  EXPECT_EQ(limits[1]["name"], own + " (stiff.toml, 2)");  // without folders
  EXPECT_EQ(limits[2]["name"], own + " (stiff.toml, 3)");
  EXPECT_EQ(limits[3]["name"], read_scene(samples + "shock.toml").value().name);
}

TEST(StabilityVerb, SingleSceneHasADrawingOfItsMethods) {
  const TestFolder folder;
  const std::string asked = "stability " + samples +
                            "pendulum.toml --end 1 --steps 1e-2,1e-1 --tolerances 1e-4 --json -o " +
                            folder.path().string() + " --methods ";
  ASSERT_EQ(run_program(asked + "rk4,verlet,dopri5").code, 0);
  for (const char* file : {"methods.svg", "methods.png", "rk4.svg", "dopri5.svg"})
    EXPECT_TRUE(std::filesystem::exists(folder / file)) << file;
  for (const char* file : {"limits.svg", "limits_tolerance.svg", "methods_tolerance.svg"})  // of one dot
    EXPECT_FALSE(std::filesystem::exists(folder / file)) << file;
  const std::string drawing = read_input_file(folder / "methods.svg").value();
  EXPECT_NE(drawing.find("Methods: 1 rk4, 2 verlet."), std::string::npos);
  std::size_t tiles = 0;
  for (std::size_t at = 0; (at = drawing.find("class='tile'", at)) != std::string::npos; ++at) ++tiles;
  EXPECT_EQ(tiles, 4u);
}

TEST(StabilityVerb, DrawsLongRuns) {
  const TestFolder folder;
  const ProgramRun run = run_program("stability " + samples +
                                     "pendulum.toml --long 2000 --steps 0.01 --methods "
                                     "rk4,verlet,euler --json -o " +
                                     folder.path().string());
  ASSERT_EQ(run.code, 0) << run.err;
  const json answer = json::parse(run.out, nullptr, false);
  EXPECT_EQ(answer["end"], 20);
  EXPECT_EQ(answer["runs"][1]["secular"], false);
  EXPECT_EQ(answer["runs"][2]["secular"], true);
  EXPECT_TRUE(std::filesystem::exists(folder / "long.html"));
  EXPECT_TRUE(std::filesystem::exists(folder / "energy_bounded.csv"));
}

TEST(StabilityVerb, RefusesBadUseInOneSentence) {
  const TestFolder folder;
  const std::string base = "stability " + samples + "shock.toml -o " + folder.path().string() + " ";
  const auto refused = [&](const std::string& arguments, const std::string& words) {
    const ProgramRun run = run_program(base + arguments);
    EXPECT_EQ(run.code, 2) << arguments;
    EXPECT_NE(run.err.find(words), std::string::npos) << run.err;
  };
  refused("--vary 'solid[cub].shape.mass=1:2'", "the nearest are solid[cube].shape.mass,");
  refused("--vary 'solid[cube].shape.mass'", "expected PATH=LOW:HIGH");
  refused("--vary 'solid[cube].shape.mass=2:1'", "--vary: is '2:1'; expected LOW:HIGH");
  refused("--steps=-1,1", "a step or tolerance is -1");
  refused("--long 100 --steps 1:2", "long runs need one positive number");
  refused(samples + "pendulum.toml --vary gravity[2]=1:2", "applies to a single scene");
  refused("--methods dop853 --steps 0.01", "--steps: has no effect, since all methods are adaptive");
  refused("--methods rk4 --tolerances 1e-6",
          "--tolerances: has no effect, since all methods have fixed steps");
}

// ---- failing scenes ----

struct Failing {
  std::filesystem::path file;
  std::string method, outcome, words;
  double setting = 0;
};

void PrintTo(const Failing& kept, std::ostream* out) { *out << kept.method << " at " << kept.setting; }

// tests/pipeline/failing/*.toml begin with their failure: "# fails: METHOD at SETTING by OUTCOME: WORDS"
std::vector<Failing> failing_scenes_kept() {
  std::vector<Failing> out;
  for (const auto& entry :
       std::filesystem::directory_iterator(test::source_folder() + "/tests/pipeline/failing")) {
    std::ifstream file(entry.path());
    for (std::string line; std::getline(file, line) && line.starts_with("#");) {
      static const std::regex form("# fails: (\\S+) at (\\S+) by ([a-z -]+): (.+)");
      std::smatch found;
      if (std::regex_match(line, found, form))
        out.push_back({entry.path(), found[1], found[3], found[4], std::stod(found[2])});
    }
  }
  std::sort(out.begin(), out.end(), [](const Failing& a, const Failing& b) {
    return std::tie(a.file, a.method) < std::tie(b.file, b.method);
  });
  return out;
}

class FailingScene : public testing::TestWithParam<Failing> {};

TEST_P(FailingScene, FailsAgainWithTheNamedOutcome) {
  const Failing& kept = GetParam();
  const auto scene = read_scene(kept.file);
  ASSERT_TRUE(scene) << scene.error().message();
  const System system = compile(*scene).value();
  SimulationSettings how = scene->simulation;
  how.method = kept.method;
  const Tried tried = try_run(system, how, kept.setting);
  EXPECT_EQ(name_of(tried.outcome), kept.outcome) << tried.reason;
  EXPECT_NE(tried.reason.find(kept.words), std::string::npos) << tried.reason;
}

std::string test_name(const testing::TestParamInfo<Failing>& kept) {
  const std::string name =
      kept.param.file.stem().string() + "_" + kept.param.method + "_" + kept.param.outcome;
  return std::regex_replace(name, std::regex("[ -]"), "_");
}

INSTANTIATE_TEST_SUITE_P(Kept, FailingScene, testing::ValuesIn(failing_scenes_kept()), test_name);

}  // namespace
}  // namespace borelli::stability_verb_test
