// Robots in URDF, read by us and by MuJoCo (which reads URDF too): mass matrix, what drives, accelerations.
#include "dynamics/urdf.hpp"
#include "tests/paths.hpp"

#include <gtest/gtest.h>

#include <fmt/ranges.h>

#include "dynamics/evaluate.hpp"
#include "dynamics/model_file.hpp"
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

std::string robot(const std::string& inside) { return "<robot name='r'>" + inside + "</robot>"; }

ModelFile read_text(const std::string& xml, const ModelOptions& options = {}) {
  const Folder folder;
  return need(read_model(folder.write("robot.urdf", xml), options));
}

#ifdef BORELLI_MUJOCO
// MuJoCo has the joints depth first, we in the order of the file: its n-th position is ours of the same name.
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
  // all inertias are given by principal moments, which MuJoCo finds to rounding
  EXPECT_LT(d.A, 1e-12);
  EXPECT_LT(d.drive, 1e-12);
  EXPECT_LT(d.acceleration, 1e-10);  // the condition of A carries rounding into it
}

TEST(Urdf, TreeOfAllScalarJointsInAnyOrder) {
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

TEST(Urdf, FloatingJoint) {
  expect_same(robot(link_text("world", "") + link_text("base") + link_text("arm") +
                    joint_text("hinge", "continuous", "base", "arm", "<axis xyz='0 1 0'/>") +
                    "<joint name='free' type='floating'><parent link='world'/><child link='base'/></joint>"));
}

TEST(Urdf, BenchmarkFiles) {
  for (const char* name : {"roundabout", "chain3d7", "bars7"}) {
    const std::filesystem::path path = test::shared_folder() + "/models/bench/" + name + ".urdf";
    if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
    std::ifstream file(path);
    expect_same({std::istreambuf_iterator<char>(file), {}});
  }
}
#endif

TEST(Urdf, CoordinatesAreTheJointsInFileOrder) {
  const Scene scene = read_text(robot(link_text("tip") + link_text("base") + link_text("arm") +
                                      joint_text("last", "continuous", "arm", "tip") +
                                      joint_text("first", "continuous", "base", "arm")))
                          .scene;
  ASSERT_EQ(scene.solids.size(), 3u);
  EXPECT_EQ(scene.solids[0].name, "base");
  EXPECT_TRUE(scene.solids[0].switches.empty());  // fixed to the world
  EXPECT_EQ(scene.solids[1].name, "tip");         // of the joint that stands first
  EXPECT_EQ(scene.solids[2].name, "arm");
}

TEST(Urdf, ARootThatFloatsFallsFreely) {
  const System system = compiled(read_text(robot(link_text("base")), {.floating = true}).scene);
  ASSERT_EQ(system.nq, 7);
  EXPECT_EQ(system.coordinates[3].name, "base.turn");
  const Eigen::VectorXd a = need(evaluate(system, system.initial)).acceleration;
  EXPECT_NEAR((a.head<3>() - Vector3d(0, 0, -9.81)).norm() + a.tail<3>().norm(), 0, 1e-13);
}

TEST(Urdf, APlanarJointMovesAcrossItsAxis) {
  const System system = compiled(read_text(robot(link_text("base") + link_text("plate") +
                                                 "<joint name='p' type='planar'><parent link='base'/><child "
                                                 "link='plate'/><axis xyz='1 0 0'/></joint>"))
                                     .scene);
  ASSERT_EQ(system.nq, 3);
  // two kg that slide across x: one direction is vertical and falls, the other not; the turn about x moves
  // the centre
  const Rows A = need(evaluate(system, system.initial)).mass_matrix;
  EXPECT_NEAR(A(0, 0), 2, 1e-14);
  EXPECT_NEAR(A(1, 1), 2, 1e-14);
  EXPECT_NEAR(A(0, 1), 0, 1e-14);
  EXPECT_EQ(system.coordinates[2].name, "p.turn");
}

TEST(Urdf, MimicTiesJoints) {
  Scene scene =
      read_text(robot(link_text("base") + link_text("a") + link_text("b") +
                      joint_text("ja", "continuous", "base", "a", "<axis xyz='0 1 0'/>") +
                      joint_text("jb", "continuous", "base", "b",
                                 "<axis xyz='0 1 0'/><mimic joint='ja' multiplier='-2' offset='.3'/>")))
          .scene;
  scene.simulation.end_time = 0.3;
  const Trajectory t = need(simulate(compiled(scene)));
  const Eigen::VectorXd q = last(t.q);
  EXPECT_GT(std::abs(q[0]), 0.01);  // it moves
  EXPECT_NEAR(q[1], -2 * q[0] + 0.3, 1e-9);
  EXPECT_TRUE(t.certificate.trusted) << t.certificate.reason;
}

TEST(Urdf, LimitsShapesAndWhatIsNotModelled) {
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
  const auto listed = [](const std::vector<std::string>& lines, const std::string& part) {
    return std::any_of(lines.begin(), lines.end(),
                       [&](const std::string& line) { return line.find(part) != std::string::npos; });
  };
  const NotModelled& found = model.not_modelled;
  for (const char* part : {"starts at 0.2", "friction of <dynamics>: at", "contacts of 2 <collision>",
                           "<transmission> in <robot>: at", "<mu1> in <gazebo>: at"})
    EXPECT_TRUE(listed(found.motion, part)) << part << "\n"
                                            << fmt::format("{}", fmt::join(found.motion, "\n"));
  EXPECT_EQ(found.motion.size(), 5u) << fmt::format("{}", fmt::join(found.motion, "\n"));
  for (const char* part :
       {"(effort, velocity)", "<mesh> in <geometry>", "<gazebo> in <robot> with 1 <material>"})
    EXPECT_TRUE(listed(found.other, part)) << part << "\n" << fmt::format("{}", fmt::join(found.other, "\n"));
  EXPECT_EQ(found.other.size(), 3u) << fmt::format("{}", fmt::join(found.other, "\n"));
}

TEST(Urdf, BadFilesEndInOneSentence) {
  const std::string base = link_text("base"), arm = link_text("arm");
  const std::pair<std::string, const char*> bad[] = {
      {"<robot name='r'>", "robot.urdf:1: is not well-formed XML: no element found"},
      {"<robot>\n<link name='a'>\n<inertial>\n</link></robot>",
       "robot.urdf:4: is not well-formed XML: mismatched tag"},
      {robot(""), "robot.urdf:1: robot 'r': has no <link>"},
      {robot("<xacro:macro name='m'/>"), "is xacro"},
      {robot("\n<jiont name='j'/>"), "robot.urdf:2: jiont 'j': no such element in <robot>"},
      {robot(base + "<link name='base'/>"), "there are two of this name"},
      {robot(base + arm), "expected one root"},
      {robot(base + joint_text("j", "revolute", "base", "leg")), "no link is named 'leg'"},
      {robot(base + arm + joint_text("j", "twist", "base", "arm")),
       "type is 'twist', expected one of: fixed"},
      {robot(base + arm + joint_text("j", "fixed", "base", "arm") + joint_text("k", "fixed", "base", "arm")),
       "link 'arm' is the child of joint 'j' too"},
      {robot(base + arm + link_text("leg") + joint_text("j", "fixed", "leg", "arm") +
             joint_text("k", "fixed", "arm", "leg")),
       "is its own ancestor"},
      {robot(base + arm + joint_text("j", "continuous", "base", "arm", "<axis xyz='0 0 0'/>")),
       "xyz has no direction"},
      {robot(base + arm + joint_text("j", "continuous", "base", "arm", "<axis xyz='0 0'/>")),
       "xyz holds 2 numbers, expected 3"},
      {robot(base + arm + joint_text("j", "continuous", "base", "arm", "<axis xyz='0 0 nan'/>")),
       "xyz holds 'nan', expected finite numbers"},
      {robot(base + arm + joint_text("j", "continuous", "base", "arm", "<mimic joint='q'/>")),
       "'q' is no joint"},
      {robot(base + arm + joint_text("j", "continuous", "base", "arm", "<dynamics damping='-1'/>")),
       "damping is -1"},
      {robot(base + arm + joint_text("j", "revolute", "base", "arm", "<limit lower='1' upper='0'/>")),
       "runs from 1 to 0"},
      {robot(link_text("base", "<inertial><mass value='1'/></inertial>")), "has no <inertia>"},
      {robot(link_text("base", "<inertial><mass value='-1'/><inertia ixx='1' iyy='1' izz='1'/></inertial>")),
       "of link 'base'"},
      {robot(link_text("base", "<inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='3'/></inertial>")),
       "of link 'base'"},
      {robot(link_text("base", "<visual><geometry><sphere radius='0'/></geometry></visual>")),
       "radius is 0"}};
  for (const auto& [xml, said] : bad) {
    const Folder folder;
    const auto model = read_model(folder.write("robot.urdf", xml));
    ASSERT_FALSE(model) << xml;
    EXPECT_NE(model.error().message().find(said), std::string::npos) << xml << "\n"
                                                                     << model.error().message();
    EXPECT_NE(model.error().where.find("robot.urdf:"), std::string::npos) << model.error().message();
  }
}

}  // namespace
}  // namespace borelli::test::urdf_test
