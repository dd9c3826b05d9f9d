// `borelli chart` as a user runs it: what it refuses, and what a stopped chart keeps.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <csignal>
#include <nlohmann/json.hpp>

#include "process/input_file.hpp"
#include "tests/paths.hpp"
#include "tests/pipeline/program_run.hpp"

namespace borelli::chart_verb_test {
namespace {

TEST(WorkPrecision, RunsDuplicatesOnceAndRefusesATinyBudget) {
  const TestFolder folder;
  const std::string chart_it =
      "chart " + test::source_folder() + "/samples/pendulum.toml --end 1 --repeats 1 --json -o ";
  const auto runs = [&](const std::string& options) {
    const ProgramRun run = run_program(chart_it + folder.path().string() + options);
    EXPECT_EQ(run.code, 0) << run.err;
    return nlohmann::json::parse(run.out).at("runs").get<int>();
  };
  const int once = runs(" --methods dop853 --equations recursive --constraints projection");
  EXPECT_EQ(
      runs(" --methods dop853,dop853 --equations recursive,recursive --constraints projection,projection"),
      once);
  const ProgramRun refused = run_program(chart_it + folder.path().string() + " --budget 1e-300");
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.err.find("--budget"), std::string::npos) << refused.err;
}

// The runs kept by a stopped chart belong to its reference's contents, not to that file's name.
TEST(WorkPrecision, SaysWhatIsKeptWhenStopped) {
  const TestFolder folder;
  // dop853 ends at once; euler's ladder takes minutes
  const std::string command = "chart " + test::source_folder() +
                              "/samples/pendulum.toml --methods dop853,euler --equations recursive --end 20 "
                              "--budget 100 --repeats 1 -o " +
                              (folder / "chart").string();
  const ProgramRun stopped = run_program(command, "timeout --foreground --preserve-status -s INT 3");
  EXPECT_EQ(stopped.code, 128 + SIGINT);
  EXPECT_NE(stopped.err.find("the same command continues after the last finished method"), std::string::npos)
      << stopped.err;
  EXPECT_TRUE(std::filesystem::exists(folder / "chart" / "chart.partial.json"));
}

TEST(WorkPrecision, AnotherReferenceOrADamagedFileStartsAgain) {
  const TestFolder folder;
  const std::string sample = test::source_folder() + "/samples/pendulum.toml", reference = folder / "ref.csv";
  const auto refer_to = [&](const std::string& scene) {
    return run_program("simulate " + scene + " --accuracy 1e-9 --end 1 --output-interval 0.05 -o " +
                       reference)
        .code;
  };
  const auto chart_into = [&](const std::string& name, const std::string& before = "") {
    return run_program("chart " + sample +
                           " --end 1 --methods rk4,verlet,euler,rk2 --budget 0.05 --repeats 1 "
                           "--reference-error 1e-9 --reference " +
                           reference + " -o " + (folder / name).string(),
                       before)
        .code;
  };
  ASSERT_EQ(refer_to(sample), 0);
  const std::filesystem::path partial = folder / "broken/chart.partial.json";
  for (int tenths = 1; tenths < 600 && !std::filesystem::exists(partial); ++tenths) {
    ASSERT_FALSE(std::filesystem::exists(folder / "broken/chart.html"));
    chart_into("broken", fmt::format("timeout -s KILL {:.1f}", 0.1 * tenths));
  }
  ASSERT_TRUE(std::filesystem::exists(partial));
  // another motion under the same name: released a degree lower
  std::string lower = read_input_file(sample).value();
  lower.replace(lower.find("value_deg = 90"), 14, "value_deg = 89");
  ASSERT_EQ(refer_to(folder.write("lower.toml", lower)), 0);
  ASSERT_EQ(chart_into("broken"), 0);
  // all runs differ from it by at least the start's difference
  std::istringstream lines(read_input_file(folder / "broken/chart.csv").value());
  int runs = 0;
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line[0] == '#' || line.starts_with("method,")) continue;
    std::vector<std::string> fields(1);
    for (const char c : line)
      if (c == ',')
        fields.emplace_back();
      else
        fields.back() += c;
    EXPECT_TRUE(fields[4] == "0" || std::stod(fields[9]) > 0.01) << line;
    ++runs;
  }
  EXPECT_GT(runs, 20);
  // valid JSON, but not from a chart
  for (const char* spoilt : {"[1,2]", "{\"asked\":3}", "{}", "3", "{\"asked\":"}) {
    folder.write("broken/chart.partial.json", spoilt);
    EXPECT_EQ(chart_into("broken"), 0) << spoilt;
  }
}

}  // namespace
}  // namespace borelli::chart_verb_test
