// `borelli simulate` as a user runs it: good scenes give a trajectory and a certificate, bad ones one
// sentence, an exit code and no file.
#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "pipeline/export/trajectory_file.hpp"
#include "tests/paths.hpp"
#include "tests/pipeline/program_run.hpp"

namespace borelli::simulate_test {
namespace {

const std::string samples = test::source_folder() + "/samples/";

std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return std::string{std::istreambuf_iterator<char>(file), {}};
}

// Shell text that starts a program and runs `command` ($p is the process id) once `file` exists, after 60 s
// at the latest.
std::string when_there(const std::string& file, const std::string& command) {
  return "sh -c 'p=$$; (n=0; while [ ! -e " + file +
         " ] && kill -0 $p && [ $n -lt 1200 ]; do sleep 0.05; n=$((n + 1)); done; " + command +
         ") 2>/dev/null & exec \"$@\"' sh";
}

// Expects one line on standard error, nothing on standard output and no file.
void expect_refused(const std::string& arguments, int code, const std::string& said, const TestFolder& folder,
                    int files) {
  const ProgramRun run = run_program(arguments);
  EXPECT_EQ(run.code, code) << arguments << "\n" << run.err;
  EXPECT_TRUE(run.err.starts_with("borelli: ")) << run.err;
  EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  EXPECT_NE(run.err.find(said), std::string::npos) << run.err;
  EXPECT_EQ(run.out, "");
  EXPECT_EQ(folder.count(), files);
}

TEST(Simulate, WritesTheTrajectoryAndPrintsTheCertificate) {
  const TestFolder folder;
  const ProgramRun run =
      run_program("simulate " + samples + "roundabout.toml -o " + (folder / "a.h5").string());
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_TRUE(run.out.starts_with("trusted\nvouches for energy, momenta and constraints, not the state: "))
      << run.out;
  EXPECT_EQ(folder.count(), 1);
  const auto stored = read_trajectory(folder / "a.h5");
  ASSERT_TRUE(stored) << stored.error().message();
  EXPECT_EQ(stored->trajectory.times.size(), 501u);
  EXPECT_EQ(stored->trajectory.times.back(), 5);
  EXPECT_TRUE(stored->trajectory.certificate.trusted);
  EXPECT_NE(stored->scene.find("name = \"roundabout\""), std::string::npos);
}

TEST(Simulate, FlagsOverrideTheScene) {
  const TestFolder folder;
  const ProgramRun run = run_program("simulate " + samples +
                                     "roundabout.toml --json --method rk4_adaptive --end 0.25 "
                                     "--tolerance 1e-10 --step 1e-4 --output-interval 0.05 -o " +
                                     (folder / "a.csv").string());
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(run.err, "");
  const auto answer = nlohmann::json::parse(run.out, nullptr, false);
  ASSERT_TRUE(answer.is_object()) << run.out;
  EXPECT_EQ(answer["rows"], 6);
  EXPECT_EQ(answer["end"]["t"], 0.25);
  EXPECT_EQ(answer["end"]["q"].size(), 3u);
  EXPECT_EQ(answer["coordinates"][1]["name"], "right");
  EXPECT_TRUE(answer["certificate"]["trusted"]);
  EXPECT_NE(answer["certificate"]["vouches_for"].get<std::string>().find("not the state"), std::string::npos);
  EXPECT_TRUE(answer["certificate"]["state_known_until"].is_null());
  EXPECT_LT(answer["certificate"]["energy_drift"],
            1e-7);  // a fixed step of 0.01 would drift by 1e-5 in that time
}

TEST(Simulate, UntrustedRunsFailUnlessAllowed) {
  const TestFolder folder;
  const std::string euler =
      "simulate " + samples + "roundabout.toml --method euler -o " + (folder / "a.h5").string();
  ProgramRun run = run_program(euler);
  EXPECT_EQ(run.code, 1);
  EXPECT_TRUE(run.out.starts_with("UNTRUSTED: ")) << run.out;
  EXPECT_NE(run.err.find("does not trust the run: the energy balance"), std::string::npos) << run.err;
  EXPECT_EQ(folder.count(), 0);

  run = run_program(euler + " --json");
  EXPECT_EQ(run.code, 1);
  const auto answer = nlohmann::json::parse(run.out, nullptr, false);
  ASSERT_TRUE(answer.is_object()) << run.out;
  EXPECT_FALSE(answer["certificate"]["trusted"]);
  EXPECT_TRUE(answer["output"].is_null());

  run = run_program(euler + " --allow-untrusted");
  EXPECT_EQ(run.code, 0) << run.err;
  const auto stored = read_trajectory(folder / "a.h5");
  ASSERT_TRUE(stored);
  EXPECT_FALSE(stored->trajectory.certificate.trusted);
}

TEST(Simulate, BadUseIsRefusedInOneSentence) {
  const TestFolder folder;
  const std::string output = " -o " + (folder / "a.h5").string();
  expect_refused("simulate /no/such.toml" + output, 2, "no such file", folder, 0);
  expect_refused("simulate" + output, 2, "scene", folder, 0);
  expect_refused("simulate " + samples + "roundabout.toml --method magic" + output, 2, "magic", folder, 0);
  expect_refused("simulate " + samples + "roundabout.toml --step -1" + output, 2,
                 "is -1, expected a positive number", folder, 0);
  for (const char* number : {"--end inf", "--tolerance 0", "--step nan", "--tolerance few"})
    expect_refused("simulate " + samples + "roundabout.toml " + number + output, 2,
                   "expected a positive number", folder, 0);
  for (const char* option :
       {"--end", "--step", "--tolerance", "--accuracy", "--output-interval", "--checkpoint-every"})
    for (const char* number : {"nan", "-nan", "inf", "-inf", "-1", "1e999"})
      expect_refused("simulate " + samples + "roundabout.toml " + option + "=" + number + output, 2,
                     "expected", folder, 0);
  expect_refused("simulate " + samples + "roundabout.toml --method rk4 --tolerance 1e-6" + output, 2,
                 "--tolerance: has no effect with rk4", folder, 0);
  expect_refused("simulate " + samples + "roundabout.toml --accuracy 1e-6 --step 1e-3" + output, 2,
                 "--step: has no effect with an accuracy of 1e-06", folder, 0);
  expect_refused("simulate " + samples + "roundabout.toml --constraints glue" + output, 2, "glue", folder, 0);
  expect_refused("simulate " + samples + "roundabout.toml -o " + (folder / "a.xyz").string(), 2,
                 "expected .h5", folder, 0);
  expect_refused("simulate " + samples + output, 2, "is a folder", folder, 0);
}

TEST(Simulate, BadScenesAreNamedWithTheirLine) {
  const TestFolder folder;
  const std::string output = " -o " + (folder / "a.h5").string();
  const std::string scene = folder.write("bad.toml", "[[solid]]\nname = 'a'\nmass = 1\ntensor = [1, 1, 3]\n");
  expect_refused("simulate " + scene + output, 2, "bad.toml:4: solid 'a'", folder, 1);
  folder.write("bad.toml", "[[solid]]\nname = 'a'\nmass = -1\ntensor = [1, 1, 1]\n");
  expect_refused("simulate " + scene + output, 2, "bad.toml:3: solid 'a': mass is -1 kg", folder, 1);
  folder.write("bad.toml", "[[solid]]\nname = 'a'\njoint = {rotation = 'x'}\n");
  const ProgramRun massless = run_program("simulate " + scene + output);
  EXPECT_EQ(massless.code, 2) << massless.err;  // a coordinate that moves no mass: named with file and line
  EXPECT_NE(massless.err.find("bad.toml:1: "), std::string::npos) << massless.err;
  EXPECT_NE(massless.err.find("'a'"), std::string::npos) << massless.err;
  folder.write("bad.toml", "[simulation]\nmethod = 'magic'\n");
  expect_refused("simulate " + scene + output, 2, "bad.toml:2", folder, 1);
  const std::string model = folder.write("bare.xml", "<mujoco><worldbody><light/></worldbody></mujoco>");
  expect_refused("simulate " + model + output, 2, "bare.xml: contains no body", folder, 2);
  folder.write("bad.toml", std::string("name = \"\xff\xfe\"\n\0\0", 14));
  expect_refused("simulate " + scene + output, 2, "bad.toml:1", folder, 2);
}

TEST(Simulate, UnwritableOutputLeavesNothing) {
  const TestFolder folder;
  folder.write("file", "");
  const ProgramRun run =
      run_program("simulate " + samples + "roundabout.toml -o " + (folder / "file/below/a.h5").string());
  EXPECT_EQ(run.code, 1) << run.err;
  EXPECT_EQ(folder.count(), 1);
  EXPECT_EQ(run.out, "");  // refused before the work
  EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
}

TEST(Simulate, FullDisksAreReportedInOneSentence) {
  const TestFolder folder;
  for (const char* name : {"a.h5", "a.csv"}) {
    // 20 blocks of 512 bytes suffice for the messages but not for the trajectory
    const ProgramRun run = run_program(
        "simulate " + samples + "roundabout.toml -o " + (folder / name).string(), "ulimit -f 20;");
    EXPECT_EQ(run.code, 1) << name << "\n" << run.err;
    EXPECT_NE(run.err.find((folder / name).string() + ": cannot be written: File too large"),
              std::string::npos)
        << run.err;
    EXPECT_EQ(run.err.find(".partial-"), std::string::npos) << run.err;
    EXPECT_EQ(folder.count(), 0) << name;
  }
}

TEST(Simulate, FullStandardOutputIsAnError) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  for (const char* arguments : {"simulate --json ", "simulate ", "evaluate ", "info ", "info --json "}) {
    const ProgramRun run = run_program(arguments + samples + "pendulum.toml >/dev/full");
    EXPECT_EQ(run.code, 1) << arguments;
    EXPECT_NE(run.err.find("No space left on device"), std::string::npos) << arguments << run.err;
  }
}

TEST(Simulate, SignalsEndTheProgramAndLeaveOnlyTheRowsSoFar) {
  const TestFolder folder;
  // 10^8 steps would take minutes; timeout(1) sends the signal after one second and returns 128 plus the
  // signal's number, like a shell
  const std::string arguments = "simulate " + samples +
                                "pendulum_7.toml --end 1e5 --step 1e-3 --output-interval 1 -o " +
                                (folder / "a.h5").string();
  for (const int signal : {SIGTERM, SIGINT}) {
    const ProgramRun run =
        run_program(arguments, "timeout --foreground --preserve-status -s " + std::to_string(signal) + " 1");
    EXPECT_EQ(run.code, 128 + signal) << run.err;
    EXPECT_EQ(folder.count(), int(std::filesystem::exists(folder / "a.partial.h5")));
  }
}

// Rows without their last column, the verdict on the run; the first names the columns.
std::vector<std::string> rows_of_csv(const std::string& path) {
  std::ifstream file(path);
  std::vector<std::string> rows;
  for (std::string line; std::getline(file, line);) rows.push_back(line.substr(0, line.rfind(',')));
  return rows;
}

TEST(Simulate, KilledRunLeavesItsRowsSoFar) {
  const TestFolder folder;
  for (const char* ending : {".h5", ".csv"}) {
    const auto file = [&](const char* name) { return (folder / name).string() + ending; };
    const std::string command = "simulate " + samples +
                                "pendulum_7.toml --method rk4 --step 1e-3 --output-interval 0.1 -o " +
                                file("a") + " --end ";
    // the kill comes at any moment, within a write or between two
    EXPECT_NE(run_program(command + "1e5", when_there(file("a.partial"), "sleep 1; kill -KILL $p")).code, 0);
    EXPECT_FALSE(std::filesystem::exists(file("a")));
    ASSERT_TRUE(std::filesystem::exists(file("a.partial")));
    if (std::string(ending) == ".h5") {
      const auto rows = read_trajectory(file("a.partial"));
      ASSERT_TRUE(rows) << rows.error().message();
      const Trajectory& t = rows->trajectory;
      ASSERT_GT(t.times.size(), 10u);
      EXPECT_FALSE(t.certificate.trusted);
      EXPECT_NE(t.certificate.reason.find("interrupted"), std::string::npos) << t.certificate.reason;
      const ProgramRun info = run_program("info " + file("a.partial"));
      EXPECT_EQ(info.code, 0) << info.err;
      // the rows equal those of a finished run
      const std::string end = std::to_string(t.times.back() + 0.5);
      ASSERT_EQ(run_program(command + end).code, 0);
      const auto whole = read_trajectory(file("a"));
      ASSERT_TRUE(whole);
      EXPECT_TRUE(t.q == whole->trajectory.q.topRows(t.q.rows()));
    } else {
      const std::vector<std::string> rows = rows_of_csv(file("a.partial"));
      ASSERT_GT(rows.size(), 10u);
      ASSERT_EQ(run_program(command + std::to_string(std::stod(rows.back()) + 0.5)).code, 0);
      const std::vector<std::string> whole = rows_of_csv(file("a"));
      ASSERT_GT(whole.size(), rows.size());
      EXPECT_TRUE(std::equal(rows.begin(), rows.end(), whole.begin()));
    }
    EXPECT_FALSE(std::filesystem::exists(file("a.partial")));
    std::filesystem::remove(file("a"));
    EXPECT_EQ(folder.count(), 0);
  }
}

TEST(Simulate, ResumedRunRemovesPartialCheckpoints) {
  const TestFolder folder;
  const std::string kept = folder / "run.checkpoint";
  const std::string command =
      "simulate " + samples + "pendulum_7.toml --method rk4 --end 20 --step 1e-4 --output-interval 0.1";
  const ProgramRun first = run_program(command + " --checkpoint-every 0.05 --checkpoint " + kept,
                                       when_there(kept, "kill -KILL $p"));
  EXPECT_NE(first.code, 0);
  ASSERT_TRUE(std::filesystem::exists(kept));
  const pid_t killed = fork();
  if (killed == 0) _exit(0);
  waitpid(killed, nullptr, 0);
  const auto partial = [&](pid_t writer, const std::string& name) {
    return folder.write(".partial-" + std::to_string(writer) + "-" + name, "half");
  };
  const auto mine = partial(killed, "run.checkpoint"), another = partial(killed, "other.checkpoint"),
             living = partial(getppid(), "run.checkpoint");
  EXPECT_EQ(run_program(command + " --checkpoint " + kept).code, 0);
  EXPECT_FALSE(std::filesystem::exists(mine));
  EXPECT_TRUE(std::filesystem::exists(another));
  EXPECT_TRUE(std::filesystem::exists(living));
}

TEST(Simulate, StoppedRunResumesBitForBit) {
  const TestFolder folder;
  const auto command = [&](const std::string& output, const std::string& more) {
    // 6e5 steps take seconds, also before the signal comes on a busy machine
    return "simulate " + samples +
           "pendulum_7.toml --method rk4 --end 60 --step 1e-4 --output-interval 0.1 -o " +
           (folder / output).string() + more;
  };
  const std::string kept = folder / "run.checkpoint";
  const std::string broken = command("a.csv", " --checkpoint " + kept);
  const ProgramRun first = run_program(broken + " --checkpoint-every 0.05", when_there(kept, "kill -INT $p"));
  EXPECT_EQ(first.code, 1) << first.err;
  EXPECT_NE(first.err.find("the same command continues from " + kept), std::string::npos) << first.err;
  EXPECT_EQ(folder.count(), 1);
  // another run's checkpoint is refused
  const ProgramRun other = run_program(command("a.csv", " --equations lagrange --checkpoint " + kept));
  EXPECT_EQ(other.code, 2);
  EXPECT_NE(other.err.find("is the checkpoint of another scene"), std::string::npos) << other.err;
  EXPECT_EQ(run_program(broken).code, 0);
  EXPECT_EQ(folder.count(), 1);  // the checkpoint is gone
  EXPECT_EQ(run_program(command("b.csv", "")).code, 0);
  EXPECT_GT(text_of(folder / "a.csv").size(), 1000u);
  EXPECT_TRUE(text_of(folder / "a.csv") == text_of(folder / "b.csv"));
  const std::string foreign = folder.write("notes.txt", "mine");
  EXPECT_EQ(run_program(command("c.csv", " --checkpoint " + foreign)).code, 2);
}

TEST(Simulate, KeepsItsCheckpointUntilTheResultIsWritten) {
  const TestFolder folder;
  const std::string plain =
      "simulate " + samples +
      "pendulum_7.toml --method rk4 --end 4 --step 2e-4 --output-interval 2e-3 --reactions -o " +
      (folder / "a.csv").string();
  ASSERT_EQ(run_program(plain).code, 0);
  const std::string whole = text_of(folder / "a.csv");
  std::filesystem::remove(folder / "a.csv");
  const std::string kept = folder / "run.checkpoint", command = plain + " --checkpoint " + kept;
  // the limit on file sizes lets the checkpoint pass, which has no reactions, but not the longer CSV file
  const std::string limit = "ulimit -f " + std::to_string(whole.size() / 512 - 1) + ";";
  const ProgramRun full = run_program(command + " --checkpoint-every 0.02", limit);
  EXPECT_EQ(full.code, 1);
  EXPECT_NE(full.err.find("a.csv: cannot be written"), std::string::npos) << full.err;
  EXPECT_EQ(folder.count(), 1);
  ASSERT_TRUE(std::filesystem::exists(kept));
  EXPECT_EQ(run_program(command).code, 0);
  EXPECT_TRUE(text_of(folder / "a.csv") == whole);
  EXPECT_EQ(folder.count(), 1);
}

// Batch systems send several signals at once: the second must not end the run before its checkpoint is
// written.
TEST(Simulate, SimultaneousSignalsStopARunOnce) {
  const TestFolder folder;
  const std::string kept = folder / "run.checkpoint";
  const ProgramRun stopped = run_program(
      "simulate " + samples +
          "pendulum_7.toml --method rk4 --end 100 --step 1e-4 --checkpoint-every 0.05 --checkpoint " + kept,
      when_there(kept, "kill -TERM $p; kill -HUP $p; kill -TERM $p"));
  EXPECT_EQ(stopped.code, 1) << stopped.err;
  EXPECT_NE(stopped.err.find("the same command continues from " + kept), std::string::npos) << stopped.err;
  EXPECT_EQ(folder.count(), 1);
}

TEST(Simulate, ContinuesWithClosedStandardError) {
  const TestFolder folder;
  const std::string command =
      "simulate " + samples + "pendulum.toml --end 1 -o " + (folder / "a.csv").string();
  ASSERT_EQ(run_program(command).code, 0);
  const std::string whole = text_of(folder / "a.csv");
  for (const char* closed : {" 2>/dev/full", " 2>&-", " 2>&- 0<&-"}) {
    std::filesystem::remove(folder / "a.csv");
    EXPECT_EQ(run_program(command + closed).code, 0) << closed;
    EXPECT_TRUE(text_of(folder / "a.csv") == whole) << closed;  // the message is not in the file
    EXPECT_EQ(run_program("simulate --foo" + std::string(closed)).code, 2) << closed;
  }
  EXPECT_EQ(run_program(command + " >&-").code, 1);  // its output cannot be printed
}

TEST(Simulate, NeverOverwritesItsInputs) {
  const TestFolder folder;
  const std::string scene = text_of(samples + "pendulum.toml"), own = folder.write("scene.csv", scene);
  std::filesystem::create_symlink(own, folder / "link.csv");
  for (const std::string& output :
       {own, own.substr(0, own.rfind('/')) + "/./scene.csv", std::string(folder / "link.csv")})
    expect_refused("simulate " + own + " -o " + output, 2, "is an input of this command", folder, 2);
  const std::string json = folder.write("scene.json", scene);
  expect_refused("equilibrium " + json + " -o " + json, 2, "is an input of this command", folder, 3);
  expect_refused("equilibrium " + own + " -o " + (folder / "rest.toml").string(), 2, "is not a .json file",
                 folder, 3);
  EXPECT_EQ(text_of(own), scene);
  EXPECT_EQ(text_of(json), scene);
}

TEST(Simulate, NamesNoFileForTwoOutputs) {
  const TestFolder folder;
  const std::string scene = folder.write("scene.toml", text_of(samples + "pendulum.toml")),
                    state = folder.write("state.json", R"({"q": [0.3]})"), out = folder / "out.h5";
  expect_refused("simulate " + scene + " -o " + out + " --checkpoint " + (folder / "./out.h5").string(), 2,
                 "is named for two outputs (--output and --checkpoint)", folder, 2);
  expect_refused("simulate " + scene + " --checkpoint " + scene, 2, "is an input of this command", folder, 2);
  expect_refused("equilibrium " + scene + " --state " + state + " -o " + state, 2,
                 "is an input of this command", folder, 2);
  for (const std::string verb :
       {"ik MODEL --motion W.trc -o e.mot --errors ", "id MODEL --motion W.mot -o e.mot --powers "})
    expect_refused(verb + "./e.mot", 2, "is named for two outputs", folder, 2);
}

TEST(Simulate, OptionsWithoutEffectAreRefused) {
  const TestFolder folder;
  const std::string command = "simulate " + samples + "pendulum.toml --end 1 ";
  expect_refused(command + "--reactions", 2, "--reactions: has no effect", folder, 0);
  expect_refused(command + "--checkpoint-every 5", 2, "--checkpoint-every: has no effect", folder, 0);
  for (const char* option : {"--output", "--checkpoint"})  // an unset shell variable
    expect_refused(command + option + " ''", 2, std::string(option) + ": has an empty value", folder, 0);
}

}  // namespace
}  // namespace borelli::simulate_test
