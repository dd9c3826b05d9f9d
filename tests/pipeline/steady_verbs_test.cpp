// `borelli equilibrium` and `borelli modes` as other programs use them.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "process/input_file.hpp"
#include "tests/paths.hpp"
#include "tests/pipeline/program_run.hpp"

namespace borelli::steady_verbs_test {
namespace {

using nlohmann::json;
const std::string samples = test::source_folder() + "/samples/";

TEST(SteadyVerbs, PendulumHangsDownAndSwingsByItsLength) {
  const TestFolder folder;
  const std::string state = folder.write("state.json", R"({"q": [1.1], "v": [3]})");
  const std::string rest = folder / "rest.json";
  const ProgramRun found =
      run_program("equilibrium " + samples + "pendulum.toml --json --state " + state + " -o " + rest);
  ASSERT_EQ(found.code, 0) << found.err;
  const json e = json::parse(found.out, nullptr, false);
  EXPECT_NEAR(e["state"]["q"][0], 0, 1e-9);
  EXPECT_EQ(e["state"]["v"][0], 0);
  EXPECT_NEAR(e["potential_energy"], -9.81, 1e-12);
  const ProgramRun modes = run_program("modes " + samples + "pendulum.toml --json --state " + rest);
  ASSERT_EQ(modes.code, 0) << modes.err;
  const json m = json::parse(modes.out, nullptr, false);
  EXPECT_EQ(m["stability"], "neutral");
  ASSERT_EQ(m["modes"].size(), 1u);
  EXPECT_NEAR(m["modes"][0]["frequency"], std::sqrt(9.81) / (2 * M_PI), 1e-9);
  EXPECT_NEAR(m["modes"][0]["damping_ratio"], 0, 1e-12);
  EXPECT_EQ(m["modes"][0]["shape"], json({{1.0, 0.0}}));
  // its start, level, is no equilibrium, so it searches first
  const ProgramRun both =
      run_program("modes " + samples + "pendulum.toml --equilibrium --json --state " + state);
  EXPECT_EQ(json::parse(both.out, nullptr, false)["stability"], "neutral") << both.err;
  const ProgramRun level = run_program("modes " + samples + "pendulum.toml");
  EXPECT_EQ(level.code, 2);
  EXPECT_NE(level.err.find("pendulum.toml, coordinate 'swing': the state is not steady"), std::string::npos)
      << level.err;
}

TEST(SteadyVerbs, SayWhatHoldsAtOneTimeOnly) {
  const TestFolder folder;
  const std::string upright = folder.write("up.json", R"({"q": [0]})");
  const ProgramRun modes = run_program("modes " + samples + "kapitza.toml --state " + upright);
  EXPECT_EQ(modes.code, 2);
  EXPECT_NE(modes.err.find("the scene changes with time (fastest: "), std::string::npos) << modes.err;
  const std::string scene =
      folder.write("swing.toml", read_input_file(samples + "pendulum.toml").value_or("") +
                                     "[[effort]]\nname = 'wave'\nkind = 'force'\n"
                                     "at = {solid = 'bob', point = [0, 0, -1]}\n"
                                     "force = [1, 0, 0]\nfactor = {kind = 'sine', angular_frequency = 3}\n");
  const ProgramRun rest = run_program("equilibrium " + scene + " --json");
  EXPECT_EQ(rest.code, 0) << rest.err;
  EXPECT_NE(rest.err.find("warning: the balance is that of t = 0 s: the scene changes with time"),
            std::string::npos)
      << rest.err;
}

TEST(SteadyVerbs, ExplainsAMissingEquilibrium) {
  const ProgramRun plate = run_program("equilibrium " + samples + "heavy_top.toml --json");
  EXPECT_EQ(plate.code, 0) << plate.err;  // it rests, hanging or standing
  const ProgramRun ball = run_program("equilibrium " + samples + "bouncing_ball.toml");
  EXPECT_EQ(ball.code, 2);
  EXPECT_NE(ball.err.find("constraint 'ground': is a contact"), std::string::npos) << ball.err;
}

}  // namespace
}  // namespace borelli::steady_verbs_test
