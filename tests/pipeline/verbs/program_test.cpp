#include <gtest/gtest.h>

#include <regex>
#include <sstream>

#include "tests/pipeline/program_run.hpp"

namespace borelli::program_test {
namespace {

TEST(Program, WithoutArgumentsPrintsItsHelp) {
  const ProgramRun alone = run_program(""), asked = run_program("--help");
  EXPECT_EQ(alone.code, 0);
  EXPECT_EQ(alone.out, asked.out);
  EXPECT_NE(alone.out.find("simulate"), std::string::npos) << alone.out;
  EXPECT_EQ(alone.err, "");
}

TEST(Program, SuggestsTheVerbForAMistypedOne) {
  const ProgramRun near = run_program("simulat scene.toml");
  EXPECT_EQ(near.code, 2);
  EXPECT_EQ(near.err, "borelli: simulat: unknown verb; did you mean simulate?\n");
  const ProgramRun far = run_program("banana");
  EXPECT_EQ(far.code, 2);
  EXPECT_EQ(far.err, "borelli: banana: unknown verb (see borelli --help)\n");
}

TEST(Program, SuggestsTheFlagOrValueForAMistypedOne) {
  const ProgramRun flag = run_program("simulate scene.toml --acuracy 1e-6");
  EXPECT_EQ(flag.code, 2);
  EXPECT_EQ(flag.err,
            "borelli: unknown flag --acuracy; did you mean --accuracy? (see borelli simulate --help)\n");
  EXPECT_EQ(run_program("info a.toml b.toml").err,
            "borelli: unexpected word 'b.toml' (see borelli info --help)\n");
  EXPECT_EQ(
      run_program("phantom -o body.mha --sex malle").err,
      "borelli: --sex: is 'malle', expected one of male, female; did you mean male? (see borelli phantom "
      "--help)\n");
}

TEST(Program, TellsWhatAMissingOptionIs) {
  const ProgramRun folder = run_program("export labels.nrrd --volume scan --dicom");
  EXPECT_EQ(folder.code, 2);
  EXPECT_EQ(folder.err,
            "borelli: --output FOLDER is required: Folder for the files (see borelli export --help)\n");
  EXPECT_EQ(run_program("export -o folder").err,
            "borelli: labels is required: Label map: .nii.gz, .nrrd or .mha (see borelli export --help)\n");
  // a mistyped flag is the nearer cause
  EXPECT_EQ(run_program("export labels.nrrd --outptu folder").err,
            "borelli: unknown flag --outptu; did you mean --output? (see borelli export --help)\n");
}

TEST(Program, RefusesSettingsOfAVideoThatIsNotWritten) {
  const TestFolder folder;
  const std::string scene = test::source_folder() + "/samples/pendulum.toml";
  for (const std::string set : {"size 640x480", "rate 50", "speed 2", "view left", "style wire"}) {
    const std::string flag = "--video-" + set.substr(0, set.find(' '));
    const std::string refusal =
        "borelli: " + flag + ": has no effect without --video, which names the file to write\n";
    for (const std::string& verb : {"simulate " + scene, "run " + scene + " -o " + folder.path().string()}) {
      const ProgramRun run = run_program(verb + " --video-" + set);
      EXPECT_EQ(run.code, 2) << verb << ' ' << set;
      EXPECT_EQ(run.err, refusal);
    }
  }
}

// A user reads names and words, not types and checks.
TEST(Program, TellsValuesAndRangesInWords) {
  const std::string help = run_program("run --help").out;
  const std::string unbroken = std::regex_replace(help, std::regex("\n +"), " ");
  for (const char* words : {"--work-grid NUMBER", "(1 to 6; default: 3)", "--sex male|female", "--skin  "})
    EXPECT_NE(unbroken.find(words), std::string::npos) << words << "\n" << help;
  for (const char* types : {"TEXT", "FLOAT", "INT", "REQUIRED", "Needs:", "POSITIVE"})
    EXPECT_EQ(help.find(types), std::string::npos) << types << "\n" << help;
  std::istringstream lines(help);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100u) << line;
}

}  // namespace
}  // namespace borelli::program_test
