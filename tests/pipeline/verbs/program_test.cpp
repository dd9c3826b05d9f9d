#include <gtest/gtest.h>

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

}  // namespace
}  // namespace borelli::program_test
