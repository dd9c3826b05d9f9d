// Models in MJCF, read by us and by MuJoCo: mass matrix, driving efforts and accelerations at random states.
#include "dynamics/formats/mjcf.hpp"
#include "tests/paths.hpp"

#include <gtest/gtest.h>

#include "dynamics/formats/mjcf_geom.hpp"
#include "dynamics/formats/model_file.hpp"
#include "test_folder.hpp"

#ifdef BORELLI_MUJOCO
#include "mujoco_model.hpp"

namespace borelli::test::mjcf_test {
namespace {

System system_of(const std::filesystem::path& path) { return compiled(need(read_model(path)).scene); }

/// Reads the file by both programs and expects agreement. `largest`: the allowed difference relative to each
/// array's largest entry.
void expect_same(const std::filesystem::path& path, double largest = 1e-12) {
  const System system = system_of(path);
  Mujoco mujoco(path);
  const Differences d = differences(system, mujoco);
  EXPECT_LT(d.A, largest);
  EXPECT_LT(d.drive, largest);
  EXPECT_LT(d.acceleration, std::max(1e-9, 100 * largest));  // the condition of A carries rounding into it
}

void expect_same_text(const std::string& xml, double largest = 1e-12) {
  const Folder folder;
  expect_same(folder.write("model.xml", xml), largest);
}

/// A model of these bodies.
std::string model(const std::string& bodies, const std::string& before = "") {
  return "<mujoco>" + before + "<worldbody>" + bodies + "</worldbody></mujoco>";
}

// ---- whole models ----

void expect_same_shared(const std::string& name) {
  const std::filesystem::path path = test::shared_folder() + "/models/" + name;
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
  expect_same(path);
}
TEST(Mjcf, Humanoid) { expect_same_shared("humanoid.xml"); }
TEST(Mjcf, HumanoidCMU) { expect_same_shared("humanoid_CMU.xml"); }
TEST(Mjcf, BenchmarkHuman) { expect_same_shared("bench/human.xml"); }

// ---- joints ----

const std::string inertial = "<inertial pos='.1 .2 -.3' mass='2' diaginertia='.02 .03 .04'/>";

TEST(Mjcf, JointsAwayFromTheOriginWithRefSpringsAndDampers) {
  expect_same_text(model(
      "<body pos='1 2 3' euler='10 20 30'>" + inertial +
      "<joint name='h' axis='1 2 3' pos='.1 .2 .3' ref='30' springref='-20' stiffness='7' damping='.5'/>"
      "<body pos='.5 0 0'>" +
      inertial +
      "<joint type='slide' axis='0 1 1' ref='.3' springref='.7' stiffness='11' damping='2'/>"
      "<joint type='hinge' pos='0 0 .4' axis='1 0 0'/>"
      "<body pos='0 .5 0' axisangle='1 1 0 50'>" +
      inertial + "<joint type='ball' pos='.1 .1 .1' stiffness='3' damping='.2'/></body></body></body>"));
}

TEST(Mjcf, BallSpringDependsOnlyOnItsOwnRotation) {
  // hinges before the ball, in the same body
  expect_same_text(
      model("<body euler='40 -20 70'><joint axis='0 1 0' pos='.2 0 0'/>"
            "<joint axis='1 0 1' stiffness='1' pos='0 0 .1'/>"
            "<joint type='ball' stiffness='5' damping='.3' pos='0 .1 0'/>"
            "<joint type='slide' axis='1 0 1' stiffness='1'/>" +
            inertial + "<body>" + inertial +
            "<joint type='slide' axis='1 0 0'/><joint type='ball' stiffness='2'/></body></body>"));
}

TEST(Mjcf, FreeJointsWithAndWithoutSprings) {
  expect_same_text(
      model("<body pos='1 2 3' quat='.5 .1 -.7 .2'><freejoint name='root'/>" + inertial + "</body>" +
            "<body pos='-1 0 1' quat='.3 .4 .1 -.2'><joint type='free' stiffness='4' damping='.6'/>" +
            inertial + "</body>"));
}

TEST(Mjcf, StartIsTheModelsPose) {
  const Folder folder;
  const auto path = folder.write(
      "m.xml", model("<body pos='1 2 3' quat='.5 .1 -.7 .2'><freejoint name='root'/>" + inertial +
                     "<body><joint ref='30' axis='0 1 0' limited='true' range='-10 40'/>" + inertial +
                     "<body><joint type='ball'/>" + inertial + "</body></body></body>"));
  const System system = system_of(path);
  const Mujoco mujoco(path);
  ASSERT_EQ(system.nq, mujoco.model->nq);
  for (int i = 0; i < system.nq; ++i) EXPECT_NEAR(system.initial.q[i], mujoco.model->qpos0[i], 1e-15) << i;
  EXPECT_EQ(system.coordinates[0].name, "root.x");
  ASSERT_EQ(system.ranges.size(), 1u);
  EXPECT_NEAR(system.ranges[0].ranges[0].upper, 40 * M_PI / 180, 1e-15);
}

// ---- frames, defaults, includes ----

TEST(Mjcf, EveryOrientationFormatIsRead) {
  for (const char* compiler :
       {"<compiler/>", "<compiler angle='radian' eulerseq='zyx'/>", "<compiler eulerseq='XYZ'/>",
        "<compiler eulerseq='xZy'/>", "<compiler eulerseq='ZXZ'/>"})
    for (const char* turn :
         {"quat='1 -2 3 4'", "axisangle='1 2 -1 1.1'", "euler='1.1 -.7 .4'", "euler='10 70 -40'",
          "xyaxes='1 2 0 3 1 1'", "zaxis='1 -2 .5'", "zaxis='0 0 -1'", "zaxis='0 0 2'"})
      expect_same_text(model(
          "<body pos='0 1 0' " + std::string(turn) + "><joint axis='1 1 0'/>" + inertial + "<body " + turn +
              "><joint/><inertial pos='0 0 1' mass='1' diaginertia='1 1.2 1.4' " + turn + "/></body></body>",
          compiler));
}

TEST(Mjcf, DefaultClassesNestAndYield) {
  expect_same_text(
      model("<body childclass='arm'><joint/><geom/><geom pos='0 0 1' class='main'/>"
            "<body pos='1 0 0'><joint axis='0 1 0' class='stiff'/><geom class='stiff' euler='0 45 0'/>"
            "<body pos='1 0 0' childclass='stiff'><joint damping='3' axis='1 0 0'/><geom "
            "size='.3'/></body></body></body>"
            "<body><joint/><geom/></body>",
            "<default class='main'><joint stiffness='2'/><geom size='.1 .3'/>"
            "<default class='arm'><joint damping='.7' axis='0 1 1'/><geom type='capsule' density='500' "
            "zaxis='0 1 1'/>"
            "<default class='stiff'><joint stiffness='50' springref='10'/><geom "
            "mass='2'/></default></default></default>"));
}

TEST(Mjcf, IncludesReplaceTheirElement) {
  const Folder folder;
  folder.write("parts/arm.xml", "<mujoco><body name='arm'><joint axis='0 1 0'/>" + inertial +
                                    "<include file='parts/hand.xml'/></body></mujoco>");
  folder.write("parts/hand.xml",
               "<mujocoinclude><body pos='0 0 1'><joint/>" + inertial + "</body></mujocoinclude>");
  folder.write("options.xml", "<mujoco><option gravity='1 2 -3'/><compiler angle='radian'/></mujoco>");
  const auto path = folder.write(
      "main.xml", "<mujoco><include file='options.xml'/><worldbody><body euler='.1 .2 .3'>" + inertial +
                      "<joint/><include file='parts/arm.xml'/></body></worldbody></mujoco>");
  expect_same(path);
}

TEST(Mjcf, GravityAndPassiveForcesCanBeSwitchedOff) {
  const std::string body = "<body><joint axis='0 1 0' stiffness='9' damping='2'/>" + inertial + "</body>";
  expect_same_text(model(body, "<option gravity='1 2 3'><flag gravity='disable'/></option>"));
  expect_same_text(model(body, "<option><flag passive='disable'/></option>"));
}

TEST(Mjcf, GravcompCarriesTheWeight) {
  // MuJoCo 2.2 lacks this. A body with gravity compensation 1 does not fall
  const Folder folder;
  const System system =
      system_of(folder.write("m.xml", model("<body gravcomp='1'><freejoint/>" + inertial + "</body>")));
  EXPECT_LT(need(evaluate(system, system.initial)).acceleration.norm(), 1e-13);  // of 9.81 m/s^2
}

// ---- inertia ----

TEST(Mjcf, InertialsByPrincipalMomentsAndInFull) {
  expect_same_text(
      model("<body><joint/><inertial pos='.1 0 0' quat='1 2 3 4' mass='1' diaginertia='.1 .2 .25'/></body>"));
  // MuJoCo's principal axes of this tensor give .0400001302 for its .04: 3e-7 of the largest moment
  const std::string full = model(
      "<body><freejoint/><inertial pos='.1 .2 .3' mass='3' fullinertia='.3 .4 .5 .02 -.03 .04'/></body>");
  expect_same_text(full, 1e-6);
  const Folder folder;
  const Inertial own = need(read_model(folder.write("m.xml", full))).scene.solids.at(0).inertials.at(0);
  Matrix3d expected;
  expected << .3, .02, -.03, .02, .4, .04, -.03, .04, .5;
  EXPECT_EQ(own.tensor, expected);
  EXPECT_EQ(own.centre, Vector3d(.1, .2, .3));
}

TEST(Mjcf, CompilerBoundsBalancesAndScalesInertia) {
  const std::string bodies =
      "<body><joint/><inertial pos='.1 0 0' mass='.001' diaginertia='.1 .2 1'/><body><joint axis='1 0 0'/>"
      "<inertial pos='.1 0 0' mass='1' diaginertia='.001 .002 .002'/></body><body><geom "
      "size='.1'/></body></body>";
  expect_same_text(model(bodies, "<compiler balanceinertia='true' boundmass='.5'/>"));
  expect_same_text(model(bodies, "<compiler balanceinertia='true' boundinertia='.01'/>"));
  expect_same_text(model(bodies, "<compiler balanceinertia='true' settotalmass='7'/>"));
}

TEST(Mjcf, InertiaOfEveryKindOfGeom) {
  for (const char* geom :
       {"<geom size='.2'/>", "<geom type='capsule' size='.1 .3' density='700'/>",
        "<geom type='cylinder' size='.1 .3'/>", "<geom type='ellipsoid' size='.1 .2 .3' mass='2'/>",
        "<geom type='box' size='.1 .2 .3'/>", "<geom type='capsule' size='.1' fromto='0 .1 .2 .5 .4 -.3'/>",
        "<geom type='cylinder' size='.1' fromto='0 0 1 0 0 0'/>",
        "<geom type='box' size='.1' fromto='0 .1 .2 .5 .4 -.3'/>",
        "<geom type='ellipsoid' size='.1' fromto='0 1 2 3 2 -1'/>"}) {
    const std::string placed = std::string(geom).insert(5, " euler='0 0 0'");
    expect_same_text(model("<body><freejoint/>" + std::string(geom) + "</body>"), 1e-9);
  }
  expect_same_text(
      model("<body pos='1 0 0'><freejoint/><geom size='.2' pos='1 2 3'/><geom type='box' size='.1 .2 .3' "
            "euler='10 20 30'/><geom type='capsule' size='.1' fromto='0 0 0 1 1 1' mass='3'/></body>"),
      1e-9);  // several geoms: MuJoCo diagonalises
}

TEST(Mjcf, GeomsThatHaveMass) {
  const std::string body =
      "<body><joint axis='0 1 0'/><geom size='.2' pos='.5 0 0'/><geom size='.1' group='3' pos='0 0 1'/>"
      "<geom size='9' mass='0'/>";
  expect_same_text(model(body + "</body><geom size='1'/><geom type='plane' size='1 1 1'/>"));
  expect_same_text(model(body + "</body>", "<compiler inertiagrouprange='1 4'/>"));
  expect_same_text(model(body + inertial + "</body>"));
  expect_same_text(model(body + inertial + "</body>", "<compiler inertiafromgeom='true'/>"), 1e-9);
  expect_same_text(model(body + inertial + "</body>", "<compiler inertiafromgeom='false'/>"));
}

// ---- meshes ----

// A prism over an arrow's outline (not convex), as an OBJ with faces of four and four corners.
const std::string arrow_obj =
    "# outline 0,0  .3,.1  0,.4  .1,.1\nv 0 0 0\nv .3 .1 0\nv 0 .4 0\nv .1 .1 0\nv 0 0 .2\nv .3 .1 .2\nv 0 "
    ".4 .2\n"
    "v .1 .1 .2\nf 4 3 2 1\nf 5/1 6/1 7/1 8/1\nf 1//1 2 6 5\nf 2 3 7 6\nf -6 -5 -1 -2\nf 4 1 5 8\n";

std::string tetrahedron_stl() {
  const float corners[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, .5F, 0}, {0, 0, .25F}};
  const int faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  std::string bytes(80, ' ');
  const auto put = [&](const void* data, std::size_t size) {
    bytes.append(static_cast<const char*>(data), size);
  };
  const std::uint32_t count = 4;
  put(&count, 4);
  for (const auto& face : faces) {
    bytes.append(12, '\0');
    for (const int corner : face) put(corners[corner], 12);
    bytes.append(2, '\0');
  }
  return bytes;
}

TEST(Mjcf, InertiaOfMeshes) {
  // 1e-5: MuJoCo keeps the vertices in single precision
  const Folder folder;
  folder.write("meshes/arrow.obj", arrow_obj);
  folder.write("meshes/tetrahedron.stl", tetrahedron_stl());
  for (const char* mesh : {"file='arrow.obj'", "name='arrow' file='tetrahedron.stl'",
                           "file='arrow.obj' scale='2 1 .5' refpos='.1 .2 .3' refquat='1 2 3 4'",
                           "file='arrow.obj' scale='1 -1 1'",
                           "name='arrow' vertex='0 0 0 1 0 0 0 .5 0 0 0 .25' face='0 2 1 0 1 3 0 3 2 1 2 3'"})
    // with a density, its legacy rule takes another volume: see legacy_mesh_inertial
    for (const auto& [geom, exact] : {std::pair("mass='3'", "false"), std::pair("mass='3'", "true"),
                                      std::pair("density='200'", "true"), std::pair("", "true")}) {
      const std::string before = "<compiler meshdir='meshes' exactmeshinertia='" + std::string(exact) +
                                 "'/><asset><mesh " + mesh + "/></asset>";
      const std::string body =
          "<body><freejoint/><geom type='mesh' mesh='arrow' pos='1 0 2' euler='10 20 30' " +
          std::string(geom) + "/></body>";
      SCOPED_TRACE(before + body);
      expect_same(folder.write("model.xml", model(body, before)), 1e-5);
    }
}

TEST(Mjcf, LegacyMeshInertiaIsExactForConvexOnes) {
  const ClosedMesh corner{{{0, 0, 0}, {1, 0, 0}, {0, .5, 0}, {0, 0, .25}},
                          {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
  const Inertial legacy = legacy_mesh_inertial(corner),
                 exact =
                     need(inertial_of_density({corner, Vector3d::Zero(), Eigen::Quaterniond::Identity()}, 1));
  EXPECT_NEAR(legacy.mass, exact.mass, 1e-16);  // 1/48
  EXPECT_LT((legacy.centre - exact.centre).norm(), 1e-15);
  EXPECT_LT((legacy.tensor - exact.tensor).norm(), 1e-16);
}

// ---- equality ----

TEST(Mjcf, EqualitiesGiveMujocosRows) {
  const std::string arm = "<inertial pos='.1 0 -.3' mass='1' diaginertia='.1 .2 .25'/>";
  const Folder folder;
  const auto path = folder.write(
      "m.xml",
      model("<body name='a' pos='0 0 1' euler='0 20 0'><joint name='ja' axis='0 1 0' ref='10'/>" + arm +
                "<body name='b' pos='0 0 -1' euler='30 0 0'><joint name='jb' axis='1 1 0'/>" + arm +
                "</body></body><body name='c' pos='1 0 1'><joint name='jc' type='slide' ref='.2'/>"
                "<joint type='ball' pos='0 .1 0'/>" +
                arm + "</body><body name='d'><freejoint/>" + arm + "</body>",
            "<equality><connect body1='b' body2='c' anchor='.1 .2 -1'/><connect body1='b' anchor='0 1 0'/>"
            "<joint joint1='ja' joint2='jc' polycoef='.1 2 0 0 0'/><joint joint1='jb' polycoef='.3 1 0 0 0'/>"
            "<weld body1='a' body2='d'/></equality>"));
  const System system = system_of(path);
  ASSERT_EQ(system.rows, 3 + 3 + 1 + 1 + 6);
  Mujoco mujoco(path);
  mujoco.model->opt.disableflags = mjDSBL_CONTACT | mjDSBL_LIMIT | mjDSBL_FRICTIONLOSS;
  mujoco.model->opt.jacobian = mjJAC_DENSE;
  const auto rows = [&](const State& state) {
    mujoco.at(state.q, state.v, Eigen::VectorXd::Zero(system.nv));
    return Rows(Eigen::Map<Rows>(mujoco.data->efc_J, mujoco.data->nefc, system.nv));
  };
  Random random(3);
  State state = random.state(system);
  Rows L = need(evaluate(system, state)).constraint_jacobian, J = rows(state);
  ASSERT_EQ(J.rows(), 14);
  // MuJoCo's connect is a - b as ours, its joint equality q1 - poly(q2); equal to rounding
  EXPECT_LT((L.topRows(8) - J.topRows(8)).cwiseAbs().maxCoeff(), 1e-14);
  // a weld's rows are other combinations of ours; in the model's pose, which satisfies them, they span the
  // same space
  state = system.initial;
  L = need(evaluate(system, state)).constraint_jacobian.bottomRows(6);
  J = rows(state).bottomRows(6);
  Rows both(12, system.nv);
  both << L, J;
  EXPECT_EQ(Eigen::JacobiSVD<Eigen::MatrixXd>(L).setThreshold(1e-12).rank(), 6);
  EXPECT_EQ(Eigen::JacobiSVD<Eigen::MatrixXd>(both).setThreshold(1e-12).rank(), 6);
  // positions: the anchors coincide in the model's pose; the coupled joints are off by their constant terms
  const Evaluation start = need(evaluate(system, system.initial));
  EXPECT_EQ(start.rows[0], "connect of b and c[0]");
}

TEST(Mjcf, CurvedCouplingsGiveMujocosRowsAndValues) {
  const std::string arm = "<inertial pos='.1 0 -.3' mass='1' diaginertia='.1 .2 .25'/>";
  const Folder folder;
  const auto path = folder.write(
      "m.xml", model("<body name='a' pos='0 0 1'><joint name='ja' axis='0 1 0' ref='10'/>" + arm +
                         "<body name='b' pos='0 0 -1'><joint name='jb' axis='1 1 0' ref='-25'/>" + arm +
                         "</body></body><body name='c' pos='1 0 1'><joint name='jc' type='slide' ref='.2'/>" +
                         arm + "</body>",
                     "<equality><joint joint1='ja' joint2='jb' polycoef='.1 .7 -.4 .3 .2'/>"
                     "<joint joint1='jc' joint2='ja' polycoef='0 0 .5 0 0'/>"
                     "<joint joint1='jb' polycoef='.3 1 2 3 4'/></equality>"));
  EXPECT_TRUE(need(read_model(path)).not_modelled.empty());
  const System system = system_of(path);
  ASSERT_EQ(system.rows, 3);
  Mujoco mujoco(path);
  mujoco.model->opt.disableflags = mjDSBL_CONTACT | mjDSBL_LIMIT | mjDSBL_FRICTIONLOSS;
  mujoco.model->opt.jacobian = mjJAC_DENSE;
  Random random(3);
  for (int trial = 0; trial < 10; ++trial) {
    const State state = random.state(system);
    mujoco.at(state.q, state.v, Eigen::VectorXd::Zero(system.nv));
    ASSERT_EQ(mujoco.data->nefc, 3);
    const Rows J = Eigen::Map<Rows>(mujoco.data->efc_J, 3, system.nv);
    EXPECT_LT((need(evaluate(system, state)).constraint_jacobian - J).cwiseAbs().maxCoeff(), 1e-13);
    Workspace w(system);
    ASSERT_FALSE(accelerate(system, system.parameters, state.t, state.q.data(), state.v.data(), {}, w));
    const Eigen::VectorXd off = Eigen::Map<Eigen::VectorXd>(mujoco.data->efc_pos, 3);
    EXPECT_LT((w.rows.h - off).cwiseAbs().maxCoeff(), 1e-13);
  }
  // E is the second derivative of the rows without the accelerations: checked by differences of L v
  const State state = random.state(system);
  const Eigen::VectorXd E = need(evaluate(system, state)).constraint_bias;
  const auto rate = [&](double t) -> Eigen::VectorXd {
    const Eigen::VectorXd q = state.q + t * state.v;
    mujoco.at(q, state.v, Eigen::VectorXd::Zero(system.nv));
    return Eigen::Map<Rows>(mujoco.data->efc_J, 3, system.nv) * state.v;
  };
  EXPECT_LT((E - (rate(1e-5) - rate(-1e-5)) / 2e-5).cwiseAbs().maxCoeff(), 1e-7);
}

}  // namespace
}  // namespace borelli::test::mjcf_test

#else
TEST(Mjcf, AgreesWithMujoco) { GTEST_SKIP() << "MuJoCo (libmujoco-dev) was not there at configuration"; }
#endif
