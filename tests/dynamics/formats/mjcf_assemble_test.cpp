// Models assembled by <frame>, <replicate>, <attach> and <composite>, and meshes of other kinds. Each is
// compared with the same model written out, in MuJoCo (whose Debian version has none of these), or with a
// closed form.
#include "dynamics/formats/mjcf_assemble.hpp"

#include <gtest/gtest.h>

#include <fmt/ranges.h>

#include <chrono>
#include <numbers>
#include <sstream>

#include "dynamics/formats/model_file.hpp"
#include "dynamics/scene/convex_hull.hpp"
#include "tests/dynamics/test_folder.hpp"

#ifdef BORELLI_MUJOCO
#include "tests/dynamics/mujoco_model.hpp"

namespace borelli::test::mjcf_assemble_test {
namespace {

std::string model(const std::string& bodies, const std::string& before = "") {
  return "<mujoco>" + before + "<worldbody>" + bodies + "</worldbody></mujoco>";
}

const std::string weight = "<inertial pos='.1 .2 -.3' mass='2' diaginertia='.02 .03 .04'/>";

/// Expects our reading of the model to move as MuJoCo's reading of the written-out one.
void expect_same_motion(const std::filesystem::path& path, const std::string& written_out) {
  const System system = compiled(need(read_model(path)).scene);
  Mujoco mujoco = Mujoco::of(written_out);
  const Differences d = differences(system, mujoco);
  EXPECT_LT(d.A, 1e-12);
  EXPECT_LT(d.drive, 1e-12);
  EXPECT_LT(d.acceleration, 1e-9);
}

void expect_same_motion_of(const std::string& xml, const std::string& written_out) {
  const Folder folder;
  expect_same_motion(folder.write("model.xml", xml), written_out);
}

std::string refusal(const std::filesystem::path& path) {
  const auto read = read_model(path);
  return read ? "read" : read.error().message();
}

TEST(MjcfAssemble, FrameMovesItsChildren) {
  // a body without a joint acts as a frame
  expect_same_motion_of(
      model("<frame pos='1 0 0' euler='0 0 90'><body pos='0 2 0' euler='0 20 0'>" + weight +
            "<frame pos='0 .5 0' euler='0 0 90'><joint pos='.3 0 0' axis='1 0 0'/></frame></body>"
            "<frame pos='0 0 3'><body pos='1 2 3'><freejoint/>" +
            weight + "</body></frame></frame>"),
      model("<body pos='1 0 0' euler='0 0 90'><body pos='0 2 0' euler='0 20 0'><joint pos='0 .8 0' axis='0 1 "
            "0'/>" +
            weight + "</body></body><body pos='-1 1 6' euler='0 0 90'><freejoint/>" + weight + "</body>"));
  // geoms by their ends and by their position, with a default class for the frame's contents
  expect_same_motion_of(
      model("<body><joint axis='1 0 0'/><frame pos='0 0 1' euler='0 90 0' childclass='c'>"
            "<geom type='capsule' fromto='0 0 0 1 0 0'/><geom type='box' size='.1 .2 .3' pos='0 0 "
            ".5'/></frame></body>",
            "<default><default class='c'><geom size='.1' density='500'/></default></default>"),
      model("<body><joint axis='1 0 0'/><geom type='capsule' size='.1' fromto='0 0 1 0 0 0' density='500'/>"
            "<geom type='box' size='.1 .2 .3' pos='.5 0 1' euler='0 90 0' density='500'/></body>"));
}

TEST(MjcfAssemble, ReplicateMovesEachCopyFurther) {
  const std::string body = "<joint axis='0 1 0'/>" + weight + "</body>";
  expect_same_motion_of(
      model("<replicate count='3' offset='1 0 0' euler='0 0 90'><body pos='.2 0 0'>" + body + "</replicate>"),
      model("<body pos='.2 0 0'>" + body + "<body pos='1 0 0' euler='0 0 90'><body pos='.2 0 0'>" + body +
            "</body><body pos='1 1 0' euler='0 0 180'><body pos='.2 0 0'>" + body + "</body>"));
}

TEST(MjcfAssemble, ReplicateRenamesCopiesAndReferences) {
  const Folder folder;
  // the example of MuJoCo's XML reference
  const Scene scene =
      need(read_model(folder.write(
               "m.xml",
               model("<replicate count='2' offset='0 1 0' euler='90 0 0'><replicate count='2' sep='-' "
                     "offset='1 0 0' euler='0 90 0'><body name='Alice'><freejoint/>" +
                         weight + "</body></replicate></replicate>",
                     "<equality><connect body1='Alice' anchor='0 0 0'/></equality>"))))
          .scene;
  std::vector<std::string> names;
  for (const Solid& s : scene.solids) names.push_back(s.name);
  EXPECT_EQ(names, (std::vector<std::string>{"Alice-00", "Alice-10", "Alice-01", "Alice-11"}));
  EXPECT_EQ(scene.constraints.size(), 4u);
  const auto said =
      refusal(folder.write("n.xml", model("<body name='b'><joint/>" + weight +
                                              "</body><replicate count='2'><body name='a'><joint/>" + weight +
                                              "</body></replicate>",
                                          "<equality><weld body1='a' body2='b'/></equality>")));
  EXPECT_NE(said.find("joins objects that <replicate>"), std::string::npos) << said;
}

TEST(MjcfAssemble, AttachedModelUsesItsOwnCompiler) {
  const Folder folder;
  folder.write(
      "parts/arm.xml",
      "<mujoco model='arm'><compiler angle='radian'/><default><joint axis='0 1 0' damping='.3'/></default>"
      "<asset><mesh name='m' vertex='0 0 0 1 0 0 0 .5 0 0 0 .25' face='0 2 1 0 1 3 0 3 2 1 2 3'/></asset>"
      "<worldbody><body name='upper' euler='.5 0 0'><joint name='j'/>" +
          weight +
          "<body name='lower' pos='0 0 1'><joint/><geom type='mesh' mesh='m' "
          "mass='3'/></body></body></worldbody>"
          "<equality><joint joint1='j'/></equality></mujoco>");
  const std::string asset =
      "<asset><model name='limb' file='parts/arm.xml'/>"
      "<mesh name='m' vertex='0 0 0 1 0 0 0 .5 0 0 0 .25' face='0 2 1 0 1 3 0 3 2 1 2 3'/></asset>";
  const std::string lower =
      "<body pos='0 0 1'><joint axis='0 1 0' damping='.3'/><geom type='mesh' mesh='m' mass='3'/></body>";
  const std::string upper = fmt::format("<body euler='{:.17g} 0 0'><joint axis='0 1 0' damping='.3'/>",
                                        .5 * 180 / std::numbers::pi) +
                            weight + lower + "</body>";
  const std::string base = "<body name='base' euler='0 0 30'><joint axis='1 0 0'/>" + weight;
  const auto all = folder.write(
      "all.xml",
      model(base + "<frame pos='1 0 0'><attach model='limb' prefix='left_'/></frame></body>", asset));
  const ModelFile read = need(read_model(all));
  EXPECT_EQ(read.scene.solids[1].name, "left_upper");
  ASSERT_EQ(read.scene.constraints.size(), 1u);
  // without the constraint the motion is that of the model written out (its meshes are of single precision)
  Scene scene = read.scene;
  scene.constraints.clear();
  const std::string mesh =
      "<asset><mesh name='m' vertex='0 0 0 1 0 0 0 .5 0 0 0 .25' face='0 2 1 0 1 3 0 3 2 1 2 3'/></asset>";
  Mujoco whole = Mujoco::of(model(base + "<body pos='1 0 0'>" + upper + "</body></body>", mesh));
  EXPECT_LT(differences(compiled(scene), whole).A, 1e-5);
  EXPECT_LT(differences(compiled(scene), whole).drive, 1e-5);
  // attaches one body of it
  Scene part =
      need(read_model(folder.write(
               "part.xml", model(base + "<attach model='limb' body='lower' prefix='r_'/></body>", asset))))
          .scene;
  EXPECT_TRUE(part.constraints.empty());
  Mujoco piece = Mujoco::of(model(base + lower + "</body>", mesh));
  EXPECT_LT(differences(compiled(part), piece).A, 1e-5);
  // attaches a body of the model itself
  const Scene twice =
      need(read_model(folder.write(
               "self.xml", model("<body name='a'><joint/>" + weight +
                                 "</body><frame pos='1 0 0'><attach body='a' prefix='other_'/></frame>"))))
          .scene;
  ASSERT_EQ(twice.solids.size(), 2u);
  EXPECT_EQ(twice.solids[1].name, "other_a");
}

TEST(MjcfAssemble, CablesAreChainsOfRodsOnBalls) {
  const std::string rod = "<geom type='capsule' size='.02' fromto='0 0 0 .5 0 0'/>";
  const auto joint = "<joint type='ball' stiffness='2' damping='.1'/>";
  const std::string inner =
      "<joint kind='main' stiffness='2' damping='.1'/><geom type='capsule' size='.02'/></composite>";
  expect_same_motion_of(model("<body pos='0 0 1'><composite type='cable' curve='s 0 0' count='4' size='1.5' "
                              "offset='.1 0 0' initial='none'>" +
                              inner + "</body>"),
                        model("<body pos='.1 0 1'>" + rod + "<body pos='.5 0 0'>" + joint + rod +
                              "<body pos='.5 0 0'>" + joint + rod + "</body></body></body>"));
  // around a right angle
  expect_same_motion_of(
      model("<composite prefix='c' type='cable' vertex='0 0 0 .5 0 0 .5 .5 0' initial='free'>" + inner),
      model("<body><joint type='free' stiffness='2'/>" + rod + "<body pos='.5 0 0' euler='0 0 90'>" + joint +
            rod + "</body></body>"));
  const Folder folder;
  EXPECT_NE(refusal(folder.write("m.xml", model("<composite type='rope' count='3'/>"))).find("only cable"),
            std::string::npos);
}

// ---- meshes ----

/// The inertial of the model's body, of density 1.
Inertial body_of_mesh(const std::string& attributes, const std::string& file = "",
                      const std::string& bytes = "") {
  const Folder folder;
  if (!file.empty()) folder.write(file, bytes);
  const Scene scene =
      need(read_model(folder.write("m.xml",
                                   model("<body><freejoint/><geom type='mesh' mesh='m' density='1'/></body>",
                                         "<asset><mesh name='m' " + attributes + "/></asset>"))))
          .scene;
  return scene.solids.at(0).inertials.at(0);
}

const std::string box_corners = "0 0 0 2 0 0 0 1 0 2 1 0 0 0 .5 2 0 .5 0 1 .5 2 1 .5";

void expect_box(const Inertial& own) {  // of edges 2, 1 and 1/2, by hand
  EXPECT_NEAR(own.mass, 1, 1e-12);
  EXPECT_LT((own.centre - Vector3d(1, .5, .25)).norm(), 1e-12);
  EXPECT_LT((own.tensor - Vector3d(1.25 / 12, 4.25 / 12, 5. / 12).asDiagonal().toDenseMatrix()).norm(),
            1e-12);
}

TEST(MjcfMeshes, PointsGiveTheirConvexHull) {
  expect_box(body_of_mesh("vertex='" + box_corners + " .5 .5 .3 1 .2 .1'"));
  const auto flat = convex_hull({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {.3, .2, 0}});
  ASSERT_FALSE(flat);
  EXPECT_NE(flat.error().what.find("one plane"), std::string::npos);
}

TEST(MjcfMeshes, ReadsMujocosMshFiles) {
  std::string bytes;
  const auto put = [&](auto value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof value); };
  for (const std::int32_t count : {8, 0, 8, 0})
    put(count);  // points, normals, texture coordinates, triangles
  std::istringstream numbers(box_corners);
  for (float x = 0; numbers >> x;) put(x);
  for (int i = 0; i < 16; ++i) put(0.5F);
  expect_box(body_of_mesh("file='m.msh'", "m.msh", bytes));
  for (const int t : {0, 1, 2}) put(t);
  bytes[12] = 1;
  const Folder folder;
  folder.write("m.msh", bytes.substr(0, bytes.size() - 1));
  const auto said =
      refusal(folder.write("m.xml", model("<body><freejoint/><geom type='mesh' mesh='m'/></body>",
                                          "<asset><mesh file='m.msh'/></asset>")));
  EXPECT_NE(said.find("bytes, expected"), std::string::npos) << said;
}

TEST(MjcfMeshes, FileChoosesTheInertiaRule) {
  // an L of two arms of 4 m by 1 m, 1 m high: it encloses 7, its hull 11.5
  const std::string outline =
      "vertex='0 0 0 4 0 0 4 1 0 1 1 0 1 4 0 0 4 0 0 0 1 4 0 1 4 1 1 1 1 1 1 4 1 0 4 1' face='"
      "0 3 1 1 3 2 0 5 3 3 5 4 6 7 9 7 8 9 6 9 11 9 10 11 0 1 6 1 7 6 1 2 7 2 8 7 2 3 8 3 9 8 3 4 9 4 10 9 4 "
      "5 10 5 "
      "11 10 5 0 11 0 6 11'";
  EXPECT_NEAR(body_of_mesh(outline + " inertia='exact'").mass, 7, 1e-12);
  EXPECT_NEAR(body_of_mesh(outline + " inertia='convex'").mass, 11.5, 1e-12);
  // a mesh with a hole: the pyramids of its triangles with the middle of its surface, as in MuJoCo
  const std::string open_box =
      "vertex='0 0 0 1 0 0 1 1 0 0 1 0 0 0 1 1 0 1 1 1 1 0 1 1' face='0 2 1 0 3 2 0 1 5 0 5 4 "
      "1 2 6 1 6 5 2 3 7 2 7 6 3 0 4 3 4 7' inertia='exact'";
  // (of a cube without its lid the middle is at z = 2/5; from there the lid's pyramid of 1/3 * 3/5 is
  // missing, and seen from the gravity centre that this leaves, 1/3 * (1 - z))
  const double missing = .2, z = (.5 - missing * (.75 + .25 * .4)) / (1 - missing);
  EXPECT_NEAR(body_of_mesh(open_box).mass, 1 - (1 - z) / 3, 1e-12);
  // such a mass is a guess under every rule that uses the volume, and a warning says so
  const Folder holes;
  const std::string hull_only = open_box.substr(0, open_box.find(" inertia"));
  for (const auto& [rule, gaps] : {std::pair{"legacy", 1}, {"exact", 1}, {"convex", 0}, {"shell", 0}}) {
    const ModelFile read = need(read_model(holes.write(
        "m.xml", model("<body><freejoint/><geom type='mesh' mesh='m' contype='0' conaffinity='0'/></body>",
                       "<asset><mesh name='m' " + hull_only + " inertia='" + rule + "'/></asset>"))));
    ASSERT_EQ(read.not_modelled.motion.size(), std::size_t(gaps)) << rule;
    if (gaps > 0) {
      EXPECT_TRUE(read.not_modelled.motion[0].starts_with("the gaps of 1 meshes that are not closed"))
          << rule;
    }
  }
  const Inertial shell = body_of_mesh(outline + " inertia='shell'");  // 2 faces of 7, 16 m of edge
  EXPECT_NEAR(shell.mass, 30, 1e-12);
  EXPECT_NEAR(shell.centre.z(), .5, 1e-12);
  EXPECT_NEAR(shell.centre.x(), shell.centre.y(), 1e-12);
  EXPECT_NEAR(shell.tensor(0, 0), shell.tensor(1, 1), 1e-12);
  // MuJoCo's legacy rule adds overlapping volume, and a note says so
  const Folder folder;
  const ModelFile legacy = need(read_model(
      folder.write("m.xml", model("<body><freejoint/><geom type='mesh' mesh='m' density='1'/></body>",
                                  "<asset><mesh name='m' " + outline + "/></asset>"))));
  const double mass = legacy.scene.solids.at(0).inertials.at(0).mass;
  EXPECT_GT(mass, 7.05);
  ASSERT_FALSE(legacy.not_modelled.other.empty());
  EXPECT_EQ(legacy.not_modelled.other[0].find(
                "1 meshes get more mass than their volume under MuJoCo's legacy rule"),
            0u);
  EXPECT_NE(legacy.not_modelled.other[0].find(" m^3 for 7 m^3 (inertia"), std::string::npos);
}

TEST(MjcfMeshes, FitsGeomsToMeshes) {
  const Folder folder;
  const auto form = [&](const std::string& type, const std::string& compiler) {
    const Scene scene =
        need(read_model(folder.write(
                 "m.xml", model("<body><freejoint/><geom type='" + type + "' mesh='m'/></body>",
                                compiler + "<asset><mesh name='m' vertex='" + box_corners + "'/></asset>"))))
            .scene;
    return scene.solids.at(0).shapes.at(0).shape;
  };
  for (const char* compiler : {"", "<compiler fitaabb='true'/>"}) {
    const Shape box = form("box", compiler);
    EXPECT_LT((std::get<Box>(box.form).size - Vector3d(.5, 1, 2)).norm(), 1e-12);  // the longest along z
    EXPECT_LT((box.position - Vector3d(1, .5, .25)).norm(), 1e-12);
    EXPECT_NEAR(std::abs((box.orientation * Vector3d::UnitZ()).x()), 1, 1e-12);
  }
  EXPECT_NEAR(std::get<Cylinder>(form("cylinder", "").form).radius, .375, 1e-12);
  EXPECT_NEAR(std::get<Cylinder>(form("cylinder", "<compiler fitaabb='true'/>").form).radius, .5, 1e-12);
  EXPECT_NEAR(std::get<Capsule>(form("capsule", "").form).length, 2 * (1 - .375 / 2), 1e-12);
}

// ---- bounds ----

TEST(MjcfBounds, EndlessGrowthIsRefusedAtOnce) {
  const Folder folder;
  for (int i = 0; i < 26; ++i) {
    const std::string next = fmt::format("b{}.xml", i + 1);
    folder.write(fmt::format("b{}.xml", i),
                 "<mujoco><include file='" + next + "'/><include file='" + next + "'/></mujoco>");
  }
  folder.write("b26.xml", "<mujoco><worldbody><geom size='1'/></worldbody></mujoco>");
  folder.write("m.xml",
               "<mujoco model='m'><asset><model name='m' file='m.xml'/></asset><worldbody><attach model='m' "
               "prefix='a'/><attach model='m' prefix='b'/></worldbody></mujoco>");
  folder.write("copies.xml",
               model("<replicate count='1000000'><body><joint/>" + weight + "</body></replicate>"));
  folder.write("self.xml", model("<body name='a'><attach body='a' prefix='b'/></body>"));
  for (const char* name : {"b0.xml", "m.xml", "copies.xml", "self.xml"}) {
    const auto start = std::chrono::steady_clock::now();
    const std::string said = refusal(folder.path() / name);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    EXPECT_TRUE(said.find("1000000 elements") != std::string::npos ||
                said.find("50 deep") != std::string::npos)
        << name << ": " << said;
    EXPECT_LT(seconds, 5) << name;
  }
}

TEST(MjcfBounds, DepthIncludesIncludedFiles) {
  const Folder folder;
  std::string open, close;
  for (int i = 0; i < 1000; ++i) open += "<body>", close += "</body>";
  for (int i = 0; i < 3; ++i)
    folder.write(fmt::format("d{}.xml", i),
                 "<mujoco>" + open + fmt::format("<include file='d{}.xml'/>", i + 1) + close + "</mujoco>");
  folder.write("d3.xml", "<mujoco><geom size='1'/></mujoco>");
  const auto said =
      refusal(folder.write("m.xml", "<mujoco><worldbody><include file='d0.xml'/></worldbody></mujoco>"));
  EXPECT_NE(said.find("nested deeper than"), std::string::npos) << said;
}

TEST(MjcfBounds, ManyGeomsAreReadInSeconds) {
  const Folder folder;
  const auto timed = [&](const std::string& bodies) {
    const auto begin = std::chrono::steady_clock::now();
    ModelFile read = need(read_model(folder.write("m.xml", model(bodies))));
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    EXPECT_LT(seconds, 5) << bodies.substr(0, 80);  // 0.2 s on an idle machine
    return read;
  };
  const std::string copies = "<replicate count='3000' offset='1 0 0'>", ball = "<geom size='.1'/>";
  const auto balls = timed(copies + "<body><freejoint/>" + ball + "</body></replicate>");
  EXPECT_TRUE(balls.scene.constraints.empty());
  EXPECT_EQ(balls.without_contact.surfaces.size(), 3000u);
  EXPECT_EQ(balls.without_contact.pairs.size(), 3000u * 2999 / 2);
  // contacts of the same two solids
  const auto bunch =
      timed("<geom type='plane' size='1 1 1'/><body><freejoint/>" + copies + ball + "</replicate></body>");
  ASSERT_EQ(bunch.scene.constraints.size(), 3000u);
  EXPECT_EQ(bunch.scene.constraints[0].name, "body 1 over plane");
  EXPECT_EQ(bunch.scene.constraints[2].name, "body 1 over plane''");
  EXPECT_LT(bunch.scene.constraints[2999].name.size(), 30u);
}

TEST(MjcfBounds, TooManyPairsAreRefusedWithAWorkaround) {
  const Folder folder;
  const auto crowd = [&](const std::string& option) {
    return refusal(
        folder.write("m.xml", model("<replicate count='20001' offset='1 0 0'><geom size='.1'/></replicate>"
                                    "<body><freejoint/><geom size='.1'/></body>",
                                    option)));
  };
  EXPECT_NE(crowd("").find("has 20002 geoms that may touch others"), std::string::npos) << crowd("");
  EXPECT_EQ(crowd("<option><flag contact='disable'/></option>"), "read");
}

// ---- unsupported elements ----

TEST(MjcfOmissions, ThatChangeTheMotionAreListedByNameAndCount) {
  const Folder folder;
  const NotModelled found =
      need(read_model(folder.write(
               "m.xml",
               "<mujoco>\n<option density='1.2' viscosity='0' integrator='RK4'/>\n<default><joint "
               "springdamper='.1 1'/></default>"
               "<worldbody><light/>\n<replicate count='7'><body><joint/><joint axis='1 0 0' "
               "frictionloss='.1' group='2'/>" +
                   weight +
                   "<geom size='1' rgba='1 0 0 1' contype='0' conaffinity='0' solref='.1 "
                   "1'/></body></replicate></worldbody>\n"
                   "<tendon><fixed name='t'/></tendon><actuator><motor/><motor/><position/></actuator>"
                   "<sensor><gyro/></sensor></mujoco>")))
          .not_modelled;
  const auto holds = [](const std::vector<std::string>& lines, const std::string& part) {
    return std::any_of(lines.begin(), lines.end(),
                       [&](const std::string& line) { return line.find(part) != std::string::npos; });
  };
  for (const char* part :
       {"springdamper of <joint>: 14 times, first at", "frictionloss of <joint>: 7 times, first at",
        "density of <option>: at", "<motor> in <actuator>: 2 times, first at", "<position> in <actuator>: at",
        "<fixed> in <tendon>: at"})
    EXPECT_TRUE(holds(found.motion, part)) << part << "\n"
                                           << fmt::format("{}", fmt::join(found.motion, "\n"));
  EXPECT_EQ(found.motion.size(), 6u) << fmt::format("{}", fmt::join(found.motion, "\n"));
  for (const char* part : {"(integrator, viscosity)", "(rgba, solref)", "<light>", "(group)",
                           "<sensor> in <mujoco> with 1 <gyro>"})
    EXPECT_TRUE(holds(found.other, part)) << part << "\n" << fmt::format("{}", fmt::join(found.other, "\n"));
}

}  // namespace
}  // namespace borelli::test::mjcf_assemble_test
#endif
