// Chart pages: their content security policy, their data, and (if Chromium is installed) their display.
#include "pipeline/charts/chart_page.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "dynamics/formats/scene_file.hpp"
#include "pipeline/charts/economy_page.hpp"
#include "pipeline/charts/long_runs.hpp"
#include "pipeline/charts/stability_page.hpp"
#include "pipeline/charts/volume_economy.hpp"
#include "pipeline/charts/work_precision_page.hpp"
#include "tests/paths.hpp"

namespace borelli::test::chart_page_test {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

json data_of(const std::string& page) {
  const std::string mark = "id=\"plots\">";
  const auto from = page.find(mark) + mark.size();
  return json::parse(page.substr(from, page.find("</script>", from) - from));
}

TEST(ChartPage, PolicyForbidsLoadingAnything) {
  const std::string page = chart_page(
      {.title = "a", .heading = "b", .warnings = {"w < x"}, .sentences = {"c"}, .body = "<p>d</p>"});
  EXPECT_NE(page.find("Warning: w &lt; x"), std::string::npos);
  const auto policy = page.find("<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none';");
  ASSERT_NE(policy, std::string::npos);
  for (const char* later : {"<style", "<script", "<body"}) {
    ASSERT_NE(page.find(later), std::string::npos) << later;
    EXPECT_LT(policy, page.find(later)) << later;
  }
  EXPECT_EQ(page.find("src="), std::string::npos);
}

TEST(ChartPage, CsvTextIsNeverAFormula) {
  EXPECT_EQ(csv_text("=1+\"1\""), "\"'=1+\"\"1\"\"\"");
  EXPECT_EQ(csv_text("off by -1"), "\"off by -1\"");
}

TEST(ChartPage, HoldsTheDataUnchanged) {
  Plot plot{"t <b>", {"time (s)"}, {"error", true}, {}, {"n"}};
  plot.curves = {{.name = "a</script>",
                  .x = {1, 2, 3},
                  .y = {1e-3, NAN, 1e-5},
                  .marks = true,
                  .tips = {"same", "", "same"},
                  .hollow = {false, false, true}}};
  const std::string page = chart_page({.title = "a", .heading = "b", .plots = {{{{"of", "x"}}, plot}}});
  const json data = data_of(page);
  EXPECT_EQ(data["tips"], json({"same"}));
  const json& curve = data["plots"][0]["curves"][0];
  EXPECT_EQ(curve["name"], "a</script>");
  EXPECT_EQ(curve["y"], json({1e-3, nullptr, 1e-5}));
  EXPECT_EQ(curve["tips"], json({0, nullptr, 0}));
  EXPECT_EQ(curve["hollow"], json({2}));
  EXPECT_NE(page.find("<figure class=\"plot\" data-of=\"x\"><div class=\"static scroll\"><svg"),
            std::string::npos);
}

// Two curves of the first program, then one of each other program in turn, so that a program with many curves
// does not displace the rest.
TEST(ChartPage, ShowsSixCurvesAtFirstOneOfEachProgram) {
  Plot plot{"t", {"x"}, {"y"}, {}};
  const auto add = [&](const std::string& name, const std::string& group, bool faint = false,
                       bool broad = false) {
    plot.curves.push_back({.name = name, .x = {1}, .y = {1}, .faint = faint, .broad = broad, .group = group});
  };
  add("front", "", false, true);
  for (const char* name : {"a1", "a2", "a3", "a4"}) add(name, "a");
  for (const char* name : {"b1", "c1", "d1"}) add(name, std::string(1, name[0]));
  add("b2", "b");
  add("grey", "e", true);
  std::string names;
  const std::vector<bool> shown = shown_at_first(plot);
  for (std::size_t i = 0; i < shown.size(); ++i)
    if (shown[i]) names += plot.curves[i].name + " ";
  EXPECT_EQ(names, "front a1 a2 b1 c1 d1 b2 ");
  const json data = data_of(chart_page({.title = "a", .heading = "b", .plots = {{{}, plot}}}));
  const json& curves = data["plots"][0]["curves"];
  for (const int i : {2, 3, 4}) EXPECT_EQ(curves[i]["colour"], curves[1]["colour"]);
  EXPECT_EQ(curves[8]["colour"], curves[5]["colour"]);
  EXPECT_NE(curves[5]["colour"], curves[1]["colour"]);
  EXPECT_NE(curves[1]["dash"], curves[2]["dash"]);
}

WorkPrecision work_precision_of_two_programs() {
  WorkPrecision chart{.scene = "pendulum"};
  chart.reference.found = true;
  chart.reference.words = "Reference: none.";
  for (int i = 0; i < 9; ++i) chart.variants.push_back({.method = fmt::format("m{}", i)});
  chart.variants.push_back({.method = "other rk4", .other = true});
  for (std::size_t v = 0; v < chart.variants.size(); ++v)
    for (int n = 0; n < 5; ++n) {
      WorkPrecisionPoint p{.variant = v, .setting = std::pow(10., -n), .finished = true, .trusted = n > 0};
      p.seconds = 1e-3 * double(v + 1) * std::pow(2., n) + 1e-7;
      p.evaluations = long(10 * (v + 1)) << n;
      const double error = std::pow(10., -2 * n) / double(v + 1);
      p.errors = {error, 0.5 * error, 0.25 * error, 0, 0};
      chart.points.push_back(p);
    }
  chart.points.push_back({.variant = 0, .setting = 10, .reason = "diverged", .evaluations = 7});
  return chart;
}

Economy economy_of_three_models() {
  Economy economy{.scene = "arm", .tolerance = 0.01, .accuracy = 1e-4, .quantities = {"centres"}};
  economy.models = {{.coordinates = 3, .bodies = 3, .evaluations = 1000, .seconds = 0.01234},
                    {.change = "coordinate 'turn'",
                     .error = 3.2e-4,
                     .worst = "a rather long name of what is the worst of all quantities",
                     .coordinates = 2,
                     .bodies = 2,
                     .evaluations = 800,
                     .seconds = 0.00789}};
  economy.refusals = {{"coordinate 'wrist'", 0.2}};
  return economy;
}

VolumeEconomy volume_economy_of_four_grids() {
  VolumeEconomy economy{.tolerance = 0.01, .curve = "schneider2000"};
  for (const double size : {3., 4., 6., 8.}) {
    VolumeTrial trial{.size = size, .name = fmt::format("{} mm", size), .seconds = 30 / size};
    for (const PartsChoice& choice : parts_choices) {
      trial.errors.emplace_back();
      for (int part = 0; part < choice.count; ++part) {
        trial.errors.back().push_back(
            {.part = fmt::format("part_{}", part), .mass = 1e-3 * (size - 3) * (part + 1)});
      }
    }
    economy.trials.push_back(trial);
  }
  return economy;
}

std::vector<Result<Scene>> scenes_of(const char* file) {
  return {read_scene(source_folder() + "/samples/" + file)};
}

// Opens each page in headless Chromium: chart_page_check.py checks it.
TEST(ChartPage, DrawsItselfInABrowser) {
  if (std::system("python3 --version > /dev/null 2>&1") != 0) GTEST_SKIP() << "needs python3";
  if (std::system("command -v chromium > /dev/null 2>&1") != 0) GTEST_SKIP() << "needs chromium";
  const auto folder = fs::path(testing::TempDir()) / ("chart_page_test_" + std::to_string(::getpid()));
  fs::create_directories(folder);
  const auto write = [&](const std::string& name, const std::string& page) {
    std::ofstream(folder / (name + ".html")) << page;
  };
  write("chart", work_precision_page(work_precision_of_two_programs(), {"A warning about the model."}));
  write("economy", economy_page(economy_of_three_models()));
  write("volume", volume_economy_page(volume_economy_of_four_grids(), "scan"));
  StabilitySettings settings{
      .methods = {"rk4", "verlet", "dopri5", "euler", "rk2", "gauss4", "gauss6", "moreau", "gbs"}};
  settings.steps = {.values = {0.01, 0.03, 0.1, 0.3, 1}, .logarithmic = true};
  settings.tolerances = {.values = {1e-6, 1e-4, 1e-2}, .logarithmic = true};
  settings.lengths = {.least = 50, .most = 500};
  const auto map = stability_map({.scene = "pendulum",
                                  .values = {.values = {1}},
                                  .names = {"pendulum"},
                                  .scenes = scenes_of("pendulum.toml")},
                                 settings);
  ASSERT_TRUE(map) << map.error().message();
  write("stability", stability_page(*map));
  const auto runs =
      long_runs(*scenes_of("pendulum.toml")[0],
                {.methods = {"rk4", "verlet", "euler"}, .steps = 200, .step = 0.01}, [](double) {});
  ASSERT_TRUE(runs) << runs.error().message();
  write("long", long_runs_page(*runs));
  const std::string command =
      "python3 -B " + source_folder() + "/tests/pipeline/charts/chart_page_check.py " + folder.string();
  EXPECT_EQ(std::system(command.c_str()), 0);
  if (!std::getenv("BORELLI_KEEP_PAGES")) fs::remove_all(folder);
}

}  // namespace
}  // namespace borelli::test::chart_page_test
