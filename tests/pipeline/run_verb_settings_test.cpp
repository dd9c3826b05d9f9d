// The settings of `borelli run`: stored ones repeat the run, tolerances choose model and method, and wrong ones
// are refused.
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>

#include "dynamics/formats/model_file.hpp"
#include "dynamics/formats/scene_file.hpp"
#include "dynamics/run/simulate.hpp"
#include "pipeline/charts/motion_quantity.hpp"
#include "pipeline/export/trajectory_file.hpp"
#include "process/input_file.hpp"
#include "tests/paths.hpp"
#include "tests/pipeline/program_run.hpp"
#include "tests/pipeline/run_verb.hpp"

namespace borelli::run_verb_test {
namespace {

using nlohmann::json;

TEST_F(RunVerb, AccuracyChoosesTheMethodUnlessOneIsNamed) {
  const auto certificate_of = [&](const std::string& option) {
    stages_done(path("scan.mhd") + words() + option);
    return read_trajectory(result("motion/trajectory.h5"))->trajectory.certificate;
  };
  const Certificate usual = certificate_of("");
  EXPECT_TRUE(usual.trusted) << usual.reason;
  EXPECT_EQ(usual.accuracy, 1e-6);
  EXPECT_LE(usual.estimated_error, 1e-6);
  EXPECT_EQ(usual.method, "dop853");
  EXPECT_EQ(certificate_of(" --accuracy 1e-4").accuracy, 1e-4);
  const Certificate named = certificate_of(" --method rk4 --step 1e-3");
  EXPECT_EQ(named.accuracy, 0);
  EXPECT_EQ(named.method, "rk4");
}

TEST_F(RunVerb, StoredSettingsRepeatTheRun) {
  // names that look like numbers, a number without exact decimals, quotes
  const std::string run = path("scan.mhd") + words("007") +
                          " --keep-paths --pose \"on \\\"one's\\\" side\" --sex female --allow-untrusted"
                          " --tolerance 3.0000000000000004e-7 --somersault-rate -123.456 --tuck +.25"
                          " --density-curve mcsquare --method rk4_adaptive --muscle-frequency 1"
                          " --damping-ratio 0.7 --label-names " +
                          path("labels.tsv");
  EXPECT_EQ(stages_done(run), all);
  const std::string file = path("out/007/settings.toml");
  const std::string text = read_input_file(file).value();
  const auto record = json::parse(read_input_file(path("out/007/run.json")).value());
  EXPECT_EQ(record["settings"]["subject"], "007");
  EXPECT_EQ(record["settings"]["pose"], "on \"one's\" side");
  EXPECT_EQ(record["settings"]["integrator_tolerance"], 3.0000000000000004e-7);
  EXPECT_EQ(record["settings"]["leap"]["tuck"], 0.25);

  EXPECT_EQ(stages_done("--settings " + file), Names{});
  EXPECT_EQ(json::parse(read_input_file(path("out/007/run.json")).value())["settings"], record["settings"]);
  EXPECT_EQ(read_input_file(file).value(), text);
  // without paths, the run is the same wherever its inputs are
  EXPECT_EQ(stages_done("--settings " + file + " --keep-paths=false"), all);
  const std::string shared = read_input_file(file).value();
  EXPECT_EQ(shared.find(folder.path().string()), std::string::npos) << shared;
  EXPECT_NE(shared.find("run VOLUME --settings settings.toml --output FOLDER --labels labels.nrrd"),
            std::string::npos)
      << shared;
  fs::create_directories(folder / "moved");
  for (const char* name : {"scan.mhd", "scan.raw", "labels.nrrd", "labels.tsv", "joints.json"})
    fs::rename(folder / name, folder / "moved" / name);
  EXPECT_EQ(stages_done(path("moved/scan.mhd") + " --settings " + file + " -o " + path("out") + " --labels " +
                        path("moved/labels.nrrd") + " --label-names " + path("moved/labels.tsv") +
                        " --landmarks " + path("moved/joints.json")),
            Names{});
  EXPECT_EQ(read_input_file(file).value(), shared);
  for (const char* name : {"scan.mhd", "scan.raw", "labels.nrrd", "labels.tsv", "joints.json"})
    fs::rename(folder / "moved" / name, folder / name);
  EXPECT_EQ(stages_done("--settings " + file + ' ' + path("scan.mhd") + words("007") + " --label-names " +
                        path("labels.tsv") + " --keep-paths"),
            all);
  // the command line overrides the file
  EXPECT_EQ(stages_done("--settings " + file + " --tuck 0.5"),
            (Names{"skeleton", "motion", "models", "glb", "report"}));
}

TEST_F(RunVerb, SimulatesTheSmallestModelWithinATolerance) {
  const std::string run = path("scan.mhd") + words();
  Names with_economy = all;
  with_economy.insert("economy");
  EXPECT_EQ(stages_done(run + " --model-tolerance 1% --keep centre --keep turn:lower_trunk"), with_economy);
  const auto record = json::parse(read_input_file(result("run.json")).value());
  const json said = record["stages"][3]["economy"];
  const Scene whole = read_scene(result("model/scene.toml")).value(),
              small = read_scene(result("model/smallest.toml")).value();
  EXPECT_EQ(compile(small).value().nv, said["coordinates"].get<int>());
  EXPECT_LT(said["coordinates"].get<int>(), said["whole"]["coordinates"].get<int>());
  EXPECT_GT(said["search"]["runs"].get<int>(), 0);
  const auto moved = read_trajectory(result("motion/trajectory.h5"));
  ASSERT_TRUE(moved);
  EXPECT_EQ(int(moved->trajectory.v.cols()), said["coordinates"].get<int>());
  EXPECT_NE(read_input_file(result("report.html")).value().find(said["in_words"].get<std::string>()),
            std::string::npos);
  // both models by another method, much better
  const auto motion = [](Scene scene) {
    scene.simulation.method = "gbs", scene.simulation.tolerance = 1e-11;
    const System system = compile(scene).value();
    return simulate(system).value();
  };
  const Trajectory a = motion(whole), b = motion(small);
  const double length = compile(whole).value().length;
  double error = 0;
  for (const char* text : {"centre", "turn:lower_trunk"}) {
    const auto quantity = parse_motion_quantity(text, whole).value();
    for (std::size_t row = 0; row < a.times.size(); ++row)
      error = std::max(error, quantity_difference(quantity, a, b, row, length));
  }
  EXPECT_GT(error, 0);
  EXPECT_LE(error, 0.01);
  EXPECT_LE(error, said["error"].get<double>() + 2e-4);  // at output rows, to a hundredth

  EXPECT_EQ(
      stages_done("--settings " + result("settings.toml").string() + ' ' + path("scan.mhd") + " --labels " +
                  path("labels.nrrd") + " --landmarks " + path("joints.json") + " -o " + path("out")),
      Names{});
  EXPECT_EQ(stages_done(run), (Names{"motion", "glb", "report"}));
  EXPECT_FALSE(fs::exists(result("model/smallest.toml")));
  expect_refused("run " + run + " --keep centre", 2, "--keep: applies only with --model-tolerance");
  expect_refused("run " + run + " --model-tolerance 1e-6", 2, "is not between 0.1 and 50 %");
}

TEST_F(RunVerb, StepIsForMethodsWithFixedSteps) {
  EXPECT_EQ(stages_done(path("scan.mhd") + words() + " --keep-paths --method rk4 --step 1e-3"), all);
  const auto record = json::parse(read_input_file(path("out/s/run.json")).value());
  EXPECT_EQ(record["settings"]["step"], 1e-3);
  const auto& certificate = record["stages"][3]["certificate"];
  EXPECT_TRUE(certificate["trusted"].get<bool>());
  // a leap of 0.1 s is 100 steps; a step is cut in two at an output row that is no multiple of the step and
  // where a joint meets or leaves a stop
  const int cuts = static_cast<int>(certificate["events"].size());
  EXPECT_NEAR(certificate["steps_accepted"].get<int>(), 100 + cuts + 3, 3);
  const std::string settings = path("out/s/settings.toml");
  EXPECT_EQ(stages_done("--settings " + settings), Names{});
}

TEST_F(RunVerb, WrongSettingsAreNamedWithTheirLine) {
  for (const auto& [text, said] :
       {std::pair{"[run]\nsex = 'male'\ncolour = 'red'\n", ":3: unknown setting run.colour"},
        {"[run]\n\ntolerance = 'few'\n", ":3: run.tolerance is 'few', expected a number"},
        {"[run]\ntuck = true\n", ":2: run.tuck is true, expected a number"},
        {"[run]\nsubject = 7\n", ":2: run.subject is 7, expected a text in quotes"},
        {"[run]\nallow-untrusted = 'yes'\n", ":2: run.allow-untrusted is 'yes', expected true or false"},
        {"[run]\ntuck = 2\n", ":2: run.tuck: is 2, expected a number from 0 to 1"},
        {"[run]\nsex = 'neither'\n", ":2: run.sex: is 'neither', expected one of male, female"},
        {"[run]\ntuck = [0.5]\n", ":2: run.tuck is a list"},
        {"[run.leap]\ntuck = 1\n", ":1: unknown setting run.leap"},
        {"[walk]\ntuck = 1\n", ":1: unknown verb 'walk'"},
        {"colour = 1\n", ":1: unknown setting colour"},
        {"threads = 1.5\n", ":1: threads is 1.5, expected a whole number"},
        {"[phantom]\nspacing = [2.0, 'x', 3.0]\n", ":2: phantom.spacing is 'x', expected a number"},
        {"[phantom]\nspacing = [2.0, 3.0, 4.0, 5.0]\n", ":2: phantom.spacing has 4 entries"},
        {"[phantom]\nrotation-deg = [1.0, 2.0]\n", ":2: phantom.rotation-deg has 2 entries, expected 3"},
        {"[run]\nhelp = true\n", ":2: unknown setting run.help"},
        {"[run]\ntuck = \n", ":2: "}}) {
    folder.write("run.toml", text);
    expect_refused("run " + path("scan.mhd") + words() + " --settings " + path("run.toml"), 2,
                   path("run.toml") + said);
    EXPECT_FALSE(fs::exists(folder / "out")) << text;
  }
}

TEST_F(RunVerb, RefusesBadUseBeforeAnyWork) {
  fs::create_directories(folder / "slices");             // the next run would read results in there as slices
  for (const char* out : {".", "slices", "slices/new"})  // ".": results go to a folder named as the scan's
    expect_refused("run --keep-paths " + path("slices") + " -o " + path(out), 2,
                   "lies within the scan's folder");
  fs::remove(folder / "slices");
  expect_refused("run " + path("none.mhd") + words(), 2, "none.mhd: no such file");
  expect_refused("run " + path("scan.mhd") + words("s", "none.json"), 2, "none.json: no such file");
  expect_refused("run " + path("scan.mhd") + words() + " --density-curve mine", 2, "schneider2000");
  expect_refused("run " + path("scan.mhd") + words() + " --method rk4 --tolerance 1e-6", 2,
                 "--tolerance: has no effect with rk4");
  expect_refused("run " + path("scan.mhd") + words() + " --step 1e-3", 2, "--step requires --method");
  expect_refused("run " + path("scan.mhd") + words() + " --accuracy 1e-7 --method rk4", 2, "--accuracy");
  const std::string keep = "run " + path("scan.mhd") + words() + " --model-tolerance 5% --keep ";
  expect_refused(keep + "turn:nosuch", 2, "quantity 'turn:nosuch': the scene has no solid of that name");
  expect_refused(keep + "coordinate:spine", 2, "no moving coordinate of that name");
  expect_refused(keep + "solid:head:1,2", 2, "its point must be three numbers");
  expect_refused("run " + path("scan.mhd") +
                     " --quantity hu --segments trunk,leg_left --model-tolerance 5% --keep solid:head -o " +
                     path("out"),
                 2, "quantity 'solid:head': the scene has no solid of that name");
  EXPECT_FALSE(fs::exists(folder / "out"));
  fs::create_directories(result("report.html"));  // blocks the last output
  expect_refused("run " + path("scan.mhd") + words(), 2, "report.html: is a folder");
  fs::remove(result("report.html"));
  std::ofstream(result("mesh")) << "";
  expect_refused("run " + path("scan.mhd") + words(), 1, "mesh is not a folder");
  for (const char* name : {"segmentation", "inertia", "motion", "run.json"})
    EXPECT_FALSE(fs::exists(result(name)));
}

}  // namespace
}  // namespace borelli::run_verb_test
