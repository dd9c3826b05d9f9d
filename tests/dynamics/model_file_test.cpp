// Which reader a file goes to, and how bad MJCF is refused.
#include "dynamics/formats/model_file.hpp"

#include <fmt/ranges.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "dynamics/equations/evaluate.hpp"
#include "dynamics/formats/scene_file.hpp"
#include "scenes.hpp"
#include "test_folder.hpp"

namespace borelli::test {
namespace {

const std::string toml =
    "[[solid]]\nname='arm'\njoint={rotation='y'}\nmass=1\ncentre=[0,0,-1]\ntensor=[0,0,0]\n";
const std::string mjcf =
    "<mujoco><worldbody><body name='arm'><joint axis='0 1 0'/><inertial pos='0 0 -1' "
    "mass='1'/></body></worldbody></mujoco>";
const std::string urdf =
    "<?xml version='1.0'?>\n<robot name='r'><link name='base'/><link name='arm'><inertial><origin xyz='0 0 "
    "-1'/>"
    "<mass value='1'/><inertia ixx='0' iyy='0' izz='0'/></inertial></link><joint name='j' type='continuous'>"
    "<parent link='base'/><child link='arm'/><axis xyz='0 1 0'/></joint></robot>";

TEST(ModelFile, ContentDecidesTheFormat) {
  const Folder folder;
  for (const auto& [name, text] :
       {std::pair("a.toml", toml), std::pair("a.xml", mjcf), std::pair("a.urdf", urdf),
        std::pair("model", mjcf), std::pair("b.xml", urdf), std::pair("scene", toml)}) {
    const ModelFile model = need(read_model(folder.write(name, text)));
    const System system = compiled(model.scene);
    ASSERT_EQ(system.nv, 1) << name;
    // the same pendulum in each language
    State state = system.initial;
    state.q[0] = 0.3;
    EXPECT_NEAR(need(evaluate(system, state)).acceleration[0], -9.81 * std::sin(0.3), 1e-14) << name;
    EXPECT_TRUE(model.not_modelled.empty()) << name;
  }
}

TEST(ModelFile, FloatingAppliesOnlyToUrdf) {
  const Folder folder;
  EXPECT_FALSE(read_model(folder.write("a.toml", toml), {.floating = true}));
  EXPECT_FALSE(read_model(folder.write("a.xml", mjcf), {.floating = true}));
  EXPECT_TRUE(read_model(folder.write("a.urdf", urdf), {.floating = true}));
}

TEST(ModelFile, SceneFromMjcfRoundTripsThroughToml) {
  // a scene's file holds all that the reader makes, and reads back the same
  const Folder folder;
  const Scene scene =
      need(
          read_model(folder.write(
              "a.xml",
              "<mujoco model='m'><worldbody><geom type='box' size='1 1 1'/><body name='a' pos='1 0 0'><joint "
              "type='free' stiffness='1'/><geom type='capsule' size='.1 .2'/><body name='b' euler='9 0 0'>"
              "<joint type='ball' damping='1'/><geom size='1'/><joint name='s' type='slide'/></body></body>"
              "</worldbody><equality><connect body1='b' anchor='0 0 1'/><joint joint1='s'/>"
              "<weld body1='a'/></equality></mujoco>")))
          .scene;
  const std::string text = need(write_scene(scene));
  EXPECT_EQ(need(write_scene(need(parse_scene(text, "m.toml")))), text);
  const System first = compiled(scene), second = compiled(need(parse_scene(text, "m.toml")));
  Random random(4);
  const State state = random.state(first);
  EXPECT_EQ(need(evaluate(first, state)).acceleration, need(evaluate(second, state)).acceleration);
}

TEST(ModelFile, ListsEverythingDroppedFromMjcf) {
  const Folder folder;
  folder.write("more.xml", "<mujoco><custom><text name='a' data='b'/></custom></mujoco>");
  const auto lines =
      need(read_model(folder.write(
               "a.xml",
               "<mujoco>\n<option viscosity='1' integrator='RK4'><flag energy='enable'/></option><size "
               "njmax='9'/>\n"
               "<include file='more.xml'/><asset><texture/><mesh name='unused' file='no.stl'/></asset>\n"
               "<default><joint frictionloss='2'/><geom rgba='1 0 0 1'/></default>\n"
               "<worldbody><light/><geom type='plane' size='1 1 1'/>\n<body mocap='true'><geom "
               "type='box' size='1 1 1'/><geom type='box' size='2 2 2'/>"
               "</body>\n<body><joint name='j' springdamper='1 1'/><geom size='1'/></body></worldbody>\n"
               "<equality><connect body1='a' active='false' anchor='0 0 0'/><tendon tendon1='t'/>"
               "<joint joint1='j' active='false'/></equality>"
               "<contact><exclude body1='u' "
               "body2='v'/><other/></contact><tendon/><actuator><motor/><motor/></actuator><keyframe/"
               "><sensor/></mujoco>")))
          .not_modelled;
  const std::string motion = fmt::format("{}", fmt::join(lines.motion, "\n")),
                    other = fmt::format("{}", fmt::join(lines.other, "\n"));
  for (const char* part :
       {"viscosity of <option>: at", "frictionloss of <joint>: at", "springdamper of <joint>: at",
        "<tendon> in <equality>: at", "<motor> in <actuator>: 2 times"})
    EXPECT_NE(motion.find(part), std::string::npos) << part << "\n" << motion;
  for (const char* part :
       {"<option> in <mujoco> (integrator)", "<flag> in <option> (energy)", "<size> in", "<custom>",
        "<texture>", "<mesh> in <asset>", "<geom> in <body> (rgba): 3 times", "<light> in <worldbody>",
        "<body> in <worldbody> (mocap)", "<connect> in <equality>", "<joint> in <equality>",
        "<other> in <contact>", "<tendon> in <mujoco>", "<keyframe>", "<sensor>"})
    EXPECT_NE(other.find(part), std::string::npos) << part << "\n" << other;
}

TEST(ModelFile, SwitchedOffPartsOfMjcfDoNotChangeTheMotion) {
  const Folder folder;
  const auto motion = [&](const std::string& flags) {
    return need(read_model(folder.write(
                    "a.xml",
                    "<mujoco><option o_solref='.1 1' o_margin='.1'><flag " + flags +
                        "/></option><worldbody><body><joint name='j' frictionloss='2' solreflimit='.1 1'/>"
                        "<geom size='1' solref='.1 1' margin='.1'/></body></worldbody>"
                        "<equality><tendon tendon1='t'/></equality><actuator><motor/></actuator></mujoco>")))
        .not_modelled.motion.size();
  };
  // frictionloss, solreflimit, solref, margin, <tendon>, <motor>
  EXPECT_EQ(motion(""), 6u);
  EXPECT_EQ(motion("override='enable'"), 8u);
  EXPECT_EQ(motion("frictionloss='disable'"), 5u);
  EXPECT_EQ(motion("limit='disable'"), 5u);
  EXPECT_EQ(motion("contact='disable'"), 4u);
  EXPECT_EQ(motion("equality='disable'"), 5u);
  EXPECT_EQ(motion("actuation='disable'"), 5u);
  EXPECT_EQ(motion("constraint='disable'"), 1u);
}

// MuJoCo aligns the frame of a free body without child bodies (mjCBody::Compile), so its qpos differ.
TEST(ModelFile, AlignedFreeJointsAreListedAsChangingTheMotion) {
  const Folder folder;
  const std::string weight = "<inertial pos='.1 0 0' mass='1' diaginertia='1 1 1'/>";
  const auto motion = [&](const std::string& compiler, const std::string& joint, const std::string& child) {
    return need(read_model(folder.write("aligned.xml", "<mujoco><compiler " + compiler +
                                                           "/><worldbody><body>" + joint + weight + child +
                                                           "</body></worldbody></mujoco>")))
        .not_modelled.motion;
  };
  const auto listed = motion("", "<freejoint align='true'/>", "");
  ASSERT_EQ(listed.size(), 1u);
  EXPECT_EQ(listed[0].find("alignment of 1 free joints (align, alignfree)"), 0u) << listed[0];
  EXPECT_EQ(motion("alignfree='true'", "<freejoint/>", ""), listed);
  EXPECT_EQ(motion("alignfree='true'", "<joint type='free'/>", ""), listed);
  EXPECT_TRUE(motion("", "<freejoint/>", "").empty());
  EXPECT_TRUE(motion("alignfree='true'", "<freejoint align='false'/>", "").empty());
  EXPECT_TRUE(motion("alignfree='true'", "<freejoint/>", "<body>" + weight + "</body>").empty());
}

TEST(ModelFile, BadFilesAreRefusedInOneSentence) {
  const Folder folder;
  folder.write("self.xml", "<mujoco><include file='round.xml'/></mujoco>");
  folder.write("round.xml", "<mujoco>\n<include file='self.xml'/></mujoco>");
  folder.write("short.stl", "solid");
  folder.write("bad.obj", "v 0 0 0\nf 1 2 3\n");
  folder.write("open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const auto body = [](const std::string& inside) {
    return "<mujoco>\n<worldbody>\n<body name='b'>\n" + inside + "</body></worldbody></mujoco>";
  };
  const auto mesh = [&](const std::string& attributes) {
    return "<mujoco><asset>\n<mesh name='m' " + attributes +
           "/></asset><worldbody><body><freejoint/><geom type='mesh' mesh='m'/></body></worldbody></mujoco>";
  };
  const std::string in = "<inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/>";
  const std::pair<std::string, const char*> bad[] = {
      {"<mujoco><worldbody>\n<body", "model.xml:2: is not well-formed XML: the file ends within a tag"},
      {"", "model.xml:1: is not well-formed XML: the file ends before its root element does"},
      {"<sdf/>",
       "the root is <sdf>, expected <mujoco> (MJCF), <robot> (URDF) or <OpenSimDocument> (OpenSim)"},
      {"<mujoco><include file='self.xml'/></mujoco>", "round.xml:2: include: "},
      {"<mujoco>\n<include file='no.xml'/></mujoco>", "model.xml:2: include: no such file"},
      {"<mujoco><include/></mujoco>", "file is missing"},
      {body("<geom sizes='1'/>"), "model.xml:4: geom: unknown attribute 'sizes'; known: name"},
      {body("<goem/>"), "model.xml:4: goem: unknown element in <body>"},
      {body("<composite/>"), "type is missing"},
      {body("<flexcomp/>"), "soft bodies (flex) are not supported"},
      {body("<geom type='cube'/>"), "model.xml:4: geom: type is 'cube', expected one of: plane"},
      {body("<geom size='nan'/>"), "model.xml:4: geom: size contains 'nan', expected finite numbers"},
      {body("<geom size='1,2'/>"), "size contains '1,2'"},
      {body("<geom type='box' size='1 2'/>"), "a box needs 3 sizes, and 2 are given"},
      {body("<geom size='-1'/>"), "size contains -1, expected positive numbers"},
      {body("<geom size='1' mass='-1'/>"), "mass is -1"},
      {body("<geom size='1' class='c'/>"), "there is no class of defaults named 'c'"},
      {body("<geom size='1' quat='0 0 0 0'/>"), "quat is zero"},
      {body("<geom size='1' quat='1 0 0 0' euler='0 0 0'/>"), "has several orientations"},
      {body("<geom type='mesh' mesh='m'/>"), "<asset> has no mesh named 'm'"},
      {body("<geom type='sphere' fromto='0 0 0 1 1 1'/>"), "a sphere cannot have fromto"},
      {body(in + "<joint axis='0 0 0'/>"), "axis has no direction"},
      {body(in + "<joint limited='true'/>"), "is limited but has no range"},
      {body(in + "<joint range='2 1'/>"), "range runs from 2 to 1"},
      {body(in + "<joint damping='-1'/>"), "damping is -1"},
      {body(in + "<joint name='j'/><joint name='j'/>"), "there are two joints of this name"},
      {body(in + "<joint/><freejoint/>"), "a free joint must be the only joint of its body"},
      {body(in + "<joint type='ball'/><joint/>"), "a ball must be the last"},
      {body(in + "<body><freejoint/></body>"), "must be a child of <worldbody>"},
      {body(in + "<body name='b'/>"), "there are two bodies of this name"},
      {body(in + in), "model.xml:4: inertial: body 'b' has two of these"},
      {body("<inertial mass='1'/>"), "pos is missing"},
      {body("<inertial pos='0 0 0' mass='-1' diaginertia='1 1 1'/>"), "model.xml:4: inertial: mass is -1"},
      {body("<inertial pos='0 0 0' mass='1' diaginertia='1 1 3'/>"), "balanceinertia"},
      {"<mujoco><compiler coordinate='global'/></mujoco>", "global coordinates are not supported"},
      {"<mujoco><compiler eulerseq='xyw'/></mujoco>", "eulerseq is 'xyw'"},
      {"<mujoco><worldbody/><equality><connect body1='c' anchor='0 0 0'/></equality></mujoco>",
       "there is no body named 'c'"},
      {"<mujoco><worldbody/><equality><joint joint1='c'/></equality></mujoco>",
       "there is no hinge or slide named 'c'"},
      {mesh("file='no.stl'"), "no such file"},
      {mesh("file='short.stl'"), "is too short for an STL file"},
      {mesh("file='m.dae'"), "expected a mesh in .stl, .obj or .msh"},
      {mesh("file='bad.obj'"), "bad.obj:2: the face refers to vertex 2, but only 1 come before it"},
      {mesh("file='open.obj'"), "encloses no volume"},
      {mesh("vertex='0 0 0 1 0 0 0 1 0 0 0 1' face='0 1 4'"), "face refers to vertex 4"},
      {mesh("vertex='0 0 0 1 0 0 0 1 0 1 1 0'"), "its points lie in one plane"},
      {mesh("vertex='0 0 0 1 0 0 0 1 0 0 0 1' maxhullvert='2'"), "maxhullvert is 2"}};
  for (const auto& [xml, said] : bad) {
    const auto model = read_model(folder.write("model.xml", xml));
    ASSERT_FALSE(model) << xml;
    EXPECT_NE(model.error().message().find(said), std::string::npos) << xml << "\n"
                                                                     << model.error().message();
    EXPECT_NE(model.error().where.find(".xml:"), std::string::npos) << model.error().message();
  }
  EXPECT_NE(read_model("/no/model.xml").error().message().find("no such file"), std::string::npos);
}

// Expat drops what it cannot expand: a model would lose its bodies without a word.
TEST(ModelFile, UnreadEntitiesAreRefused) {
  const Folder folder;
  const std::string inertial = "<inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/>";
  folder.write("part.ent", "<body>" + inertial + "</body>");
  const auto model = [&](const std::string& declared, const std::string& inside,
                         const std::string& name = "a") {
    return "<!DOCTYPE mujoco" + declared + ">\n<mujoco><worldbody>\n<body name='" + name + "'><freejoint/>" +
           inertial + inside + "</body></worldbody></mujoco>";
  };
  const auto said = [&](const std::string& text, const char* file = "model.xml") {
    const auto read = read_model(folder.write(file, text));
    return read ? "read" : read.error().message();
  };
  const std::string at = (folder.path() / "model.xml").string() + ":3: ";
  EXPECT_EQ(
      said(model(" [<!ENTITY part SYSTEM 'part.ent'>]", "&part;")),
      at + "takes text from the file 'part.ent' by an entity, which is not read; put the text in its place");
  const std::string unknown =
      "uses the entity '&part;', which the file does not define; put its text in its place";
  EXPECT_EQ(said(model(" SYSTEM 'all.dtd'", "&part;")), at + unknown);
  EXPECT_EQ(said(model(" SYSTEM 'all.dtd'", "", "&part;")), at + unknown);
  EXPECT_NE(said(model("", "&part;")).find("it uses an entity (&name;) that it does not define"),
            std::string::npos);
  // what the file itself defines stays
  EXPECT_EQ(said(model(" [<!ENTITY part \"<body>" + inertial + "</body>\">]", "&part;", "&lt;&#65;&amp;")),
            "read");
  EXPECT_EQ(said(model(" SYSTEM 'all.dtd' [<!ENTITY part 'b'>]", "", "&part;&lt;&#65;")), "read");
  // the other formats
  const std::string robot = "<!DOCTYPE robot SYSTEM 'all.dtd'>\n<robot name='r'>\n&part;</robot>";
  EXPECT_NE(said(robot, "r.urdf").find("r.urdf:3: " + unknown), std::string::npos) << said(robot, "r.urdf");
  const std::string osim =
      "<!DOCTYPE o SYSTEM 'a.dtd'>\n<OpenSimDocument Version='40000'>\n&part;</OpenSimDocument>";
  EXPECT_NE(said(osim, "m.osim").find("m.osim:3: " + unknown), std::string::npos) << said(osim, "m.osim");
}

TEST(ModelFile, FaultsOfXmlAreToldInPlainWords) {
  const Folder folder;
  for (const auto& [text, words] :
       {std::pair{"<mujoco></body>", "an end tag has another name"},
        {"<mujoco a='1' a='2'/>", "an element has two attributes of one name"},
        {"<mujoco/><mujoco/>", "something follows the end of the root element"},
        {"<?xml version='1.0' encoding='klingon'?><mujoco/>", "its encoding is not known"},
        {" <?xml version='1.0'?><mujoco/>", "'<?xml' does not stand at its very beginning"},
        {"<mujoco>&#0;</mujoco>", "a number (&#...;) stands for no character"},
        {"<mujoco a=1/>", "a character stands where XML does not allow it"}}) {
    const auto read = read_model(folder.write("model.xml", text));
    ASSERT_FALSE(read) << text;
    EXPECT_NE(read.error().message().find("model.xml:1: is not well-formed XML: " + std::string(words)),
              std::string::npos)
        << read.error().message();
  }
}

TEST(ModelFile, IncludesThatAreNoFilesGetTheirCause) {
  const Folder folder;
  std::filesystem::create_directories(folder.path() / "sub");
  ASSERT_EQ(mkfifo((folder.path() / "pipe").c_str(), 0600), 0);
  for (const auto& [name, cause] : {std::pair{"sub", "is a folder, expected a file"},
                                    {"pipe", "is not a regular file but a pipe or a device"},
                                    {"/dev/zero", "is not a regular file but a pipe or a device"},
                                    {"none.xml", "no such file"}})
    for (const std::string& text :
         {fmt::format("<mujoco>\n<include file='{}'/></mujoco>", name),
          fmt::format("<mujoco><asset>\n<model name='m' file='{}'/></asset><worldbody><attach model='m' "
                      "prefix='p'/></worldbody></mujoco>",
                      name)}) {
      const auto read = read_model(folder.write("model.xml", text));
      ASSERT_FALSE(read) << text;
      EXPECT_NE(read.error().message().find(cause), std::string::npos) << read.error().message();
      EXPECT_NE(read.error().where.find("model.xml:2"), std::string::npos) << read.error().message();
    }
}

TEST(ModelFile, ReadsDeepTreesAndRefusesEndlessOnes) {
  const auto nested = [](int n) {
    std::string open, close;
    for (int i = 0; i < n; ++i) {
      open +=
          "<body pos='0 0 -1'><joint axis='0 1 0'/><inertial pos='0 0 -.5' mass='1' diaginertia='.1 .1 "
          ".01'/>";
      close += "</body>";
    }
    return "<mujoco><worldbody>" + open + close + "</worldbody></mujoco>";
  };
  const Folder folder;
  EXPECT_EQ(need(read_model(folder.write("m.xml", nested(2000)))).scene.solids.size(), 2000u);
  std::string frames, ends;
  for (int i = 0; i < 9000; ++i) frames += "<frame>", ends += "</frame>";
  for (const std::string& text :
       {nested(20000), nested(3000), "<mujoco><worldbody>" + frames + ends + "</worldbody></mujoco>"}) {
    const auto endless = read_model(folder.write("m.xml", text));
    ASSERT_FALSE(endless);
    EXPECT_NE(endless.error().message().find("nested deeper than 2500"), std::string::npos);
  }
}

}  // namespace
}  // namespace borelli::test
