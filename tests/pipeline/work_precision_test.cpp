// The chart of cost against error: errors against closed forms.
#include "pipeline/charts/work_precision_page.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "dynamics/formats/scene_file.hpp"
#include "dynamics/run/simulate.hpp"
#include "tests/paths.hpp"
#include "tests/pipeline/program_run.hpp"
#include "tests/pipeline/work_precision_made.hpp"

namespace borelli::work_precision_test {
namespace {

double largest_error(const Scene& scene, const WorkPrecisionPoint& p, const std::string& method,
                     int outputs) {
  const System system = compile(scene).value();
  SimulationSettings how = scene.simulation;
  how.method = method;
  how.step = p.setting;
  // steps over several outputs are compared at their ends
  how.output_interval = std::max(how.end_time / outputs, p.setting);
  const Trajectory t = simulate(system, system.initial, how).value();
  double largest = 0;
  for (std::size_t i = 0; i < t.times.size(); ++i)
    largest = std::max(largest, std::abs(t.q(i, 0) - std::cos(2 * t.times[i])));
  return largest / system.length;
}

TEST(WorkPrecision, ErrorsMatchTheClosedForm) {
  const Scene scene = oscillator();
  const WorkPrecision chart = work_precision(scene, measured_once({"rk4", "verlet"}, 0.02)).value();
  ASSERT_TRUE(chart.reference.found);
  EXPECT_LT(chart.reference.position, 1e-11);
  EXPECT_DOUBLE_EQ(chart.reference.horizon, 5);
  ASSERT_EQ(chart.variants.size(), 2u);  // without constraints there is one treatment
  std::vector<double> of_rk4;
  for (const WorkPrecisionPoint& p : chart.points) {
    ASSERT_TRUE(p.finished) << p.reason;
    EXPECT_NEAR(p.errors.position,
                largest_error(scene, p, chart.variants[p.variant].method, WorkPrecisionSettings{}.outputs),
                10 * chart.reference.position + 1e-14);
    EXPECT_EQ(p.errors.orientation, 0);  // no rotation
    if (p.variant == 0) of_rk4.push_back(p.errors.position);
  }
  ASSERT_GE(of_rk4.size(), 6u);
  EXPECT_NEAR(std::log2(of_rk4[4] / of_rk4[5]), 4, 0.2);
  EXPECT_DOUBLE_EQ(chart.points[0].setting, 4 * 0.25);  // the coarsest: over four outputs
}

// The closed form as a reference file written by a user.
TEST(WorkPrecision, AcceptsAGivenReference) {
  const TestFolder folder;
  const Scene scene = oscillator();
  const std::string solid = scene.solids[0].name;
  std::string text = fmt::format(
      "# x = cos 2t\ntime [s],\"note, of nothing\",position {0}.x [m],position {0}.y [m],position {0}.z [m],"
      "orientation {0}.w [1],orientation {0}.x [1],orientation {0}.y [1],orientation {0}.z [1]\n",
      solid);
  std::string late = text;
  for (int i = 0; i <= 40; ++i) {
    const double t = 0.125 * i;  // every second row is an output
    const std::string row = fmt::format("{:.17g},-,{:.17g},0,0,1,0,0,0\n", t, std::cos(2 * t));
    text += row;
    if (i != 20) late += row;
  }
  const std::string file = folder.write("closed.csv", text);
  WorkPrecisionSettings settings = measured_once({"rk4", "dop853"}, 0.02);
  settings.reference = read_reference(file, {solid}).value();
  settings.reference->error = 1e-15;
  const WorkPrecision chart = work_precision(scene, settings).value();
  EXPECT_EQ(chart.reference.runs, std::vector<std::string>{"closed.csv"});
  EXPECT_EQ(chart.reference.position, 1e-15);
  ASSERT_GT(chart.points.size(), 6u);
  for (const WorkPrecisionPoint& p : chart.points) {
    if (p.variant != 0) continue;
    EXPECT_NEAR(p.errors.position, largest_error(scene, p, "rk4", settings.outputs), 1e-14);
  }

  settings.reference = read_reference(folder.write("late.csv", late), {solid}).value();
  const auto refused = work_precision(scene, settings);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message().find("late.csv: has no row at t = 2.5 s"), std::string::npos)
      << refused.error().message();
  const auto without = [&](const std::string& content, const std::vector<std::string>& solids) {
    const auto read = read_reference(folder.write("bad.csv", content), solids);
    return read ? std::string("read") : read.error().message();
  };
  EXPECT_NE(without(text, {"other"}).find(":2: has no column 'position other.x [m]'"), std::string::npos);
  EXPECT_NE(without(text + "6,-,x,0,0,1,0,0,0\n", {solid}).find(":44: has no number in column 3"),
            std::string::npos);
  EXPECT_NE(without(text + "6,-,1,0,0,1,1,0,0\n", {solid}).find("not of unit length"), std::string::npos);
  EXPECT_NE(without(text + "5,-,1,0,0,1,0,0,0\n", {solid}).find("times do not increase"), std::string::npos);

  // as a user would: a table from `simulate`, exact to about 1e-10
  const std::string sample = test::source_folder() + "/samples/pendulum.toml", out = folder / "run.csv";
  ASSERT_EQ(
      run_program("simulate " + sample + " --accuracy 1e-9 --end 1 --output-interval 0.05 -o " + out).code,
      0);
  const std::string chart_it = "chart " + sample +
                               " --end 1 --methods rk4 --budget 0.005 --repeats 1 --json -o " +
                               folder.path().string();
  const ProgramRun run = run_program(chart_it + " --reference " + out + " --reference-error 1e-9");
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_NE(run.out.find("run.csv"), std::string::npos);
  EXPECT_EQ(run_program(chart_it + " --reference-error 1e-9").code, 2);
  EXPECT_EQ(run_program(chart_it + " --reference " + (folder / "none.csv").string()).code, 2);
}

// The same oscillator by a fictitious program: its closed form plus an error of its step squared.
TEST(WorkPrecision, MeasuresOtherProgramsByTheSameErrors) {
  const OtherMethod other{"Other exact", false,
                          [](double step, const std::vector<double>& times,
                             const std::function<bool()>& go_on) -> Result<OtherRun> {
                            if (step > 0.6) return failure("", "diverged");
                            EXPECT_TRUE(go_on());
                            OtherRun out{.poses = {}, .seconds = 1e-3 / step, .evaluations = long(5 / step)};
                            for (const double t : times)
                              out.poses.push_back({.p = {std::cos(2 * t) + step * step, 0, 0}});
                            return out;
                          }};
  WorkPrecisionSettings settings = measured_once({"dop853"}, 0.05);
  const Scene scene = oscillator();
  const double length = compile(scene)->length;
  const WorkPrecision chart = work_precision(scene, settings, {}, {other}).value();
  ASSERT_EQ(chart.variants.size(), 2u);
  EXPECT_TRUE(chart.variants[1].other);
  std::size_t count = 0;
  for (const WorkPrecisionPoint& p : chart.points) {
    if (p.variant == 0) continue;
    ++count;
    EXPECT_EQ(p.finished, p.setting < 0.6);
    if (!p.finished) continue;
    EXPECT_NEAR(p.errors.position, p.setting * p.setting / length, 1e-10);
    EXPECT_EQ(p.errors.orientation, 0);
    EXPECT_EQ(p.seconds, 1e-3 / p.setting);
  }
  EXPECT_GE(count, 6u);  // from 1 s, which failed, to 0.02 s, which used up the budget
  // only our methods are recommended; each program has its own front
  for (const auto& [digits, p] : recommendations(chart)) EXPECT_EQ(p->variant, 0u);
  const auto rows = front_against_front(chart);
  ASSERT_EQ(rows.size(), 10u);
  ASSERT_TRUE(rows[0].other);
  EXPECT_LE(rows[0].other->errors.position, 0.1);
  EXPECT_FALSE(rows[9].other);
  ASSERT_TRUE(rows[9].ours);
  EXPECT_LE(rows[9].ours->errors.position, 1e-10);
  EXPECT_NE(front_table(chart).find("Other exact, step 0.25 s"), std::string::npos);
}

TEST(WorkPrecision, MissingImpactsCountAsErrors) {
  const std::vector<double> reference{1, 2, 3};
  EXPECT_DOUBLE_EQ(impact_time_error({1, 2.25, 3}, reference, 0, 5), 0.25);
  EXPECT_DOUBLE_EQ(impact_time_error({1, 2}, reference, 0, 5), 1);            // the third is missed
  EXPECT_DOUBLE_EQ(impact_time_error({1, 2, 3, 4.5}, reference, 0, 5), 1.5);  // a fourth that does not exist
  EXPECT_DOUBLE_EQ(impact_time_error({}, reference, 0.5, 5), 2.5);
  // impacts beyond the end do not count, but may match one before it
  EXPECT_DOUBLE_EQ(impact_time_error({1, 2.25, 3}, reference, 0, 2), 0.25);
  EXPECT_DOUBLE_EQ(impact_time_error({1, 2, 4.5}, reference, 0, 2), 0);
  EXPECT_TRUE(std::isnan(impact_time_error({}, {}, 0, 5)));
}

TEST(WorkPrecision, ErrorsAndEvaluationsAreReproducible) {
  const Scene scene = read_scene(test::source_folder() + "/samples/double_pendulum.toml").value();
  WorkPrecisionSettings settings;
  settings.methods = {"dop853", "gbs"};
  settings.repeats = 1;
  settings.budget = 10;  // no ladder ends by the budget
  const WorkPrecision a = work_precision(scene, settings).value(),
                      b = work_precision(scene, settings).value();
  ASSERT_EQ(a.points.size(), b.points.size());
  EXPECT_GT(a.points.size(), 40u);
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    EXPECT_EQ(a.points[i].evaluations, b.points[i].evaluations);
    EXPECT_EQ(a.points[i].errors.position, b.points[i].errors.position);
    EXPECT_EQ(a.points[i].errors.orientation, b.points[i].errors.orientation);
    EXPECT_EQ(a.points[i].errors.energy, b.points[i].errors.energy);
  }
}

TEST(WorkPrecision, FinerLaddersContainTheCoarseTolerances) {
  const Scene scene = read_scene(test::source_folder() + "/samples/double_pendulum.toml").value();
  WorkPrecisionSettings settings;
  settings.methods = {"gauss16", "rk4"};
  settings.equations = {Equations::recursive};
  settings.repeats = 1;
  const WorkPrecision coarse = work_precision(scene, settings).value();
  settings.per_decade = 2;
  const WorkPrecision fine = work_precision(scene, settings).value();
  const auto of = [](const WorkPrecision& chart, std::size_t method) {
    std::vector<WorkPrecisionPoint> points;
    for (const auto& point : chart.points)
      if (point.variant == method) points.push_back(point);
    return points;
  };
  for (const std::size_t method : {0, 1}) {  // twice as many tolerances, equally many steps
    const auto few = of(coarse, method), many = of(fine, method);
    const std::size_t times = method == 0 ? 2 : 1, rungs = method == 0 ? 10 : 5;
    ASSERT_GE(few.size(), rungs);
    ASSERT_GT(many.size(), times * (rungs - 1));
    for (std::size_t i = 0; i < rungs; ++i) {
      EXPECT_EQ(few[i].setting, many[times * i].setting);
      EXPECT_EQ(few[i].evaluations, many[times * i].evaluations);
      EXPECT_EQ(few[i].errors.position, many[times * i].errors.position);
      if (method == 0 && i > 0) {
        EXPECT_DOUBLE_EQ(many[2 * i - 1].setting, std::sqrt(few[i - 1].setting * few[i].setting));
      }
    }
  }
  settings.per_decade = 0;
  EXPECT_FALSE(work_precision(scene, settings));
}

// A ball that falls from 1 m and rebounds with half its speed: times of impacts, momentum between them and
// energy in closed form. Methods are judged by these, also with a given reference.
TEST(WorkPrecision, JudgesContactScenesByContactLaws) {
  const Scene scene = read_scene(test::source_folder() + "/samples/bouncing_ball.toml").value();
  WorkPrecisionSettings settings = measured_once({"dop853", "moreau"}, 0.05);
  settings.constraints = {ConstraintTreatment::projection};
  const WorkPrecision chart = work_precision(scene, settings).value();
  ASSERT_TRUE(chart.reference.found) << chart.reference.words;
  int judged = 0;
  for (const WorkPrecisionPoint& p : chart.points) {
    if (!p.finished || !std::isfinite(p.errors.position)) continue;
    const double error = judged_error(chart, p);
    for (const double part : {p.errors.impacts / chart.duration, p.errors.momentum, p.errors.energy})
      EXPECT_TRUE(std::isnan(part) || error >= part);
    // time stepping does not locate impacts
    EXPECT_EQ(std::isnan(p.errors.impacts), chart.variants[p.variant].method == "moreau");
    ++judged;
  }
  EXPECT_GT(judged, 5);
  const auto plots = work_precision_plots(chart);
  EXPECT_EQ(plots[0].first, "contacts_time");
  EXPECT_EQ(plots[0].second.curves[0].name, "front of trusted runs");
  ASSERT_FALSE(recommendations(chart).empty());

  // poses of a run as a user's reference: impacts and momentum are still judged
  const System system = compile(scene).value();
  SimulationSettings how = scene.simulation;
  how.method = "dop853";
  how.tolerance = 1e-12;
  how.output_interval = (how.end_time - system.initial.t) / settings.outputs;
  const Trajectory t = simulate(system, system.initial, how).value();
  settings.reference = GivenReference{.name = "poses", .error = 1e-9, .times = t.times, .poses = t.poses};
  const WorkPrecision with_poses = work_precision(scene, settings).value();
  bool impacts = false, momentum = false;
  for (const WorkPrecisionPoint& p : with_poses.points)
    impacts |= std::isfinite(p.errors.impacts), momentum |= std::isfinite(p.errors.momentum);
  EXPECT_TRUE(impacts && momentum) << with_poses.reference.words;
}

TEST(WorkPrecision, DoesNotRepeatKnownRuns) {
  WorkPrecisionSettings settings = measured_once({"rk4", "dop853"}, 0.02);
  WorkPrecisionObserver observer;
  observer.known = {made(7, 1e-3)};
  observer.known[0].setting = 1;  // the coarsest step spans four of twenty outputs in 5 s
  std::size_t ends = 0;
  observer.ladder_ends = [&](const auto& points) {
    ++ends;
    EXPECT_EQ(points[0].seconds, 7);
    return Result<void>();
  };
  const WorkPrecision chart = work_precision(oscillator(), settings, observer).value();
  EXPECT_EQ(ends, 6u);  // two ladders, three shares of the budget
  EXPECT_EQ(
      std::count_if(chart.points.begin(), chart.points.end(), [](const auto& p) { return p.variant == 0; }),
      1);
  EXPECT_GT(chart.points.size(), 5u);
}

// Coarse charts hold the coarsest runs of every method in the order of the whole chart; only the last run of
// a ladder may be long.
TEST(WorkPrecision, CoarseChartsOfAllMethodsComeFirst) {
  const WorkPrecisionSettings settings = measured_once({"rk4", "dop853", "gauss4"}, 0.05);
  std::vector<WorkPrecision> coarse;
  WorkPrecisionObserver observer;
  observer.round_ends = [&](const WorkPrecision& chart) {
    coarse.push_back(chart);
    return Result<void>();
  };
  const WorkPrecision whole = work_precision(oscillator(), settings, observer).value();
  const auto ladder = [](const WorkPrecision& chart, std::size_t variant) {
    std::vector<WorkPrecisionPoint> out;
    for (const WorkPrecisionPoint& p : chart.points)
      if (p.variant == variant) out.push_back(p);
    return out;
  };
  ASSERT_EQ(coarse.size(), 2u);
  EXPECT_LT(coarse[0].share, coarse[1].share);
  EXPECT_LT(coarse[1].share, 1);
  EXPECT_EQ(whole.share, 1);
  EXPECT_LT(coarse[0].points.size(), whole.points.size());
  for (const WorkPrecision& chart : coarse)
    for (std::size_t variant = 0; variant < whole.variants.size(); ++variant) {
      const auto early = ladder(chart, variant), all = ladder(whole, variant);
      ASSERT_FALSE(early.empty()) << name_of(whole.variants[variant]);
      ASSERT_LE(early.size(), all.size());
      for (std::size_t i = 0; i < early.size(); ++i) {
        EXPECT_EQ(early[i].setting, all[i].setting);
        EXPECT_EQ(early[i].seconds, all[i].seconds);  // the same run
        if (i + 1 < early.size()) {
          EXPECT_LE(early[i].seconds, chart.share * settings.budget);
        }
      }
    }
  EXPECT_NE(work_precision_page(coarse[0]).find("finer ones follow"), std::string::npos);
  EXPECT_EQ(work_precision_page(whole).find("finer ones follow"), std::string::npos);
}

}  // namespace
}  // namespace borelli::work_precision_test
