// Models in MJCF and URDF through the verbs evaluate, simulate and info.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <tuple>

#include "process/input_file.hpp"
#include "program_run.hpp"
#include "tests/paths.hpp"

namespace borelli {
namespace {

using nlohmann::json;

// the tip's joint comes first, so the file's order differs from the tree's
const std::string arm_urdf =
    "<robot name='arm'><link name='base'/><link name='upper'><inertial><origin xyz='0 0 -1'/><mass "
    "value='1'/>"
    "<inertia ixx='0' iyy='0' izz='0'/></inertial></link><link name='lower'><inertial><origin xyz='0 0 -1'/>"
    "<mass value='2'/><inertia ixx='0' iyy='0' izz='0'/></inertial></link>"
    "<joint name='elbow' type='continuous'><parent link='upper'/><child link='lower'/><origin xyz='0 0 -1'/>"
    "<axis xyz='0 1 0'/></joint>"
    "<joint name='shoulder' type='revolute'><parent link='base'/><child link='upper'/><axis xyz='0 1 0'/>"
    "<limit lower='-3' upper='3' effort='9' velocity='9'/></joint></robot>";

const std::string spinner_mjcf =
    "<mujoco><option gravity='0 0 0'/><worldbody><body name='plate' pos='1 2 3'><freejoint name='root'/>"
    "<inertial pos='0 0 0' mass='2' diaginertia='1 2 "
    "3'/></body></worldbody><actuator><motor/></actuator></mujoco>";

json said(const ProgramRun& run) {
  EXPECT_EQ(run.code, 0) << run.err;
  return json::parse(run.out, nullptr, false);
}

TEST(ModelVerbs, EvaluateKeepsUrdfsOrderOfJoints) {
  const TestFolder folder;
  const std::string file = folder.write("arm.urdf", arm_urdf);
  const std::string state = folder.write("s.json", R"({"q": [0.5, 0.2], "v": [1, -2], "efforts": [0, 3]})");
  const json a = said(run_program("evaluate " + file + " --state " + state));
  ASSERT_EQ(a["coordinates"], json({"elbow", "shoulder"}));
  // the double pendulum of point masses (1 kg, 2 kg, rods of 1 m) by hand: A is m2 for the elbow, m1 + m2 (2
  // + 2 cos) for the shoulder, m2 (1 + cos) between them
  const double c = std::cos(0.5), s = std::sin(0.5), g = 9.81;
  EXPECT_NEAR(a["mass_matrix"][0][0], 2, 1e-14);
  EXPECT_NEAR(a["mass_matrix"][0][1], 2 * (1 + c), 1e-14);
  EXPECT_NEAR(a["mass_matrix"][1][1], 1 + 2 * (2 + 2 * c), 1e-14);
  EXPECT_NEAR(a["bias"][0], 2 * s * 4, 1e-14);                  // m2 sin(q) w_shoulder^2
  EXPECT_NEAR(a["bias"][1], -2 * s * (1 + 2 * 1 * -2), 1e-14);  // -m2 sin(q) (w_e^2 + 2 w_e w_s)
  EXPECT_NEAR(a["generalized_efforts"][0], -2 * g * std::sin(0.7), 1e-13);
  EXPECT_NEAR(a["generalized_efforts"][1], 3 - g * (3 * std::sin(0.2) + 2 * std::sin(0.7)), 1e-13);
  EXPECT_TRUE(a["not_modelled"]["changes_motion"].empty());
  ASSERT_EQ(a["not_modelled"]["other"].size(), 1u);
  EXPECT_NE(a["not_modelled"]["other"][0].get<std::string>().find("(effort, velocity)"), std::string::npos);
}

TEST(ModelVerbs, EvaluateAcceptsMjcfsFreeJoint) {
  const TestFolder folder;
  const std::string file = folder.write("plate.xml", spinner_mjcf);
  const std::string state = folder.write(
      "s.json",
      R"({"q": [0, 0, 0, 0.5, 0.5, 0.5, 0.5], "v": [4, 5, 6, 1, 2, 3], "efforts": [2, 4, 6, 0, 0, 0]})");
  const json a = said(run_program("evaluate " + file + " --state " + state));
  // linear, world axes: F / m; angular, body axes: Euler's equations, -(w x I w) / I
  const double expected[] = {1, 2, 3, -6, 3, -2. / 3};
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(a["acceleration"][i], expected[i], 1e-13) << i;
  EXPECT_NEAR(a["kinetic_energy"], (16 + 25 + 36) + 0.5 * (1 + 8 + 27), 1e-12);
}

TEST(ModelVerbs, FilesThatAreNoScenesAreRefusedInOneSentence) {
  const TestFolder folder;
  using namespace std::string_literals;
  for (const auto& [name, bytes, said] : {
           std::tuple{"empty.toml", ""s, "contains no solid"},
           {"settings.toml", "[simulation]\nend_time = 1.0\n"s, "contains no solid"},
           {"scan.nii.gz", "\x1f\x8b\x08\0\0\0\0\0"s, "is not a scene but a compressed file"},
           {"motion.h5", "\x89HDF\r\n\x1a\n\0\0"s, "is not a scene but an HDF5 file"},
           {"scan.nii", "\x5c\x01\0\0"s, "is not a scene but a binary file"},
       }) {
    const std::string file = folder.write(name, bytes);
    const ProgramRun run = run_program("simulate " + file);
    EXPECT_EQ(run.code, 2) << name;
    EXPECT_TRUE(run.err.starts_with("borelli: " + file + ": " + said)) << run.err;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  }
}

TEST(ModelVerbs, SimulateAndInfoSayWhatIsNotModelled) {
  const TestFolder folder;
  const std::string file = folder.write("plate.xml", spinner_mjcf);
  const std::string line = "warning: not modelled, so the motion differs: <motor> in <actuator>: at ";
  for (const char* verb : {"info ", "simulate "}) {
    const ProgramRun run = run_program(verb + file);
    EXPECT_EQ(run.code, 0) << run.err;
    EXPECT_NE(run.err.find(line), std::string::npos) << run.err;
    EXPECT_EQ(said(run_program(verb + file + " --json"))["not_modelled"]["changes_motion"].size(), 1u);
  }
  // a trajectory stores the scene as TOML, whatever format it was read from
  const std::string output = folder / "motion.h5";
  EXPECT_EQ(run_program("simulate " + file + " -o " + output).code, 0);
  EXPECT_EQ(said(run_program("info --json " + output))["solids"], json({"plate"}));
  // a page lists it among its warnings, not in the certificate
  const std::string page = folder / "motion.html";
  EXPECT_EQ(run_program("simulate " + file + " -o " + page).code, 0);
  const std::string html = read_input_file(page).value_or("");
  EXPECT_NE(html.find("<p class=\"notice\">Warning: not modelled, so the motion differs"), html.npos);
  EXPECT_EQ(html.find("\"warning: not modelled"), html.npos);
}

TEST(ModelVerbs, FallingMjcfBodyLands) {
  const TestFolder folder;
  const auto model = [&](const std::string& geom) {
    return folder.write("m.xml",
                        "<mujoco><worldbody><geom type='plane' size='1 1 1'/><body name='b' pos='0 0 "
                        ".5'><freejoint/>" +
                            geom + "</body></worldbody></mujoco>");
  };
  const std::string ball = model("<geom size='.1'/>");
  for (const char* method : {"", " --method rk4_adaptive", " --method moreau --step 0.01"}) {
    const json a = said(run_program("simulate --json " + ball + method));
    EXPECT_EQ(a["certificate"]["method"], *method && method[10] == 'r' ? "rk4_adaptive" : "moreau");
    EXPECT_NEAR(a["end"]["q"][2], 0.1, 1e-6) << method;
  }
  // loads at rows need forces, which time stepping by impulses does not give
  const std::string to = " -o " + (folder / "loads.csv").string() + " ";
  EXPECT_EQ(run_program("simulate --reactions --method rk4_adaptive" + to + ball).code, 0);
  const ProgramRun loads = run_program("simulate --reactions" + to + ball);
  EXPECT_EQ(loads.code, 2);
  EXPECT_NE(loads.err.find("cannot be computed for a run with moreau"), std::string::npos) << loads.err;
  // a cylinder that falls upright lands on its end
  const std::string upright = model("<geom type='cylinder' size='.1 .2'/>");
  const json tin = said(run_program("simulate --json " + upright));
  EXPECT_TRUE(tin["certificate"]["trusted"]);
  EXPECT_NEAR(tin["end"]["q"][2], 0.2, 1e-6);
  // height fields have no contact, and a note says so
  const std::string field = folder.write(
      "field.xml",
      "<mujoco><asset><hfield name='h' nrow='2' ncol='2' size='1 1 .1 .1'/></asset><worldbody><geom "
      "type='hfield' "
      "hfield='h'/><body pos='0 0 .5'><freejoint/><geom size='.1'/></body></worldbody></mujoco>");
  const ProgramRun run = run_program("simulate " + field);
  EXPECT_NE(run.err.find("not modelled, so the motion differs: contacts of 1 pairs of geoms"),
            std::string::npos)
      << run.err;
}

TEST(ModelVerbs, FloatingFlagFreesTheRoot) {
  const TestFolder folder;
  const std::string file = folder.write("arm.urdf", arm_urdf);
  EXPECT_EQ(said(run_program("info --json " + file))["degrees_of_freedom"], 2);
  EXPECT_EQ(said(run_program("info --json --floating " + file))["degrees_of_freedom"], 8);
  EXPECT_EQ(run_program("info --floating " + test::source_folder() + "/samples/pendulum.toml").code, 2);
}

TEST(ModelVerbs, BadModelsGiveOneSentenceAndCodeTwo) {
  const TestFolder folder;
  for (const char* verb : {"info ", "evaluate ", "simulate "})
    for (const char* text :
         {"<mujoco><worldbody>", "<mujoco><wordbody/></mujoco>", "<robot/>", "<html/>", ""}) {
      const ProgramRun run = run_program(verb + folder.write("bad.xml", text).string());
      EXPECT_EQ(run.code, 2) << verb << text;
      EXPECT_NE(run.err.find("bad.xml:1"), std::string::npos) << run.err;
      EXPECT_EQ(run.out, "") << run.out;
    }
}

}  // namespace
}  // namespace borelli
