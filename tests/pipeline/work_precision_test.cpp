// The chart of cost against error: errors against closed forms, the front against its definition.
#include "pipeline/charts/work_precision_page.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <nlohmann/json.hpp>
#include <sstream>

#include "dynamics/formats/scene_file.hpp"
#include "dynamics/run/simulate.hpp"
#include "process/input_file.hpp"
#include "tests/paths.hpp"
#include "tests/pipeline/program_run.hpp"

namespace borelli::work_precision_test {
namespace {

// 1 kg on a spring of 4 N/m without gravity, released 1 m from rest: x = cos 2t.
Scene oscillator() {
  Scene scene;
  scene.name = "oscillator";
  scene.gravity.setZero();
  Solid mass;
  mass.name = "mass";
  mass.switches = {{.kind = Translation{Eigen::Vector3d::UnitX()},
                    .coordinate = "x",
                    .motion = {},
                    .q = {1},
                    .v = {0},
                    .ranges = {}}};
  mass.inertials = {{1, {0.5, 0, 0}, Eigen::Matrix3d::Identity()}};
  scene.solids = {mass};
  scene.efforts = {{"spring", CoordinateSpring{{"x"}, 4, 0, 0}}};
  scene.simulation.end_time = 5;
  return scene;
}

/// Settings with these methods, each run once, with at most `budget` seconds per run.
WorkPrecisionSettings measured_once(std::vector<std::string> methods,
                                    double budget = WorkPrecisionSettings{}.budget) {
  WorkPrecisionSettings out;
  out.methods = std::move(methods);
  out.equations = {Equations::recursive};
  out.repeats = 1;
  out.budget = budget;
  return out;
}

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

WorkPrecisionPoint made(double seconds, double error, bool trusted = true) {
  WorkPrecisionPoint p{.variant = 0, .setting = 1e-3, .finished = true, .trusted = trusted};
  p.seconds = seconds;
  p.evaluations = long(1e6 * seconds);
  p.errors = {error, 0.5 * error, error, 0, 0};
  return p;
}

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

TEST(WorkPrecision, ComparesNothingBeyondChaos) {
  Scene scene = read_scene(test::source_folder() + "/samples/pendulum_5.toml").value();
  scene.simulation.end_time = 40;
  const WorkPrecision chart = work_precision(scene, measured_once({"dop853"})).value();
  ASSERT_TRUE(chart.reference.found);
  EXPECT_LT(chart.reference.horizon, 40);
  EXPECT_NE(chart.reference.words.find("as in chaos"), std::string::npos) << chart.reference.words;
  // up to the horizon, fine runs agree with the reference
  double best = 1;
  for (const WorkPrecisionPoint& p : chart.points) best = std::min(best, p.errors.position);
  EXPECT_LT(best, 1e-6);
}

TEST(WorkPrecision, EarlyDivergenceMovesTheOutputs) {
  Scene scene = read_scene(test::source_folder() + "/samples/pendulum_5.toml").value();
  WorkPrecisionSettings settings = measured_once({"dop853"});
  for (const double end : {200., 600.}) {  // one or two outputs remain, or none
    scene.simulation.end_time = end;
    settings.outputs = 10, settings.budget = 0.05;
    const WorkPrecision chart = work_precision(scene, settings).value();
    ASSERT_TRUE(chart.reference.found) << chart.reference.words;
    EXPECT_NE(chart.reference.words.find("diverge too early, as in chaos"), std::string::npos)
        << chart.reference.words;
    EXPECT_LT(chart.reference.horizon, 60);
    EXPECT_NEAR(chart.duration, chart.reference.horizon, 1e-9);
    // steps are as long as the time between outputs, and all outputs are compared
    EXPECT_TRUE(fastest_within(chart, 1e-3)) << chart.reference.words;
  }
}

// A swing for a thousand periods: the difference of two methods grows as the square of time, which is not
// chaos, so the whole motion is compared.
TEST(WorkPrecision, LongSwingIsNotChaos) {
  Scene scene = read_scene(test::source_folder() + "/samples/pendulum.toml").value();
  scene.simulation.end_time = 3000;
  const WorkPrecision chart = work_precision(scene, measured_once({"dop853"})).value();
  ASSERT_TRUE(chart.reference.found);
  EXPECT_EQ(chart.reference.words.find("chaos"), std::string::npos) << chart.reference.words;
  EXPECT_NEAR(chart.reference.horizon, 3000, 1e-6) << chart.reference.words;
  EXPECT_TRUE(fastest_within(chart, 1e-3));
}

// Near the separatrix each turn of the plate multiplies the difference of two runs, to 5e-6 after 10 s. Over
// half of that time, accuracies down to 1e-7 can be judged.
TEST(WorkPrecision, GrowingDivergenceShortensTheComparison) {
  const Scene scene = read_scene(test::source_folder() + "/samples/spinning_plate.toml").value();
  const WorkPrecision chart = work_precision(scene, measured_once({"dop853"})).value();
  ASSERT_TRUE(chart.reference.found);
  EXPECT_LE(reference_floor(chart), 1e-7) << chart.reference.words;
  EXPECT_GT(chart.reference.horizon, 3) << chart.reference.words;  // it has turned over twice
  EXPECT_LT(chart.reference.horizon, 9) << chart.reference.words;
  EXPECT_TRUE(fastest_within(chart, 1e-6));
}

// Springs of 3e8 N m/rad with dampers of 5e6: no explicit method succeeds. The stiff spring's angle is
// bounded by its load over its stiffness.
TEST(WorkPrecision, StiffSceneHasAnImplicitReference) {
  const Scene scene = parse_scene(R"(name = "very stiff arm"
gravity = [0, 0, -9.81]
[simulation]
end_time = 2
[[solid]]
name = "upper"
joint = {rotation = "y", name = "q1", value = 0.1}
mass = 2.0
centre = [0, 0, -0.15]
tensor = [0.02, 0.02, 0.001]
[[solid]]
name = "fore"
parent = "upper"
joint = [{fixed = [0, 0, -0.3]}, {rotation = "y", name = "q2", value = 0.9}]
mass = 1.2
centre = [0, 0, -0.14]
tensor = [0.01, 0.01, 0.001]
[[effort]]
name = "k1"
kind = "coordinate_spring"
on = "q1"
stiffness = 3e8
damping = 5e6
rest = 0.1
)",
                                  "arm.toml")
                          .value();
  const WorkPrecision chart = work_precision(scene, measured_once({"cvode", "gauss6"})).value();
  ASSERT_TRUE(chart.reference.found) << chart.reference.words;
  EXPECT_NE(chart.reference.runs[0].find("cvode"), std::string::npos);
  EXPECT_NEAR(chart.reference.horizon, 2, 1e-9);
  EXPECT_TRUE(fastest_within(chart, 1e-6));
  // the same scene with a rigid joint moves as a pendulum; the spring yields by less than 1e-7
  Scene rigid = scene;
  rigid.efforts.clear();
  rigid.solids[0].switches[0].motion = Locked{};
  const System one = compile(rigid).value(), two = compile(scene).value();
  SimulationSettings how = rigid.simulation;
  how.method = "dop853";
  how.tolerance = 1e-12;
  how.output_interval = 0.1;
  const Trajectory pendulum = simulate(one, one.initial, how).value();
  how.method = "cvode";
  how.tolerance = 1e-11;
  const Trajectory stiff = simulate(two, two.initial, how).value();
  for (std::size_t row = 0; row < pendulum.times.size(); ++row)
    EXPECT_NEAR(stiff.q(Eigen::Index(row), 1), pendulum.q(Eigen::Index(row), 0), 1e-6);
}

TEST(WorkPrecision, SaysIfNoMethodCompletesTheRun) {
  Scene scene = oscillator();
  scene.efforts = {{"spring", CoordinateSpring{{"x"}, -1e6, 0, 0}}};  // runs away as exp(1000 t)
  WorkPrecisionSettings settings;
  settings.methods = {"rk4"};
  settings.repeats = 1;
  const WorkPrecision chart = work_precision(scene, settings).value();
  EXPECT_FALSE(chart.reference.found);
  EXPECT_NE(chart.reference.words.find("no method completes the run"), std::string::npos)
      << chart.reference.words;
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

// A reference said to be exact to 1e-12 but 0.1 m off; two of our methods contradict it.
TEST(WorkPrecision, ContradictsAWrongReference) {
  const Scene scene = oscillator();
  WorkPrecisionSettings settings = measured_once({"rk4"}, 0.02);
  const auto words = [&](double off) {
    GivenReference given{.name = "mine.csv", .times = {}, .poses = {}};
    for (int i = 0; i <= settings.outputs; ++i) {
      given.times.push_back(5. * i / settings.outputs);
      given.poses.push_back({.p = {std::cos(2 * given.times.back()) + off, 0, 0}});
    }
    settings.reference = given;
    return work_precision(scene, settings).value().reference.words;
  };
  EXPECT_NE(words(0.1).find("It is contradicted"), std::string::npos) << words(0.1);
  EXPECT_EQ(words(0).find("contradicted"), std::string::npos) << words(0);
  EXPECT_NE(words(0).find("agree with it to"), std::string::npos) << words(0);
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
