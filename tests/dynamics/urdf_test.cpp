// Robots in URDF, read by us and by MuJoCo: mass matrix, driving efforts and accelerations.
#include "dynamics/formats/urdf.hpp"
#include "tests/paths.hpp"

#include <gtest/gtest.h>

#include <fmt/ranges.h>

#include <map>

#include "dynamics/equations/evaluate.hpp"
#include "dynamics/formats/model_file.hpp"
#include "scenes.hpp"
#include "test_folder.hpp"
#ifdef BORELLI_MUJOCO
#include "mujoco_model.hpp"
#endif

namespace borelli::test::urdf_test {
namespace {

const std::string inertial_text =
    "<inertial><origin xyz='.1 .2 -.3' rpy='.4 -.5 1.2'/><mass value='2'/>"
    "<inertia ixx='.2' iyy='.3' izz='.4' ixy='0' ixz='0' iyz='0'/></inertial>";

std::string link_text(const std::string& name, const std::string& inside = inertial_text) {
  return "<link name='" + name + "'>" + inside + "</link>";
}

std::string joint_text(const std::string& name, const std::string& type, const std::string& parent,
                       const std::string& child, const std::string& inside = "") {
  return fmt::format(
      "<joint name='{}' type='{}'><parent link='{}'/><child link='{}'/>"
      "<origin xyz='.3 .1 -.2' rpy='.3 .2 -1'/>{}</joint>",
      name, type, parent, child, inside);
}

// izz > ixx + iyy: no body has such moments
std::string impossible_text(double mass, double moment = 1) {
  return fmt::format(
      "<inertial><mass value='{}'/><inertia ixx='{}' iyy='{}' izz='{}' ixy='0' ixz='0' iyz='0'/></inertial>",
      mass, moment, moment, 3 * moment);
}

std::string robot(const std::string& inside) { return "<robot name='r'>" + inside + "</robot>"; }

ModelFile read_text(const std::string& xml, const ModelOptions& options = {}) {
  const Folder folder;
  return need(read_model(folder.write("robot.urdf", xml), options));
}

bool any_holds(const std::vector<std::string>& lines, const std::string& part) {
  return std::any_of(lines.begin(), lines.end(),
                     [&](const std::string& line) { return line.find(part) != std::string::npos; });
}

#ifdef BORELLI_MUJOCO
// MuJoCo orders joints depth first, we by the file; coordinates are matched by name.
void expect_same(const std::string& xml) {
  const Folder folder;
  const auto path = folder.write("robot.urdf", xml);
  const System system = compiled(need(read_model(path)).scene);
  Mujoco mujoco(path);
  Order order;
  const auto add = [&](const std::string& name) {
    for (const CoordinateInfo& c : system.coordinates) {
      if (c.name != name) continue;
      for (int i = 0; i < c.q_size; ++i) order.q.push_back(c.q_index + i);
      for (int i = 0; i < c.v_size; ++i) order.v.push_back(c.v_index + i);
    }
  };
  for (int j = 0; j < mujoco.model->njnt; ++j) {
    const std::string name = mujoco.model->names + mujoco.model->name_jntadr[j];
    if (mujoco.model->jnt_type[j] != mjJNT_FREE) {
      add(name);
      continue;
    }
    for (const char* part : {".x", ".y", ".z", ".turn"}) add(name + part);
  }
  ASSERT_EQ(int(order.q.size()), system.nq);
  const Differences d = differences(system, mujoco, 1, order);
  // all inertias are principal moments, which MuJoCo keeps to rounding
  EXPECT_LT(d.A, 1e-12);
  EXPECT_LT(d.drive, 1e-12);
  EXPECT_LT(d.acceleration, 1e-10);  // the condition of A carries rounding into it
}

TEST(Urdf, ReadsAllScalarJointsInAnyOrder) {
  expect_same(robot(
      link_text("tip") + link_text("base") + link_text("arm") + link_text("slider") + link_text("plate") +
      joint_text("last", "prismatic", "arm", "tip",
                 "<axis xyz='1 2 3'/><limit lower='-1' upper='1' "
                 "effort='5' velocity='2'/><dynamics damping='.7' friction='0'/>") +
      joint_text("turn", "continuous", "base", "arm", "<axis xyz='0 1 1'/>") +
      joint_text("hinge", "revolute", "base", "slider",
                 "<limit lower='-1' upper='1' effort='5' velocity='2'/><dynamics damping='.3'/>") +
      joint_text("stuck", "fixed", "slider", "plate")));
}

TEST(Urdf, ReadsAFloatingJoint) {
  expect_same(robot(link_text("world", "") + link_text("base") + link_text("arm") +
                    joint_text("hinge", "continuous", "base", "arm", "<axis xyz='0 1 0'/>") +
                    "<joint name='free' type='floating'><parent link='world'/><child link='base'/></joint>"));
}

TEST(Urdf, ReadsBenchmarkFiles) {
  for (const char* name : {"roundabout", "chain3d7", "bars7"}) {
    const std::filesystem::path path = test::shared_folder() + "/models/bench/" + name + ".urdf";
    if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
    std::ifstream file(path);
    expect_same({std::istreambuf_iterator<char>(file), {}});
  }
}
#endif

TEST(Urdf, CoordinatesFollowTheFileOrder) {
  const Scene scene = read_text(robot(link_text("tip") + link_text("base") + link_text("arm") +
                                      joint_text("last", "continuous", "arm", "tip") +
                                      joint_text("first", "continuous", "base", "arm")))
                          .scene;
  ASSERT_EQ(scene.solids.size(), 3u);
  EXPECT_EQ(scene.solids[0].name, "base");
  EXPECT_TRUE(scene.solids[0].switches.empty());  // fixed to the world
  EXPECT_EQ(scene.solids[1].name, "tip");         // from the first joint
  EXPECT_EQ(scene.solids[2].name, "arm");
}

TEST(Urdf, FloatingRootFallsFreely) {
  const System system = compiled(read_text(robot(link_text("base")), {.floating = true}).scene);
  ASSERT_EQ(system.nq, 7);
  EXPECT_EQ(system.coordinates[3].name, "base.turn");
  const Eigen::VectorXd a = need(evaluate(system, system.initial)).acceleration;
  EXPECT_NEAR((a.head<3>() - Vector3d(0, 0, -9.81)).norm() + a.tail<3>().norm(), 0, 1e-13);
}

TEST(Urdf, PlanarJointMovesAcrossItsAxis) {
  const System system = compiled(read_text(robot(link_text("base") + link_text("plate") +
                                                 "<joint name='p' type='planar'><parent link='base'/><child "
                                                 "link='plate'/><axis xyz='1 0 0'/></joint>"))
                                     .scene);
  ASSERT_EQ(system.nq, 3);
  // 2 kg that slide in both directions across x, and a turn about x
  const Rows A = need(evaluate(system, system.initial)).mass_matrix;
  EXPECT_NEAR(A(0, 0), 2, 1e-14);
  EXPECT_NEAR(A(1, 1), 2, 1e-14);
  EXPECT_NEAR(A(0, 1), 0, 1e-14);
  EXPECT_EQ(system.coordinates[2].name, "p.turn");
}

TEST(Urdf, MimicCouplesJoints) {
  Scene scene =
      read_text(robot(link_text("base") + link_text("a") + link_text("b") +
                      joint_text("ja", "continuous", "base", "a", "<axis xyz='0 1 0'/>") +
                      joint_text("jb", "continuous", "base", "b",
                                 "<axis xyz='0 1 0'/><mimic joint='ja' multiplier='-2' offset='.3'/>")))
          .scene;
  scene.simulation.end_time = 0.3;
  const Trajectory t = need(simulate(compiled(scene)));
  const Eigen::VectorXd q = last(t.q);
  EXPECT_EQ(t.q(0, 0), 0);  // the leader starts where it would alone
  EXPECT_EQ(t.q(0, 1), 0.3);
  EXPECT_GT(std::abs(q[0]), 0.01);  // it moves
  EXPECT_NEAR(q[1], -2 * q[0] + 0.3, 1e-9);
  EXPECT_TRUE(t.certificate.trusted) << t.certificate.reason;
}

TEST(Urdf, ReadsLimitsAndShapesAndListsTheRest) {
  const ModelFile model = read_text(robot(
      link_text("base", inertial_text +
                            "<visual><origin xyz='1 0 0'/><geometry><box size='1 2 3'/></geometry></visual>"
                            "<visual><geometry><mesh filename='package://x/y.dae'/></geometry></visual>"
                            "<collision><geometry><sphere radius='1'/></geometry></collision>") +
      link_text("arm", inertial_text + "<collision><geometry><sphere radius='1'/></geometry></collision>") +
      joint_text(
          "j", "revolute", "base", "arm",
          "<limit lower='.2' upper='.5' effort='3' velocity='1'/><dynamics damping='1' friction='.1'/>") +
      "<transmission name='t'/><gazebo><mu1>1</mu1><material>Red</material></gazebo>"));
  const Scene& scene = model.scene;
  ASSERT_EQ(scene.solids[0].shapes.size(), 1u);
  EXPECT_EQ(std::get<Box>(scene.solids[0].shapes[0].shape.form).size, Vector3d(1, 2, 3));
  EXPECT_TRUE(std::holds_alternative<Sphere>(scene.solids[1].shapes.at(0).shape.form));
  const Switch& joint = scene.solids[1].switches.back();
  EXPECT_EQ(joint.ranges.at(0).upper, .5);
  EXPECT_EQ(joint.q, std::vector{.2});  // 0 lies outside
  const NotModelled& found = model.not_modelled;
  for (const char* part : {"starts at 0.2", "friction of <dynamics>: at", "contacts of 2 <collision>",
                           "<transmission> in <robot>: at", "<mu1> in <gazebo>: at"})
    EXPECT_TRUE(any_holds(found.motion, part)) << part << "\n"
                                               << fmt::format("{}", fmt::join(found.motion, "\n"));
  EXPECT_EQ(found.motion.size(), 5u) << fmt::format("{}", fmt::join(found.motion, "\n"));
  for (const char* part :
       {"(effort, velocity)", "<mesh> in <geometry>", "<gazebo> in <robot> with 1 <material>"})
    EXPECT_TRUE(any_holds(found.other, part)) << part << "\n"
                                              << fmt::format("{}", fmt::join(found.other, "\n"));
  EXPECT_EQ(found.other.size(), 3u) << fmt::format("{}", fmt::join(found.other, "\n"));
}

bool lists(const ModelFile& model, const std::string& part) {
  return any_holds(model.not_modelled.motion, part) || any_holds(model.not_modelled.other, part);
}

Rows mass_matrix(const ModelFile& model) {
  const System system = compiled(model.scene);
  return need(evaluate(system, system.initial)).mass_matrix;
}

TEST(Urdf, IgnoresImpossibleInertiasOfFixedLinks) {
  const std::string hinge = joint_text("j", "continuous", "base", "arm", "<axis xyz='0 0 1'/>");
  const Rows alone = mass_matrix(read_text(robot(link_text("base", "") + link_text("arm") + hinge)));
  const ModelFile fixed = read_text(robot(link_text("base", impossible_text(1)) + link_text("arm") +
                                          link_text("eye", impossible_text(0)) + hinge +
                                          joint_text("f", "fixed", "base", "eye")));
  EXPECT_EQ(mass_matrix(fixed)(0, 0), alone(0, 0));
  EXPECT_TRUE(lists(fixed, "impossible inertias of links fixed to the world: base, eye"));
}

// An impossible link on a fixed joint adds its mass and moments to a body that stays possible as a whole.
TEST(Urdf, JudgesLinksOnFixedJointsAsOneBody) {
  const ModelFile model = read_text(robot(
      link_text("base", "") +
      link_text("arm",
                "<inertial><mass value='2'/><inertia ixx='.4' iyy='.4' izz='.4'"
                "/></inertial>") +
      link_text("eye", impossible_text(.5, .01)) +
      joint_text("j", "continuous", "base", "arm", "<axis xyz='0 0 1'/>") +
      "<joint name='f' type='fixed'><parent link='arm'/><child link='eye'/><origin xyz='1 2 3'/></joint>"));
  EXPECT_NEAR(mass_matrix(model)(0, 0), .4 + .03 + .5 * (1 + 4), 1e-14);
  EXPECT_TRUE(lists(model, "added to 'arm', with which they move: eye"));
  ASSERT_EQ(model.scene.solids.size(), 3u);  // the eye keeps its name and pose
}

TEST(Urdf, MinimumMassMakesAPlaceholderBaseFloat) {
  const std::string ones = "ixx='1e-6' iyy='1e-6' izz='1e-6' ixy='1e-6' ixz='1e-6' iyz='1e-6'";
  const std::string xml =
      robot(link_text("base", "<inertial><mass value='1e-6'/><inertia " + ones + "/></inertial>") +
            link_text("arm") + joint_text("j", "continuous", "base", "arm"));
  EXPECT_EQ(compiled(read_text(xml).scene).nv, 1);
  const Folder folder;
  const auto refused = read_model(folder.write("robot.urdf", xml), {.floating = true});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message().find("of link 'base': inertia tensor violates"), std::string::npos)
      << refused.error().message();
  EXPECT_NE(refused.error().message().find("--minimum-mass"), std::string::npos) << refused.error().message();
  const ModelFile model = read_text(xml, {.floating = true, .minimum_mass = .1});
  EXPECT_TRUE(lists(model, "links lighter than 0.1 kg, each replaced by a ball of water of that mass: base"));
  const Rows A = mass_matrix(model);
  EXPECT_NEAR(A(0, 0), 2.1, 1e-14);
  // the ball's radius: m = 4/3 pi r^3 1000
  const Inertial& ball = model.scene.solids[0].inertials.at(0);
  EXPECT_NEAR(ball.tensor(0, 0), .4 * .1 * std::pow(.1 / (4. / 3 * M_PI * 1000), 2. / 3), 1e-18);
}

TEST(Urdf, LocksMasslessFingersThatCarryNoMass) {
  const std::string hand = link_text("base") + link_text("arm") +
                           joint_text("j", "continuous", "base", "arm", "<axis xyz='0 1 0'/>");
  const std::string fingers =
      link_text("finger", "") + link_text("tip", "") + link_text("thumb", impossible_text(0)) +
      joint_text("curl", "revolute", "arm", "finger", "<limit lower='.5' upper='1'/>") +
      joint_text("bend", "continuous", "finger", "tip", "<mimic joint='j' multiplier='2'/>") +
      joint_text("thumb", "prismatic", "arm", "thumb", "<limit lower='0' upper='1'/>");
  const ModelFile model = read_text(robot(hand + fingers));
  EXPECT_TRUE(lists(
      model, "coordinates that move no mass, locked (--minimum-mass gives them mass): curl, bend, thumb"));
  EXPECT_TRUE(lists(model, "moments of inertia without mass, ignored: thumb"));
  const System system = compiled(model.scene);
  EXPECT_EQ(system.nv, 1);
  EXPECT_EQ(system.rows, 0);  // the mimic no longer holds the arm
  EXPECT_EQ(mass_matrix(model)(0, 0), mass_matrix(read_text(robot(hand)))(0, 0));
  EXPECT_EQ(compiled(read_text(robot(hand + fingers), {.minimum_mass = .01}).scene).nv, 4);
}

// A massless joint that a mimic with mass follows stays free: a lock would stop the mimic too.
TEST(Urdf, DoesNotLockAMimickedJoint) {
  const ModelFile model =
      read_text(robot(link_text("base") + link_text("knob", "") + link_text("arm") +
                      joint_text("turn", "continuous", "base", "knob") +
                      joint_text("j", "continuous", "base", "arm", "<mimic joint='turn'/>")));
  const auto system = compile(model.scene);
  ASSERT_FALSE(system);
  EXPECT_NE(system.error().message().find("moves no mass"), std::string::npos) << system.error().message();
}

TEST(Urdf, LockedJointEqualsAFixedOne) {
  const auto arm = [](const char* type) {
    return robot(link_text("base") + link_text("upper") + link_text("lower") + link_text("hand") +
                 joint_text("j1", "continuous", "base", "upper") +
                 joint_text("j2", type, "upper", "lower", "<axis xyz='0 1 0'/>") +
                 joint_text("j3", "continuous", "lower", "hand", "<axis xyz='0 0 1'/>"));
  };
  const Rows locked = mass_matrix(read_text(arm("continuous"), {.locked = {"j2"}})),
             fixed = mass_matrix(read_text(arm("fixed")));
  ASSERT_EQ(locked.rows(), 2);
  EXPECT_LT((locked - fixed).cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_EQ(compiled(read_text(arm("planar"), {.locked = {"j2"}}).scene).nv,
            2);  // all three of its coordinates
  const Folder folder;
  const auto wrong = read_model(folder.write("robot.urdf", arm("continuous")), {.locked = {"j4"}});
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().message().find(
                "--lock j4: there is no free coordinate of this name; choose from: j1, j2, j3"),
            std::string::npos)
      << wrong.error().message();
}

TEST(Urdf, MimicsStartWhereTheirLeadersAre) {
  // the last follows a follower, which the file names later; the first leader starts at its lower limit
  const System system = compiled(
      read_text(robot(link_text("base") + link_text("a") + link_text("b") + link_text("c") +
                      joint_text("jc", "continuous", "base", "c", "<mimic joint='jb' offset='1'/>") +
                      joint_text("jb", "continuous", "base", "b", "<mimic joint='ja' multiplier='-2'/>") +
                      joint_text("ja", "revolute", "base", "a", "<limit lower='.1' upper='.5'/>")))
          .scene);
  std::map<std::string, double> starts;
  for (const CoordinateInfo& info : system.coordinates) starts[info.name] = system.initial.q[info.q_index];
  ASSERT_EQ(starts.size(), 3u);
  for (const auto& [name, start] : {std::pair{"ja", 0.1}, {"jb", -0.2}, {"jc", 0.8}})
    EXPECT_DOUBLE_EQ(starts.at(name), start) << name;
}

// Robots in which the mimic or the joint that it follows is fixed.
TEST(Urdf, ReadsMimicsOfFixedJoints) {
  const std::string links = link_text("base") + link_text("a") + link_text("b");
  EXPECT_EQ(compiled(read_text(robot(links + joint_text("ja", "continuous", "base", "a") +
                                     joint_text("jb", "fixed", "base", "b", "<mimic joint='ja'/>")))
                         .scene)
                .rows,
            0);
  const System held = compiled(read_text(robot(links + joint_text("ja", "fixed", "base", "a") +
                                               joint_text("jb", "continuous", "base", "b",
                                                          "<mimic joint='ja' multiplier='2' offset='.3'/>")))
                                   .scene);
  EXPECT_EQ(held.rows, 1);
}

TEST(Urdf, ToleratesEmptyVisualsAndReversedLimits) {
  const ModelFile model = read_text(
      robot(link_text("arm", inertial_text + "<visual><geometry><box size='0 0 0'/></geometry></visual>") +
            joint_text("j", "revolute", "world", "arm", "<limit lower='1' upper='-1'/>")));
  EXPECT_TRUE(lists(model, "shapes without a size: 1 times"));
  EXPECT_TRUE(lists(model, "limits of joint 'j', from 1 to -1"));
  EXPECT_TRUE(model.scene.solids.at(0).switches.back().ranges.empty());
  EXPECT_EQ(model.scene.solids[0].parent, "world");  // a parent that the file names without a <link>
}

TEST(Urdf, ListsElementsOfOtherPrograms) {
  const ModelFile model = read_text(robot(
      link_text("base", inertial_text + "<gravity/><audio_source/>") + link_text("arm") +
      "<frame name='f'/>" +
      joint_text("j", "continuous", "base", "arm", "<axis xyz='0 1 0'/><joint_properties damping='1'/>")));
  for (const char* part : {"<gravity> in <link>", "<audio_source> in <link>", "<frame> in <robot>",
                           "<joint_properties> in <joint>"})
    EXPECT_TRUE(lists(model, part)) << part;
}

TEST(Urdf, BadFilesAreRefusedInOneSentence) {
  const std::string base = link_text("base"), arm = link_text("arm");
  const std::pair<std::string, const char*> bad[] = {
      {"<robot name='r'>",
       "robot.urdf:1: is not well-formed XML: the file ends before its root element does"},
      {"<robot>\n<link name='a'>\n<inertial>\n</link></robot>",
       "robot.urdf:4: is not well-formed XML: an end tag has another name"},
      {robot(""), "robot.urdf:1: robot 'r': has no <link>"},
      {robot("<xacro:macro name='m'/>"), "is xacro"},
      {robot(base + "<link name='base'/>"), "has the name of another one"},
      {robot(base + arm), "several roots"},
      {robot(base + arm + "<joint name='j' type='fixed'><parent link='world'/><child link='arm'/></joint>"),
       "robot.urdf:1: link"},
      {robot(base + joint_text("j", "revolute", "base", "leg")), "there is no link named 'leg'"},
      {robot(base + arm + joint_text("j", "twist", "base", "arm")),
       "type is 'twist', expected one of: fixed"},
      {robot(base + arm + joint_text("j", "fixed", "base", "arm") + joint_text("k", "fixed", "base", "arm")),
       "link 'arm' is also the child of joint 'j'"},
      {robot(base + arm + link_text("leg") + joint_text("j", "fixed", "leg", "arm") +
             joint_text("k", "fixed", "arm", "leg")),
       "is its own ancestor"},
      {robot(base + arm + joint_text("j", "continuous", "base", "arm", "<axis xyz='0 0 0'/>")),
       "xyz has no direction"},
      {robot(base + arm + joint_text("j", "continuous", "base", "arm", "<axis xyz='0 0'/>")),
       "xyz contains 2 numbers, expected 3"},
      {robot(base + arm + joint_text("j", "continuous", "base", "arm", "<axis xyz='0 0 nan'/>")),
       "xyz contains 'nan', expected finite numbers"},
      {robot(base + arm + joint_text("j", "continuous", "base", "arm", "<mimic joint='q'/>")),
       "'q' is not a joint"},
      {robot(base + arm + joint_text("j", "continuous", "base", "arm", "<dynamics damping='-1'/>")),
       "damping is -1"},
      {robot(link_text("base", "<inertial><mass value='1'/></inertial>")), "has no <inertia>"},
      {robot(link_text("base", "<inertial><mass value='-1'/><inertia ixx='1' iyy='1' izz='1'/></inertial>")),
       "of link 'base'"},
      {robot(base + link_text("arm", impossible_text(1)) + joint_text("j", "continuous", "base", "arm")),
       "of link 'arm': inertia tensor violates the triangle inequality"},
      {robot(link_text("base", "<visual><geometry><sphere/></geometry></visual>")), "radius is missing"}};
  for (const auto& [xml, said] : bad) {
    const Folder folder;
    const auto model = read_model(folder.write("robot.urdf", xml));
    ASSERT_FALSE(model) << xml;
    EXPECT_NE(model.error().message().find(said), std::string::npos) << xml << "\n"
                                                                     << model.error().message();
    EXPECT_NE(model.error().where.find("robot.urdf:"), std::string::npos) << model.error().message();
  }
}

// A walk from each link up to the root would take quadratic time.
TEST(Urdf, ReadsLongChainsInLinearTime) {
  const int n = 30000;
  std::string text = link_text("l0");
  for (int i = 1; i < n; ++i)
    text += link_text(fmt::format("l{}", i)) +
            joint_text(fmt::format("j{}", i), "continuous", fmt::format("l{}", i - 1), fmt::format("l{}", i));
  const Scene scene = read_text(robot(text)).scene;
  ASSERT_EQ(scene.solids.size(), std::size_t(n));
  EXPECT_EQ(scene.solids.back().parent, fmt::format("l{}", n - 2));
  const Folder folder;
  const auto circle = read_model(folder.write(
      "robot.urdf",
      robot(text + link_text("root") + joint_text("j0", "continuous", fmt::format("l{}", n - 1), "l0"))));
  ASSERT_FALSE(circle);
  EXPECT_NE(circle.error().message().find("is its own ancestor"), std::string::npos);
}

}  // namespace
}  // namespace borelli::test::urdf_test
