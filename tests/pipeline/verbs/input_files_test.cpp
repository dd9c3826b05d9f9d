// Messages of every verb about inputs that are no files, and about too much memory.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "tests/pipeline/program_run.hpp"

namespace borelli::input_files_test {
namespace {

const std::string samples = test::source_folder() + "/samples/";

// 2 x 2 x 2 voxels, which no verb reaches
std::string small_scan(const TestFolder& folder) {
  folder.write("scan.raw", std::string(16, '\0'));
  return folder
      .write("scan.mhd",
             "NDims = 3\nBinaryData = True\nElementByteOrderMSB = False\nElementSpacing = 2 2 2\n"
             "DimSize = 2 2 2\nElementType = MET_SHORT\nElementDataFile = scan.raw\n")
      .string();
}

TEST(InputFiles, QuotedTextCannotControlTheTerminal) {
  const ProgramRun run = run_program("info '\x1b[31mred.nii'");
  EXPECT_EQ(run.code, 2);
  EXPECT_EQ(run.err, "borelli: ?[31mred.nii: no such file or folder\n");
}

TEST(InputFiles, PipesAndDevicesAreRefusedAtOnce) {
  const TestFolder folder;
  const std::string scan = small_scan(folder), pendulum = samples + "pendulum.toml ",
                    out = (folder / "out").string();
  const std::string run = "run " + scan + " --quantity hu -o " + out;
  struct Case {
    std::string before, name, after;
  };
  const std::vector<Case> cases{
      {"simulate ", "in.toml", " -o " + out + ".csv"},
      {"simulate ", "in.xml", " -o " + out + ".csv"},
      {"simulate ", "in.urdf", " -o " + out + ".csv"},
      {"simulate " + pendulum + "-o " + out + ".csv --settings ", "in", ""},
      {"evaluate " + pendulum + "--state ", "in.json", ""},
      {"equilibrium " + pendulum + "--state ", "in.json", ""},
      {"chart " + pendulum + "-o " + out + " --reference ", "in.csv", ""},
      {"chart " + pendulum + "-o " + out + " --reference ", "in.h5", ""},
      {"info ", "in.h5", ""},
      {"info ", "in.nii.gz", ""},
      {"segment ", "in", " -o " + out},
      {"segment ", "in.nrrd", " -o " + out},
      {"export ", "in.nii", " -o " + out},
      {"skeleton ", "in.json", " --landmarks " + scan + " -o " + out + ".toml"},
      {"inertia --compare ", "in.json", " " + scan},
      {run + " --landmarks ", "in.json", ""},
      {run + " --landmarks ", "in.fcsv", ""},
      {run + " --labels ", "in.nii", ""},
      {run + " --labels " + scan + " --label-names ", "in.tsv", ""},
      {run + " --labels " + scan + " --label-mapping ", "in.tsv", ""},
  };
  for (const Case& c : cases)
    for (const bool pipe : {true, false}) {
      const std::string path = (folder / c.name).string();
      std::filesystem::remove(path);
      if (pipe)
        ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
      else
        std::filesystem::create_symlink("/dev/zero", path);
      const ProgramRun said = run_program(c.before + path + c.after, "timeout 20");
      EXPECT_EQ(said.code, 2) << c.before << c.name;
      EXPECT_NE(said.err.find("is not a regular file"), std::string::npos)
          << c.before << c.name << ": " << said.err;
    }
}

TEST(MaxMemory, IsReadFromCommandLineAndSettings) {
  const TestFolder folder;
  const std::string scan = small_scan(folder);
  for (const char* wrong : {"4X", "much", "10M"}) {
    const ProgramRun said = run_program("info " + scan + " --max-memory " + wrong);
    EXPECT_EQ(said.code, 2) << wrong;
    EXPECT_NE(said.err.find("--max-memory: '" + std::string(wrong) + "'"), std::string::npos) << said.err;
  }
  EXPECT_EQ(run_program("info " + samples + "pendulum.toml --max-memory 1.5GiB").code, 0);
  const std::string settings = folder.write("s.toml", "max-memory = \"10M\"\n").string();
  const ProgramRun said = run_program("info " + samples + "pendulum.toml --settings " + settings);
  EXPECT_EQ(said.code, 2);
  EXPECT_NE(said.err.find("s.toml:1: max-memory: '10M' is too little"), std::string::npos) << said.err;
}

// Grids of more voxels than fit, each refused with its size before memory is allocated.
TEST(MaxMemory, LimitsOfTheShellAreNamed) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "the sanitizer maps more memory than this";
#endif
  const TestFolder folder;
  const std::string phantom = "phantom --spacing 1 -o " + (folder / "p.nii.gz").string();
  const ProgramRun run = run_program(phantom, "ulimit -v 400000; ");
  EXPECT_EQ(run.code, 1) << run.err;
  EXPECT_NE(run.err.find("ulimit)"), std::string::npos) << run.err;
  EXPECT_EQ(run.err.find("--max-memory"), std::string::npos) << run.err;
  EXPECT_EQ(folder.count(), 0);
}

TEST(MaxMemory, LargerRequestsAreRefusedAtOnce) {
  const TestFolder folder;
  const std::string out = (folder / "out").string();
  ProgramRun said = run_program("phantom --spacing 0.2 --max-memory 8G -o " + out + ".nii.gz", "timeout 30");
  EXPECT_EQ(said.code, 1);
  EXPECT_NE(said.err.find("voxels needs"), std::string::npos) << said.err;
  EXPECT_NE(said.err.find("--max-memory"), std::string::npos) << said.err;
  said = run_program("phantom --spacing 2 --max-memory 100M -o " + out + ".nii.gz", "timeout 30");
  EXPECT_EQ(said.code, 1);
  EXPECT_NE(said.err.find("100 MB may be used (--max-memory)"), std::string::npos) << said.err;

  ASSERT_EQ(run_program("phantom --spacing 8 -o " + out + ".nii.gz").code, 0);
  said = run_program("segment " + out + ".nii.gz --quantity hu --work-grid 1 --max-memory 1G -o " + out,
                     "timeout 30");
  EXPECT_EQ(said.code, 1);
  EXPECT_NE(said.err.find("a work grid of "), std::string::npos) << said.err;
  EXPECT_NE(said.err.find("1 GB may be used (--max-memory)"), std::string::npos) << said.err;
}

}  // namespace
}  // namespace borelli::input_files_test
