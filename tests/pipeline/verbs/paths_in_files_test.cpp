// Output files name inputs without their folders, which are often named after patients; --keep-paths keeps
// them.
#include <gtest/gtest.h>

#include <filesystem>
#include <set>

#include "process/input_file.hpp"
#include "tests/pipeline/program_run.hpp"

namespace borelli::paths_in_files_test {
namespace {

namespace fs = std::filesystem;

constexpr const char* patient = "DOE_JANE_19500101";

// What the format holds but the program does not model gives warnings with file and line.
constexpr const char* arm =
    "<mujoco><worldbody><body name='arm'><joint name='elbow' axis='0 1 0' frictionloss='2'/>"
    "<geom size='.1' pos='0 0 -1'/></body></worldbody></mujoco>";

class PathsInFiles : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(folder / patient);
    fs::create_directories(folder / "ROE_JOHN");
  }
  std::string own(const std::string& name) const { return (folder / patient / name).string(); }
  std::string out(const std::string& name) const { return (folder / "out" / name).string(); }

  /// Runs the program, and returns the output files that name a patient's folder.
  std::set<std::string> naming(const std::string& arguments) const {
    fs::remove_all(folder / "out");
    fs::create_directories(folder / "out");
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.code, 0) << run.err;
    std::set<std::string> found;
    int files = 0;
    for (const auto& entry : fs::recursive_directory_iterator(folder / "out")) {
      if (!entry.is_regular_file()) continue;
      ++files;
      const std::string text = read_input_file(entry.path(), any_size).value_or("");
      for (const std::string name : {patient, "ROE_JOHN"})
        if (text.find(name) != std::string::npos) found.insert(entry.path().filename().string());
    }
    EXPECT_GT(files, 0) << arguments;
    return found;
  }

  const TestFolder folder;
};

using Files = std::set<std::string>;

TEST_F(PathsInFiles, PagesOfModelsNameNoFolder) {
  folder.write(std::string(patient) + "/arm.xml", arm);
  folder.write("ROE_JOHN/arm.xml", arm);
  const std::string model = own("arm.xml"), other = (folder / "ROE_JOHN/arm.xml").string(),
                    where = " --end 0.05 -o " + (folder / "out").string();
  const ProgramRun shown = run_program("info " + model);
  EXPECT_NE(shown.err.find(model + ":1"), std::string::npos) << shown.err;  // the terminal shows the path
  for (const std::string& verb : {"chart " + model + " --quick --methods rk4,euler", "economy " + model,
                                  "stability " + model + " " + other + " --methods rk4 --steps 1e-2",
                                  "stability " + model + " --methods rk4 --long 20"}) {
    EXPECT_EQ(naming(verb + where), Files{}) << verb;
  }
  const std::string page = read_input_file(folder / "out/long.html").value();
  EXPECT_NE(page.find("frictionloss of &lt;joint&gt;: at arm.xml:1"), std::string::npos);
}

TEST_F(PathsInFiles, ComparisonsNameNoFolderUnlessAsked) {
  for (const char* place : {patient, "ROE_JOHN"})
    ASSERT_EQ(run_program("phantom --spacing 20 -o " + (folder / place / "p.nrrd").string()).code, 0);
  const std::string compare = "inertia --compare " + own("p_table.json") + " " +
                              (folder / "ROE_JOHN/p_table.json").string() + " -o " + out("c.json") + " -o " +
                              out("c.csv");
  EXPECT_EQ(naming(compare), Files{});
  EXPECT_EQ(naming(compare + " --keep-paths"), (Files{"c.csv", "c.json"}));
}

}  // namespace
}  // namespace borelli::paths_in_files_test
