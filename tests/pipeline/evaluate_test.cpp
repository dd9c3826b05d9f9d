// `borelli evaluate` as other programs use it: flat arrays in the scene's own order, equations that add up.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "pipeline/export/trajectory_file.hpp"
#include "tests/paths.hpp"
#include "tests/pipeline/program_run.hpp"

namespace borelli {
namespace {

using nlohmann::json;
const std::string samples = test::source_folder() + "/samples/";

json answer(const std::string& scene, const std::string& state, const TestFolder& folder) {
  const std::string file = folder.write("state.json", state);
  const ProgramRun run = run_program("evaluate " + scene + " --state " + file);
  EXPECT_EQ(run.code, 0) << run.err;
  return json::parse(run.out, nullptr, false);
}

TEST(Evaluate, PendulumMatchesHandCalculation) {
  const TestFolder folder;
  // a point of 1 kg on 1 m: A = 1, no velocity terms, Q = -g sin(q), turned by the effort
  const json a =
      answer(samples + "pendulum.toml", R"({"t": 0, "q": [0.3], "v": [2], "efforts": [0.5]})", folder);
  EXPECT_EQ(a["coordinates"], json({"swing"}));
  EXPECT_NEAR(a["mass_matrix"][0][0], 1, 1e-15);
  EXPECT_NEAR(a["bias"][0], 0, 1e-15);
  EXPECT_NEAR(a["generalized_efforts"][0], 0.5 - 9.81 * std::sin(0.3), 1e-14);
  EXPECT_NEAR(a["acceleration"][0], 0.5 - 9.81 * std::sin(0.3), 1e-14);
  EXPECT_NEAR(a["kinetic_energy"], 2, 1e-15);
  EXPECT_NEAR(a["potential_energy"], -9.81 * std::cos(0.3), 1e-14);  // weight, zero at the world's origin
}

TEST(Evaluate, AnswerSatisfiesTheEquationsOfMotion) {
  const TestFolder folder;
  const json a = answer(samples + "roundabout.toml",
                        R"({"q": [1, 0.4, -0.7], "v": [3, -2, 1], "efforts": [1, 2, 3]})", folder);
  for (int i = 0; i < 3; ++i) {
    double left = a["bias"][i];
    for (int j = 0; j < 3; ++j) {
      left += a["mass_matrix"][i][j].get<double>() * a["acceleration"][j].get<double>();
      EXPECT_EQ(a["mass_matrix"][i][j], a["mass_matrix"][j][i]);
    }
    EXPECT_NEAR(left, a["generalized_efforts"][i], 1e-12);
  }
}

TEST(Evaluate, MissingVelocitiesAndEffortsAreZero) {
  const TestFolder folder;
  const json bare = answer(samples + "roundabout.toml", R"({"q": [0, 0.2, -0.5]})", folder);
  const json full = answer(samples + "roundabout.toml",
                           R"({"t": 0, "q": [0, 0.2, -0.5], "v": [0, 0, 0], "efforts": [0, 0, 0]})", folder);
  EXPECT_EQ(bare, full);
  EXPECT_EQ(bare["kinetic_energy"], 0);
}

TEST(Evaluate, KeepsTheOrderOfTheFile) {
  // the child stands before its parent in the second file: same motion, other order
  const std::string upper =
      "[[solid]]\nname='upper'\njoint={rotation='y',name='a'}\nmass=1\ncentre=[0,0,-0.5]\ntensor=[0.1,0.1,0."
      "01]\n";
  const std::string lower =
      "[[solid]]\nname='lower'\nparent='upper'\njoint=[{fixed=[0,0,-1]},{rotation='y',name='b'}]\nmass="
      "2\ncentre=[0,0,-0.5]\ntensor=[0.2,0.2,0.01]\n";
  const TestFolder folder;
  const std::string first = folder.write("first.toml", upper + lower),
                    second = folder.write("second.toml", lower + upper);
  const json p = answer(first, R"({"q": [0.3, 0.8], "v": [1, -2], "efforts": [5, 7]})", folder);
  const json r = answer(second, R"({"q": [0.8, 0.3], "v": [-2, 1], "efforts": [7, 5]})", folder);
  EXPECT_EQ(p["coordinates"], json({"a", "b"}));
  EXPECT_EQ(r["coordinates"], json({"b", "a"}));
  for (int i = 0; i < 2; ++i) {
    for (const char* key : {"acceleration", "bias", "generalized_efforts"})
      EXPECT_NEAR(p[key][i], r[key][1 - i], 1e-12) << key;
    for (int j = 0; j < 2; ++j) EXPECT_NEAR(p["mass_matrix"][i][j], r["mass_matrix"][1 - i][1 - j], 1e-12);
  }
}

TEST(Evaluate, AcceptsTheEndStateOfASimulation) {
  // a child before its parent, with a ball: what simulate answers is a state of the same energy here
  const TestFolder folder;
  const std::string scene = folder.write(
      "scene.toml",
      "[[solid]]\nname='child'\nparent='base'\njoint=[{fixed=[0,0,1]},{ball=true,name='ball',velocity=[1,2,3]"
      "}]\n"
      "mass=2\ncentre=[0.1,0.2,0.3]\ntensor=[0.3,0.4,0.5]\n"
      "[[solid]]\nname='base'\njoint=[{translation='x',name='tx',velocity=0.7},{rotation='z',name='rz'}]\n"
      "mass=3\ncentre=[0.2,0,0]\ntensor=[0.1,0.2,0.25]\n[simulation]\nend_time=0.5\nstep=0.001\n");
  const std::string output = folder / "motion.h5";
  const ProgramRun run = run_program("simulate --json " + scene + " -o " + output);
  ASSERT_EQ(run.code, 0) << run.err;
  const json said = json::parse(run.out, nullptr, false);
  EXPECT_EQ(said["coordinates"][0],
            json({{"name", "ball"}, {"kind", "ball"}, {"q_index", 0}, {"v_index", 0}}));
  EXPECT_EQ(said["coordinates"][1],
            json({{"name", "tx"}, {"kind", "translation"}, {"q_index", 4}, {"v_index", 3}}));
  const auto stored = read_trajectory(output);
  ASSERT_TRUE(stored) << stored.error().message();
  const Trajectory& t = stored->trajectory;
  EXPECT_EQ(t.coordinates.front().name, "tx");  // the engine has the parent first
  const json at_end = answer(scene, said["end"].dump(), folder);
  EXPECT_EQ(at_end["coordinates"], json({"ball.x", "ball.y", "ball.z", "tx", "rz"}));
  // the same numbers go into the same equations: the trajectory's own energies to rounding
  EXPECT_NEAR(at_end["kinetic_energy"], t.kinetic.back(), 1e-12 * t.kinetic.back());
  EXPECT_NEAR(at_end["potential_energy"], t.potential.back(), 1e-10);
}

TEST(Evaluate, ReportsTheEffortsOfDrives) {
  // a point of 2 kg, 1 m from a hinge about z that turns as t^2: 2 rad/s^2 take 2 * 1^2 * 2 = 4 N m
  const TestFolder folder;
  const std::string scene = folder.write(
      "scene.toml",
      "[[solid]]\nname='arm'\njoint={rotation='z',name='turn',driven=[0,0,1]}\nmass=2\ncentre=[1,0,0]\n"
      "tensor=[0,0,0]\n");
  const ProgramRun run = run_program("evaluate " + scene);
  ASSERT_EQ(run.code, 0) << run.err;
  const json a = json::parse(run.out, nullptr, false);
  EXPECT_EQ(a["driven"], json({"turn"}));
  ASSERT_EQ(a["drive_efforts"].size(), 1u);
  EXPECT_NEAR(a["drive_efforts"][0], 4, 1e-14);
}

TEST(Evaluate, BallsUseQuaternionsAndBodyRates) {
  const TestFolder folder;
  // Euler's equations: I w' = -w x I w for the free plate, I = diag(1, 2, 3), w = (1, 2, 3)
  const json a = answer(samples + "spinning_plate.toml",
                        R"({"q": [0, 0, 0, 0.5, 0.5, 0.5, 0.5], "v": [0, 0, 0, 1, 2, 3]})", folder);
  EXPECT_EQ(a["coordinates"], json({"x", "y", "z", "turn.x", "turn.y", "turn.z"}));
  const double expected[] = {-6, 3, -2. / 3};  // -(w x I w) / I with I w = (1, 4, 9)
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(a["acceleration"][3 + i], expected[i], 1e-13);
}

TEST(Evaluate, ConstraintsGiveTheirRows) {
  const TestFolder folder;
  const ProgramRun run = run_program("evaluate " + samples + "shock.toml");
  ASSERT_EQ(run.code, 0) << run.err;
  const json a = json::parse(run.out, nullptr, false);
  EXPECT_EQ(a["constraint_rows"], json({"slide"}));
  // L a + E = 0 and A a + B = Q + L^T lambda
  double residual = a["constraint_bias"][0];
  for (int j = 0; j < 2; ++j)
    residual += a["constraint_jacobian"][0][j].get<double>() * a["acceleration"][j].get<double>();
  EXPECT_NEAR(residual, 0, 1e-12);
  for (int i = 0; i < 2; ++i) {
    double left = a["bias"][i].get<double>() - a["generalized_efforts"][i].get<double>() -
                  a["constraint_jacobian"][0][i].get<double>() * a["multipliers"][0].get<double>();
    for (int j = 0; j < 2; ++j)
      left += a["mass_matrix"][i][j].get<double>() * a["acceleration"][j].get<double>();
    EXPECT_NEAR(left, 0, 1e-9);  // of 2000 N
  }
}

TEST(Evaluate, BothEquationsAgree) {
  const TestFolder folder;
  const std::string state = folder.write("state.json", R"({"q": [1, 0.4, -0.7], "v": [3, -2, 1]})");
  const std::string verb = "evaluate " + samples + "roundabout.toml --state " + state + " --equations ";
  const ProgramRun lagrange = run_program(verb + "lagrange"), recursive = run_program(verb + "recursive");
  ASSERT_EQ(lagrange.code, 0) << lagrange.err;
  const json a = json::parse(lagrange.out, nullptr, false), b = json::parse(recursive.out, nullptr, false);
  for (const char* key : {"acceleration", "bias", "generalized_efforts"})
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[key][i], b[key][i], 1e-12) << key;  // of some 10
  EXPECT_EQ(run_program(verb + "newton").code, 2);
}

TEST(Evaluate, DerivativesMatchHandCalculation) {
  // a point of m = 1 kg on l = 1 m: a = (tau - m g l sin q) / (m l^2)
  const TestFolder folder;
  const std::string state = folder.write("state.json", R"({"q": [0.3], "v": [2], "efforts": [0.5]})");
  const ProgramRun run = run_program("evaluate " + samples + "pendulum.toml --derivatives --state " + state);
  ASSERT_EQ(run.code, 0) << run.err;
  const json d = json::parse(run.out, nullptr, false)["derivatives"];
  EXPECT_NEAR(d["acceleration_by_q"][0][0], -9.81 * std::cos(0.3), 1e-14);
  EXPECT_NEAR(d["acceleration_by_v"][0][0], 0, 1e-14);
  EXPECT_NEAR(d["acceleration_by_efforts"][0][0], 1, 1e-14);
  ASSERT_EQ(d["acceleration_by_inertia"].size(), 1u);
  EXPECT_NEAR(d["acceleration_by_inertia"][0]["mass"][0], -0.5, 1e-14);  // -tau / (m l)^2
}

TEST(Evaluate, ReactionsUseTheAxesOfWorldOrParent) {
  // a point of 1 kg, 1 m out on a table that has turned by a quarter and turns at 2 rad/s: it is held up by
  // its weight and pulled in by 4 N, along the table's x, which is the world's y
  const TestFolder folder;
  const std::string scene = folder.write("table.toml", R"(gravity = [0, 0, -9.81]
[[solid]]
name = "table"
joint = [{rotation = "z", name = "spin", value_deg = 90, velocity = 2}]
mass = 3
centre = [0, 0, 0]
tensor = [1, 1, 2]
[[solid]]
name = "bob"
parent = "table"
joint = [{fixed = [1, 0, 0]}]
mass = 1
centre = [0, 0, 0]
tensor = [0, 0, 0]
)");
  for (const auto& [axes, pull] : {std::pair("world", 1), std::pair("parent", 0)}) {
    const ProgramRun run = run_program("evaluate " + scene + " --reactions-in " + axes);
    ASSERT_EQ(run.code, 0) << run.err;
    const json bob = json::parse(run.out, nullptr, false)["reactions"][1];
    EXPECT_EQ(bob["solid"], "bob");
    EXPECT_EQ(bob["parent"], "table");
    EXPECT_NEAR(bob["force"][pull], -4, 1e-12) << axes;
    EXPECT_NEAR(bob["force"][1 - pull], 0, 1e-12) << axes;
    EXPECT_NEAR(bob["force"][2], 9.81, 1e-12) << axes;
  }
  const ProgramRun refused = run_program("evaluate " + scene + " --reactions-in child");
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.err.find("child"), std::string::npos) << refused.err;
}

TEST(Evaluate, ReactionsAndMomentaMatchHandCalculation) {
  // the rod's pull is m (g cos q + l v^2), from the bob to the hinge at the origin
  const TestFolder folder;
  const std::string state = folder.write("state.json", R"({"q": [0.3], "v": [2]})");
  const ProgramRun run =
      run_program("evaluate " + samples +
                  "pendulum.toml --reactions-in world --jacobians --point bob:0,0,-0.5 --state " + state);
  ASSERT_EQ(run.code, 0) << run.err;
  const json a = json::parse(run.out, nullptr, false);
  const double s = std::sin(0.3), c = std::cos(0.3), pull = 9.81 * c + 4;
  ASSERT_EQ(a["reactions"].size(), 1u);
  EXPECT_EQ(a["reactions"][0]["solid"], "bob");
  EXPECT_EQ(a["reactions"][0]["parent"], "world");
  EXPECT_NEAR(a["reactions"][0]["force"][0], pull * s, 1e-13);
  EXPECT_NEAR(a["reactions"][0]["force"][2], pull * c, 1e-13);
  EXPECT_NEAR(a["reactions"][0]["moment"][1], 0, 1e-13);
  EXPECT_EQ(a["reactions"][0]["unique"], true);
  // the bob at -l (sin q, 0, cos q) has the velocity -l v (cos q, 0, -sin q)
  EXPECT_NEAR(a["gravity_centre"][0], -s, 1e-15);
  EXPECT_NEAR(a["linear_momentum"][0], -2 * c, 1e-14);
  EXPECT_NEAR(a["angular_momentum"][1], 0, 1e-14);  // a point
  EXPECT_NEAR(a["total_energy"], 2 - 9.81 * c, 1e-14);
  EXPECT_NEAR(a["gravity_centre_jacobian"][0][0], -c, 1e-15);
  EXPECT_NEAR(a["gravity_centre_bias"][0], 4 * s, 1e-14);
  EXPECT_NEAR(a["centroidal_momentum_matrix"][5][0], s, 1e-15);
  EXPECT_NEAR(a["points"][0]["jacobian"][2][0], 0.5 * s, 1e-15);
  EXPECT_NEAR(a["points"][0]["velocity"][0], -c, 1e-14);
  EXPECT_NEAR(a["points"][0]["bias"][2], 2 * c, 1e-14);
  for (const char* wrong : {"bob:0,0", "bob:a,0,0", "none", "bob:0,0,0,0"}) {
    const ProgramRun refused = run_program("evaluate " + samples + "pendulum.toml --point " + wrong);
    EXPECT_EQ(refused.code, 2) << wrong;
    EXPECT_NE(refused.err.find(std::string("--point ") + wrong), std::string::npos) << refused.err;
  }
}

TEST(Evaluate, BadStatesAreRefusedInOneSentence) {
  const TestFolder folder;
  const std::pair<const char*, const char*> bad[] = {
      {"{\"q\": [0, 0]}", "q is a list of 2, expected a list of 3 numbers"},
      {"{\"q\": [0, 0, \"a\"]}", "state.json: q[2] is the text \"a\", expected a number"},
      {"{\"q\": 1}", "expected a list of 3 numbers"},
      {"{\"v\": [0, 0, 0]}", "q is missing"},
      {"{\"q\": [0, 0, 0], \"u\": []}", "unknown key 'u'"},
      {"{\"t\": \"now\", \"q\": [0, 0, 0]}", "t is the text \"now\", expected a number"},
      {"{\"q\":\n [0, 0, 1e999]}", "state.json:2: the number 1e999 is too large"},
      {"{\"q\": [0, 0, 0}", "state.json:1: is not JSON: found '}'"},
      {"[1, 2]", "state.json: is a list of 2, expected {\"t\": 0"},
      {"", "state.json:1: is empty, expected JSON"}};
  for (const auto& [text, said] : bad) {
    const std::string file = folder.write("state.json", text);
    const ProgramRun run = run_program("evaluate " + samples + "roundabout.toml --state " + file);
    EXPECT_EQ(run.code, 2) << text;
    EXPECT_EQ(run.out, "");
    EXPECT_NE(run.err.find(said), std::string::npos) << text << "\n" << run.err;
  }
  const std::string file = folder.write("state.json", R"({"q": [0, 0, 0, 2, 0, 0, 0]})");
  EXPECT_EQ(run_program("evaluate " + samples + "spinning_plate.toml --state " + file).code, 2);
  EXPECT_EQ(run_program("evaluate " + samples + "roundabout.toml --state /no/state.json").code, 2);
}

TEST(Evaluate, NamesNumbersThatOverflow) {
  const TestFolder folder;
  const std::string state = folder.write("s.json", R"({"q": [1], "v": [1e200]})");
  const ProgramRun run = run_program("evaluate " + samples + "pendulum.toml --state " + state);
  EXPECT_EQ(run.code, 1);
  EXPECT_EQ(run.out, "");
  EXPECT_NE(run.err.find("pendulum.toml: bias[0] is not a finite number at this state"), std::string::npos)
      << run.err;
}

}  // namespace
}  // namespace borelli
