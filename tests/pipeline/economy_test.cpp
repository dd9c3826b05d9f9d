// The smallest model that does: scenes of which the answer is known, and its errors by simulating what it
// wrote.
#include "pipeline/charts/economy_page.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "dynamics/formats/scene_file.hpp"
#include "dynamics/run/simulate.hpp"
#include "pipeline/charts/motion_difference.hpp"
#include "tests/paths.hpp"
#include "tests/pipeline/program_run.hpp"

namespace borelli {
namespace {

// An arm that swings and carries a hand, whose wrist a spring of so many N m/rad holds straight, on which
// sits a ring that nothing turns.
Scene arm(double stiffness, double hand_mass = 0.5) {
  const std::string text = R"(name = "arm"
[simulation]
end_time = 2
[[solid]]
name = "arm"
joint = {rotation = "y", name = "shoulder", value = 1}
mass = 2
centre = [0, 0, -0.3]
tensor = [0.06, 0.06, 0.001]
[[solid]]
name = "hand"
parent = "arm"
joint = [{fixed = [0, 0, -0.6]}, {rotation = "y", name = "wrist"}]
mass = HAND_M
centre = [0, 0, -0.1]
tensor = [HAND_I, HAND_I, HAND_I]
[[solid]]
name = "ring"
parent = "hand"
joint = [{fixed = [0, 0, -0.1]}, {rotation = "z", name = "turn"}]
mass = RING_M
tensor = [RING_I, RING_I, RING_I]
[[effort]]
name = "tendon"
kind = "coordinate_spring"
on = "wrist"
stiffness = STIFFNESS
)";
  std::string filled = text;
  const auto fill = [&](const std::string& word, double value) {
    for (std::size_t at; (at = filled.find(word)) != std::string::npos;)
      filled.replace(at, word.size(), fmt::format("{}", value));
  };
  fill("STIFFNESS", stiffness);
  fill("HAND_M", hand_mass);
  fill("HAND_I", 2e-3 * hand_mass);
  fill("RING_M", 0.02 * hand_mass);
  fill("RING_I", 2e-6 * hand_mass);
  return parse_scene(filled, "arm.toml").value();
}

std::vector<std::string> changes(const Economy& economy) {
  std::vector<std::string> out;
  for (const EconomyModel& model : economy.models) out.push_back(model.change);
  return out;
}

TEST(Economy, LocksAStiffWristAndAnUnmovedRing) {
  const Economy e = scene_economy(arm(2000), {.tolerance = 1e-3}).value();
  EXPECT_EQ(changes(e), (std::vector<std::string>{"", "coordinate 'turn'", "coordinate 'wrist'"}));
  EXPECT_EQ(e.models[0].coordinates, 3);
  EXPECT_EQ(e.models[2].coordinates, 1);
  EXPECT_EQ(e.models[2].bodies, 1);
  EXPECT_LT(e.models[1].error, 2 * e.accuracy);  // it does not turn at all
  // the spring bends by about the hand's moment over its stiffness: m g c / k, over the scene's length
  EXPECT_GT(e.models[2].error, 1e-5);
  EXPECT_LT(e.models[2].error, 1e-3);
  EXPECT_TRUE(e.smallest.efforts.empty());  // a spring on what is locked
  ASSERT_EQ(e.refusals.size(), 1u);
  EXPECT_EQ(e.refusals[0].change, "coordinate 'shoulder'");
  EXPECT_GT(e.refusals[0].error, 0.1);
}

TEST(Economy, KeepsAWeakWristFree) {
  const Economy e = scene_economy(arm(1), {.tolerance = 1e-3}).value();
  EXPECT_EQ(changes(e), (std::vector<std::string>{"", "coordinate 'turn'"}));
  EXPECT_EQ(e.smallest.efforts.size(), 1u);
}

TEST(Economy, RequestedQuantitiesDecide) {
  // the hand flaps, but it weighs little beside the arm, of which alone the motion is asked for
  EXPECT_EQ(scene_economy(arm(0, 1e-3), {.tolerance = 1e-2}).value().models.back().coordinates, 2);
  const auto of_arm = [](double hand_mass) {
    return scene_economy(arm(0, hand_mass),
                         {.quantities = {"solid:arm", "coordinate:shoulder", "turn:arm"}, .tolerance = 1e-3})
        .value()
        .models.back();
  };
  const EconomyModel light = of_arm(1e-4), heavier = of_arm(1e-3);
  EXPECT_EQ(light.coordinates, 1);
  EXPECT_EQ(heavier.coordinates, 1);
  // a small mass that is held wrongly disturbs the arm in proportion to it
  EXPECT_NEAR(heavier.error / light.error, 10, 1);  // (and the next order by its square)
}

TEST(Economy, ErrorsAreThoseOfTheWrittenScene) {
  const TestFolder folder;
  const std::string whole = folder.write("arm.toml", write_scene(arm(500)).value());
  const ProgramRun run =
      run_program("economy " + whole + " --model-tolerance 0.5% --json -o " + folder.path().string());
  ASSERT_EQ(run.code, 0) << run.err;
  const auto answer = nlohmann::json::parse(run.out, nullptr, false);
  ASSERT_EQ(answer["models"].size(), 3u) << answer["stays"];
  for (const char* file : {"economy.html", "economy.csv", "error.svg", "time.png"})
    EXPECT_TRUE(std::filesystem::exists(folder / file)) << file;
  // both by another method, much better
  const auto motion = [](const Scene& scene) {
    const System system = compile(scene).value();
    SimulationSettings how = scene.simulation;
    how.method = "gbs";
    how.tolerance = 1e-12;
    how.output_interval = 0.01;
    return simulate(system, system.initial, how).value();
  };
  const Scene full = read_scene(whole).value(), small = read_scene(folder / "scene.toml").value();
  const Trajectory a = motion(full), b = motion(small);
  EXPECT_EQ(b.coordinates.size(), 1u);
  const double length = compile(full).value().length;
  double error = 0;
  for (std::size_t row = 0; row < a.times.size(); ++row)
    error = std::max(
        error, motion_difference(&a.pose(row, 0), &b.pose(row, 0), gravity_centres(full)).position / length);
  EXPECT_NEAR(answer["models"][2]["error"].get<double>(), error, 2 * answer["accuracy"].get<double>());
}

TEST(Economy, LocksALoopCompletelyOrNotAtAll) {
  // of a four-bar every coordinate follows from any other: to lock one is to lock all
  const Scene scene = read_scene(test::source_folder() + "/samples/four_bar_2.toml").value();
  Scene shorter = scene;
  shorter.simulation.end_time = 0.3;
  const Economy e = scene_economy(shorter, {.tolerance = 1e-2}).value();
  EXPECT_EQ(e.models.size(), 1u);
  EXPECT_FALSE(e.refusals.empty());
}

Scene read_text(const std::string& text) { return parse_scene(text, "a.toml").value(); }

std::string slider(const std::string& name, double start, double stiffness) {
  return fmt::format(R"(
[[solid]]
name = "{0}"
joint = {{translation = "x", name = "{0}.x", value = {1}}}
mass = 1
centre = [0, 0, 0]
tensor = [1e-3, 1e-3, 1e-3]
[[effort]]
name = "spring of {0}"
kind = "coordinate_spring"
on = "{0}.x"
stiffness = {2}
)",
                     name, start, stiffness);
}

double refused_error(const Economy& economy, const std::string& change) {
  for (const EconomyRefusal& one : economy.refusals)
    if (one.change == change) return one.error;
  return std::nan("");
}

TEST(Economy, CentreIsThatOfAllMovingSolidsOfTheWholeModel) {
  // two equal masses swing alike, as cos wt: with one held their centre is at (1 + cos wt) / 2
  const Scene twins = read_text("name = \"twins\"\ngravity = [0, 0, 0]\n[simulation]\nend_time = 2\n" +
                                slider("left", 1, 10) + slider("right", 1, 10));
  const Economy e = scene_economy(twins, {.quantities = {"centre"}, .tolerance = 0.2}).value();
  EXPECT_EQ(e.models.size(), 1u);
  const double length = compile(twins).value().length;
  for (const char* one : {"coordinate 'left.x'", "coordinate 'right.x'"})
    EXPECT_NEAR(refused_error(e, one), 1 / length, 2 * e.accuracy + 1e-4) << one;  // (1e-4: of the instants)
  // what turns about its own centre of gravity moves no centre; its mass counts all the same
  const Scene spun = read_text("name = \"spun\"\ngravity = [0, 0, 0]\n[simulation]\nend_time = 2\n" +
                               slider("left", 1, 10) + R"([[solid]]
name = "wheel"
joint = {rotation = "x", name = "spin", velocity = 3}
mass = 5
centre = [0, 0, 0]
tensor = [1e-3, 1e-3, 1e-3]
)");
  const Economy of_spun = scene_economy(spun, {.quantities = {"centre"}, .tolerance = 0.01}).value();
  EXPECT_EQ(changes(of_spun), (std::vector<std::string>{"", "coordinate 'spin'"}));
  EXPECT_LT(of_spun.models[1].error, 2 * of_spun.accuracy);
  EXPECT_NEAR(refused_error(of_spun, "coordinate 'left.x'"), 2. / 6 / compile(spun).value().length,
              2 * of_spun.accuracy + 1e-4);
}

TEST(Economy, SeesSwingsInStepWithTheOutputs) {
  // 100 Hz, looked at every 0.01 s: it always seems to stand where it began
  const Scene buzz = read_text("name = \"buzz\"\ngravity = [0, 0, 0]\n[simulation]\nend_time = 2\n" +
                               slider("buzzer", 0.3, std::pow(200 * M_PI, 2)));
  const Economy e = scene_economy(buzz, {.tolerance = 0.05}).value();
  EXPECT_EQ(e.models.size(), 1u);
  EXPECT_NEAR(refused_error(e, "coordinate 'buzzer.x'"), 0.6 / compile(buzz).value().length, 0.02);
  EXPECT_GT(e.instants, 800);  // two to a period at the least
  EXPECT_FALSE(e.sparse);
}

TEST(Economy, LocksCoordinatesDrivenByAlmostNothing) {
  const auto driven = [](double amplitude) {
    return read_text(fmt::format(R"(name = "driven"
[simulation]
end_time = 2
[[solid]]
name = "motor"
joint = {{rotation = "y", name = "drive", driven = {{kind = "sine", amplitude = {}, angular_frequency = 3}}}}
mass = 1
centre = [0, 0, -0.1]
tensor = [0.01, 0.01, 0.01]
[[solid]]
name = "arm"
parent = "motor"
joint = {{rotation = "y", name = "q", value = 1}}
mass = 1
centre = [0, 0, -0.5]
tensor = [0.01, 0.01, 0.01]
)",
                                 amplitude));
  };
  const Economy e = scene_economy(driven(1e-6), {}).value();
  EXPECT_EQ(changes(e), (std::vector<std::string>{"", "coordinate 'drive'"}));
  EXPECT_EQ(e.models[1].coordinates, 1);
  EXPECT_EQ(e.models[1].bodies, 1);
  // asked for itself, it is off by all its amplitude
  const Economy of_drive =
      scene_economy(driven(0.2), {.quantities = {"coordinate:drive"}, .tolerance = 0.1}).value();
  EXPECT_NEAR(refused_error(of_drive, "coordinate 'drive'"), 0.2, 1e-4);
}

TEST(Economy, LocksTwoCoordinatesWithOppositeErrorsTogether) {
  // a bar carries two wheels that spin up against each other: mirror images, so that it stays at rest; with
  // one of them held it turns
  std::string text = R"(name = "mirror"
gravity = [0, 0, 0]
[simulation]
end_time = 1
[[solid]]
name = "bar"
joint = {rotation = "z", name = "bar.turn"}
mass = 1
centre = [0, 0, 0]
tensor = [0.02, 0.02, 0.02]
)";
  for (const auto& [name, side] : {std::pair("left", -1.), std::pair("right", 1.)})
    text += fmt::format(R"([[solid]]
name = "{0}"
parent = "bar"
joint = [{{fixed = [{1}, 0, 0]}}, {{rotation = "z", name = "{0}.turn", value = {1}}}]
mass = 0.5
centre = [0, 0.03, 0]
tensor = [2e-3, 2e-3, 2e-3]
[[effort]]
name = "spring of {0}"
kind = "coordinate_spring"
on = "{0}.turn"
stiffness = 0.5
)",
                        name, 0.3 * side);
  const Economy e = scene_economy(read_text(text), {.quantities = {"turn:bar"}, .tolerance = 5e-3}).value();
  EXPECT_EQ(e.models.back().coordinates, 0);  // (the bar rests, and then the wheels are nobody's)
  Scene held = read_text(text);
  held.solids[0].switches[0].v = {0.1};  // now it may not be locked
  const Economy turning = scene_economy(held, {.quantities = {"turn:bar"}, .tolerance = 5e-3}).value();
  ASSERT_EQ(turning.models.size(), 2u) << in_words(turning);
  EXPECT_NE(turning.models[1].change.find(".turn' and coordinate '"), std::string::npos);
  EXPECT_GT(refused_error(turning, "coordinate 'bar.turn'"), 0.05);
}

TEST(Economy, IsReproducibleExceptForTimes) {
  const Economy a = scene_economy(arm(500), {}).value(), b = scene_economy(arm(500), {}).value();
  ASSERT_EQ(a.models.size(), b.models.size());
  for (std::size_t i = 0; i < a.models.size(); ++i) {
    EXPECT_EQ(a.models[i].change, b.models[i].change);
    EXPECT_EQ(a.models[i].error, b.models[i].error);
    EXPECT_EQ(a.models[i].evaluations, b.models[i].evaluations);
  }
}

TEST(Economy, RefusesInvalidRequests) {
  EXPECT_NE(
      scene_economy(arm(1), {.quantities = {"solid:foot"}}).error().message().find("no solid of that name"),
      std::string::npos);
  EXPECT_NE(
      scene_economy(arm(1), {.quantities = {"hand"}}).error().message().find("expected centre, solid:NAME"),
      std::string::npos);
  const TestFolder folder;
  const auto refused_words = [&](const std::string& arguments) {
    const ProgramRun run = run_program("economy " + arguments + " -o " + folder.path().string());
    EXPECT_EQ(run.code, 2) << arguments;
    return run.err;
  };
  EXPECT_NE(refused_words("none.toml --model-tolerance 200%").find("is not between 1e-07 and 100 %"),
            std::string::npos);
  EXPECT_NE(refused_words("none.toml").find("none.toml: no such file"), std::string::npos);
  const std::string volume = folder.write("v.nii.gz", "");
  EXPECT_NE(refused_words(volume + " --end 3").find("leave out the options for scenes"), std::string::npos);
  EXPECT_NE(refused_words(volume + " --quantity centre").find("centre"), std::string::npos);
  EXPECT_NE(refused_words(volume + " --keep centre").find("leave out the options for scenes"),
            std::string::npos);
  EXPECT_NE(refused_words(folder.write("s.toml", "").string() + " --quantity centre").find("use --keep"),
            std::string::npos);
  Scene chaotic = read_scene(test::source_folder() + "/samples/pendulum_5.toml").value();
  chaotic.simulation.end_time = 60;
  const auto refused = scene_economy(chaotic, {});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message().find("cannot be computed to 0.0001"), std::string::npos)
      << refused.error().message();
}

}  // namespace
}  // namespace borelli
