// The page of a chart: the front against its definition, drawings, failed runs, CSV.
#include "pipeline/charts/work_precision_page.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "dynamics/formats/scene_file.hpp"
#include "tests/paths.hpp"
#include "tests/pipeline/work_precision_made.hpp"

namespace borelli::work_precision_test {
namespace {

TEST(WorkPrecision, FrontContainsUndominatedRuns) {
  WorkPrecision chart;
  chart.variants = {{"dop853"}};
  chart.reference.found = true;
  chart.reference.position = 1e-10;
  chart.points = {made(1, 1e-2),  made(2, 1e-4),          made(3, 1e-3), made(4, 1e-6),
                  made(5, 1e-12), made(0.5, 1e-5, false), made(6, 1e-13)};
  chart.points.push_back({.variant = 0, .setting = 1, .reason = "it fell"});
  const auto front = pareto_front(
      chart, [](const auto& p) { return p.seconds; }, [](const auto& p) { return p.errors.position; },
      reference_floor(chart));
  // the second beats the third; the fifth is the cheapest that is finer than the reference; the sixth is not
  // trusted
  ASSERT_EQ(front.size(), 4u);
  EXPECT_EQ(front[3], &chart.points[4]);
  EXPECT_EQ(front[0], &chart.points[0]);
  EXPECT_EQ(front[1], &chart.points[1]);
  EXPECT_EQ(front[2], &chart.points[3]);
  const auto take = recommendations(chart);
  ASSERT_EQ(take.size(), 9u);                  // a run finer than the reference counts as 1e-9
  EXPECT_EQ(take[0].point, &chart.points[0]);  // 1e-1, 1e-2
  EXPECT_EQ(take[1].point, &chart.points[0]);
  EXPECT_EQ(take[2].point, &chart.points[1]);  // 1e-3, 1e-4
  EXPECT_EQ(take[5].point, &chart.points[3]);  // 1e-6
  EXPECT_EQ(take[8].point, &chart.points[4]);
}

TEST(WorkPrecision, PageAtRestExplainsMissingDrawings) {
  Scene scene = oscillator();
  scene.efforts.clear();
  scene.gravity.setZero();
  WorkPrecisionSettings settings;
  settings.methods = {"rk4", "dop853"};
  settings.repeats = 1;
  const WorkPrecision chart = work_precision(scene, settings).value();
  EXPECT_TRUE(work_precision_plots(chart).empty());
  EXPECT_NE(why_no_drawing(chart).find("at rest"), std::string::npos);
  EXPECT_NE(work_precision_page(chart).find(why_no_drawing(chart)), std::string::npos);
  WorkPrecision none;
  none.variants = {{"rk4"}};
  none.points = {{.reason = "fell"}};
  EXPECT_NE(why_no_drawing(none).find("no run finished"), std::string::npos);
  EXPECT_TRUE(why_no_drawing(work_precision(oscillator(), settings).value()).empty());
}

TEST(WorkPrecision, NamesRunsOnTheFront) {
  WorkPrecision chart;
  chart.scene = "x";
  chart.reference.found = true;
  for (int i = 0; i < 30; ++i) chart.variants.push_back({"m" + std::to_string(i)});
  for (int i = 0; i < 30; ++i) {  // the last twelve are on the front, the others farther and farther away
    WorkPrecisionPoint p = made(i < 18 ? 100 + i : i, i < 18 ? 1e-2 : std::pow(10., -0.5 * (i - 16)));
    p.variant = std::size_t(i);
    chart.points.push_back(p);
  }
  const Plot plot = work_precision_plots(chart)[0].second;
  std::vector<std::size_t> numbers;
  for (const Curve& curve : plot.curves) {
    const bool on_front = curve.name.starts_with("m") && std::stoi(curve.name.substr(1)) >= 18;
    EXPECT_FALSE(on_front && curve.faint) << curve.name;
    if (curve.faint) numbers.push_back(curve.number);
  }
  ASSERT_EQ(numbers.size(), 18u);
  for (std::size_t i = 0; i < numbers.size(); ++i) EXPECT_EQ(numbers[i], i + 1);
  EXPECT_NE(svg(plot).find("by number: 1 m0, 2 m1"), std::string::npos);
}

TEST(WorkPrecision, ListsFailedRunsWithTheirReason) {
  const Scene scene = read_scene(test::source_folder() + "/samples/painleve_rod.toml").value();
  WorkPrecisionSettings settings = measured_once({"dop853", "rk4"}, 0.1);
  settings.constraints = {ConstraintTreatment::projection};
  const WorkPrecision chart = work_precision(scene, settings).value();
  ASSERT_FALSE(chart.points.empty());
  for (const WorkPrecisionPoint& p : chart.points) {
    EXPECT_FALSE(p.trusted);
    EXPECT_FALSE(p.reason.empty());
  }
  EXPECT_TRUE(recommendations(chart).empty());
  const std::string page = work_precision_page(chart);
  EXPECT_NE(page.find("Runs that did not finish"), std::string::npos);
  EXPECT_NE(page.find("Painlev"), std::string::npos);
}

// Runs by rk4 with steps of 1 s diverge: drawings show them at the edge.
TEST(WorkPrecision, FailedRunsCountTheirCost) {
  const Scene scene = read_scene(test::source_folder() + "/samples/double_pendulum.toml").value();
  const WorkPrecision chart = work_precision(scene, measured_once({"dop853", "rk4"}, 0.1)).value();
  std::vector<double> failed;
  for (const WorkPrecisionPoint& p : chart.points)
    if (!p.finished && p.reason.find("took more than") == std::string::npos)
      failed.push_back(double(p.evaluations));
  ASSERT_FALSE(failed.empty());
  EXPECT_GT(*std::min_element(failed.begin(), failed.end()), 0);
  for (const auto& [name, plot] : work_precision_plots(chart)) {
    if (!name.ends_with("_evaluations")) continue;
    for (const double evaluations : failed)
      EXPECT_TRUE(std::any_of(plot.edge.begin(), plot.edge.end(),
                              [&](const auto& cross) { return cross.x == evaluations; }))
          << name << ' ' << evaluations;
  }
}

TEST(WorkPrecision, CsvHasALinePerRun) {
  WorkPrecision chart;
  chart.scene = "x";
  chart.variants = {{"dop853"}};
  chart.points = {made(1, 1e-2), {.variant = 0, .setting = 1, .reason = "it \"fell\", so"}};
  const std::string text = work_precision_csv(chart);
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 4);
  EXPECT_NE(text.find("\"it \"\"fell\"\", so\""), std::string::npos);
  EXPECT_NE(text.find("dop853,recursive,none,0.001"), std::string::npos);
}

}  // namespace
}  // namespace borelli::work_precision_test
