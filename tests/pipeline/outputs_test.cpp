// Every verb that writes refuses an output that cannot be written before it reads or computes anything: one
// sentence, exit code 1 or 2, and nothing left. The inputs named here do not exist, so that a verb that
// looked at them first would say so instead.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>

#include "tests/pipeline/program_run.hpp"

namespace borelli {
namespace {

namespace fs = std::filesystem;

struct Writer {
  const char* verb;
  const char* arguments;  // %s: where the output goes
  const char* file;       // what of it is written, for a folder in its place; "" for a verb that writes many
};

const Writer writers[]{{"segment", "segment /none.nii --quantity hu -o %s", "/segmentation.json"},
                       {"inertia", "inertia --volume /none.nii --labels /none.nii -o %s/t.csv", "/t.csv"},
                       {"skeleton", "skeleton /none.json --landmarks /none.json -o %s/s.toml", "/s.toml"},
                       {"simulate", "simulate /none.toml -o %s/m.h5", "/m.h5"},
                       {"export", "export /none.nii -o %s", ""},
                       {"phantom", "phantom --spacing 0.2 -o %s/p.nrrd", "/p_labels.tsv"},
                       {"chart", "chart /none.toml -o %s", "/chart.csv"},
                       {"economy", "economy /none.toml -o %s", "/scene.toml"},
                       {"stability", "stability /none.toml -o %s", "/stability.html"},
                       {"figures", "figures -o %s", ""}};

std::string filled(std::string text, const fs::path& place) {
  return text.replace(text.find("%s"), 2, place.string());
}

void expect_refused(const std::string& arguments, const std::string& said, const TestFolder& folder,
                    const std::string& before = "") {
  const int files = folder.count();
  const ProgramRun run = run_program(arguments, before);
  EXPECT_TRUE(run.code == 1 || run.code == 2) << arguments << " ended with " << run.code;
  EXPECT_TRUE(run.err.starts_with("borelli: ")) << run.err;
  EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  EXPECT_NE(run.err.find(said), std::string::npos) << arguments << "\n" << run.err;
  EXPECT_EQ(run.out, "") << arguments;
  EXPECT_EQ(folder.count(), files) << arguments;
}

TEST(Outputs, FileInTheWayIsReportedBeforeTheWork) {
  for (const Writer& writer : writers) {
    const TestFolder folder;
    folder.write("file", "");
    expect_refused(filled(writer.arguments, folder / "file/below"), "file is not a folder", folder);
    fs::create_symlink(folder / "nowhere/at/all", folder / "link");  // exists, and can be no folder
    expect_refused(filled(writer.arguments, folder / "link/below"), "cannot be created", folder);
    if (*writer.file == '\0') continue;
    fs::create_directories(folder.path() / (std::string("out") + writer.file));
    expect_refused(filled(writer.arguments, folder / "out"), "is a folder; name a file", folder);
  }
}

// Of verbs that write many files: each that a run leaves, in turn, is a folder before the next.
TEST(Outputs, FolderInPlaceOfAFileIsReportedBeforeTheWork) {
  const std::string samples = test::source_folder() + "/samples/";
  const std::string quick = " --methods rk4,euler";
  for (const std::string& of :
       {"chart " + samples + "a01.toml --end 0.1 --budget 1e-4 --equations recursive" + quick,
        "economy " + samples + "double_pendulum.toml --end 0.01",
        "stability " + samples + "pendulum.toml --end 0.1 --steps 1e-2" + quick,
        "stability " + samples + "pendulum.toml --long 100" + quick}) {
    const TestFolder folder;
    const fs::path out = folder / "out";
    ASSERT_EQ(run_program(of + " -o " + out.string()).code, 0) << of;
    std::vector<fs::path> made;
    for (const auto& entry : fs::directory_iterator(out)) made.push_back(entry.path());
    EXPECT_GT(made.size(), 4u);
    for (const fs::path& file : made) {
      fs::remove_all(out);
      fs::create_directories(file);
      expect_refused(of + " -o " + out.string(), file.string() + ": is a folder; name a file", folder);
    }
  }
}

// /proc makes no folder for anybody, root included
TEST(Outputs, FolderThatCannotBeCreatedIsReportedBeforeTheWork) {
  if (!fs::exists("/proc/self")) GTEST_SKIP() << "no /proc here";
  const TestFolder folder;
  for (const Writer& writer : writers)
    expect_refused(filled(writer.arguments, "/proc/borelli/below"), "/proc/borelli cannot be created",
                   folder);
}

TEST(Outputs, ForeignFolderIsReportedBeforeTheWork) {
  const TestFolder folder;
  std::string before;
  if (geteuid() == 0) {  // whom permissions do not stop; so the program runs as nobody
    before = "setpriv --reuid=65534 --regid=65534 --clear-groups";
    if (run_program("--version", before).code != 0) GTEST_SKIP() << "the program cannot run as another user";
  }
  fs::create_directories(folder / "theirs");
  fs::permissions(folder / "theirs", fs::perms::owner_read | fs::perms::owner_exec | fs::perms::others_read |
                                         fs::perms::others_exec);
  for (const Writer& writer : writers) {
    expect_refused(filled(writer.arguments, folder / "theirs"), "theirs: Permission denied", folder, before);
    expect_refused(filled(writer.arguments, folder / "theirs/below"), "Permission denied", folder, before);
  }
  fs::create_directories(folder / "theirs/run");
  fs::permissions(folder / "theirs/run", fs::perms::owner_read | fs::perms::owner_exec |
                                             fs::perms::others_read | fs::perms::others_exec);
  expect_refused("report " + (folder / "theirs/run").string(), "report.html: cannot be written", folder,
                 before);
  fs::permissions(folder / "theirs/run", fs::perms::owner_all);
  fs::permissions(folder / "theirs", fs::perms::owner_all);
}

TEST(Outputs, CheckLeavesNothingBehind) {
  const TestFolder folder;
  for (const Writer& writer : writers) {
    if (std::string(writer.verb) == "figures" || std::string(writer.verb) == "phantom")
      continue;  // need no input
    expect_refused(filled(writer.arguments, folder / "new/deep"), "/none.", folder);
    EXPECT_FALSE(fs::exists(folder / "new")) << writer.verb;
  }
}

}  // namespace
}  // namespace borelli
