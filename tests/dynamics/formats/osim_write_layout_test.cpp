// The OpenSim models that we write have their elements where OpenSim's own files have them, and refer to
// existing names.
#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <set>

#include "dynamics/formats/model_write.hpp"
#include "dynamics/formats/xml_element.hpp"
#include "tests/dynamics/scenes.hpp"
#include "tests/dynamics/test_folder.hpp"

namespace borelli::test::osim_write_layout_test {
namespace {

// ---- elements as in OpenSim's own files ----

using Pairs = std::set<std::pair<std::string, std::string>>;

void collect_pairs(const XmlElement& e, Pairs& out) {
  for (const XmlElement& c : e.children) {
    out.emplace(e.name, c.name);
    collect_pairs(c, out);
  }
}

Pairs known_pairs() {
  std::ifstream file(source_folder() + "/tests/dynamics/formats/osim_nesting.csv");
  Pairs out;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("#") || line.starts_with("parent,")) continue;
    const auto one = line.find(','), two = line.find(',', one + 1);
    out.emplace(line.substr(0, one), line.substr(one + 1, two - one - 1));
  }
  return out;
}

/// A scene with every element that the writer supports.
WrittenModel everything() {
  constexpr auto turns = GuidedPart::Kind::rotation, slides = GuidedPart::Kind::translation;
  const Table spline({-1, -0.2, 0.5, 1.1, 2}, {0.1, -0.1, 0.3, 0.2, 0.5}, SplineEnds::forsythe),
      natural(spline.times, spline.values);
  Switch knee = hinge("knee", Vector3d::UnitX());
  knee.kind = Guided{{{slides, Vector3d::UnitX(), spline},
                      {slides, Vector3d::UnitY(), natural},
                      {turns, Vector3d::UnitZ(), linear(0.1, -1.5)},
                      {turns, Vector3d::UnitX(), Polynomial{{0.1, 0.2, -0.3, 0.4}}},
                      {turns, Vector3d::UnitY(), Sine{0.3, 2, 0.4, 0.1}}}};
  Scene scene;
  scene.solids = {solid("base", "world", {hinge("base", Vector3d(1, 2, 2) / 3)}, {link()}),
                  solid("s", "base", {knee}, {link()})};
  scene.description = "everything";
  scene.solids.push_back(solid("welded", "s", {fixed({1, 0, 0})}, {link()}));
  scene.solids.push_back(solid("pin", "world", {hinge("pin", Vector3d::UnitZ())}, {link()}));
  scene.solids.push_back(solid("slider", "world", {slide("slider", Vector3d::UnitX())}, {link()}));
  scene.solids.push_back(
      solid("driven", "world", {driven(hinge("driven", Vector3d::UnitY()), linear(0, 1))}, {link()}));
  for (const Form& form : {Form(Box{{1, 2, 3}}), Form(Sphere{1}), Form(Cylinder{1, 2}),
                           Form(Ellipsoid{{1, 2, 3}}), Form(Cone{1, 2}), Form(Capsule{1, 2})})
    scene.solids[0].shapes.push_back({{form}, {}, {}});
  scene.markers = {{"m", {"s", {1, 2, 3}}}};
  scene.efforts = {{"a", PointSpring{{"s"}, {"world"}, 1, 0, 0}},
                   {"b", PointSpring{{"s"}, {"world"}, 1, 1, 0}},
                   {"c", CoordinateSpring{{"base"}, 1, 1, 0}},
                   {"d", LimitSpring{{"base"}, 1, 1, {{-1, 1}}}},
                   {"e", Force{{"s"}, {1, 2, 3}, Axes::world, Sine{}, {}}},
                   {"f", Torque{{"s"}, {1, 2, 3}, Axes::world, natural, {}}}};
  scene.constraints = {{"a", PointOnPoint{{"s"}, {"pin"}}},
                       {"b", PointOnLine{{"s"}, {"pin"}, Vector3d::UnitX()}},
                       {"c", Distance{{"s"}, {"pin"}, constant(1)}},
                       {"d", WeldConstraint{{"s"}, {"pin"}, {}}},
                       {"e", CoordinateFunction{{"pin"}, {"base"}, Polynomial{{1, 2, 3}}}},
                       {"f", CoordinateCoupling{{{"pin"}, {"base"}}, {1, 1}, constant(0)}},
                       {"g", SphereOverPlane{{"s"}, 1, {{"world"}, Vector3d::UnitZ()}, {}}}};
  ModelExtras extras;
  extras.meshes = {{"s", "bone.stl", 0.001, {0, 0, 0}}, {"pin", "../far bone.stl", 1, {1, 2, 3}}};
  extras.frames = {{"s", "anatomical", Pose{}}};
  extras.comments = {"made -- by hand"};
  return need(write_osim(scene, extras));
}

TEST(OsimWriteLayout, ElementsNestAsInOpenSimsFiles) {
  const Pairs known = known_pairs();
  ASSERT_GT(known.size(), 100u);
  const Folder folder;
  const XmlElement root = read_xml(folder.write("all.osim", everything().text));
  EXPECT_EQ(root.name, "OpenSimDocument");
  EXPECT_EQ(root.text("Version"), "40000");
  Pairs own;
  collect_pairs(root, own);
  EXPECT_GT(own.size(), 120u);
  for (const auto& pair : own) EXPECT_TRUE(known.contains(pair)) << pair.first << " > " << pair.second;
  // the scene has every element of the table
  for (const auto& pair : known) EXPECT_TRUE(own.contains(pair)) << pair.first << " > " << pair.second;
}

TEST(OsimWriteLayout, EveryReferencedFrameExists) {
  const Folder folder;
  const XmlElement root = read_xml(folder.write("all.osim", everything().text));
  std::set<std::string> paths{"/ground"};
  for (const XmlElement& body :
       root.require_child("Model").require_child("BodySet").require_child("objects").children)
    EXPECT_TRUE(paths.insert("/bodyset/" + body.text("name")).second) << body.text("name");
  int named = 0;
  const std::function<void(const XmlElement&)> walk = [&](const XmlElement& e) {
    for (const XmlElement& c : e.children) {
      if (c.name.starts_with("socket_") || c.name == "body1" || c.name == "body2") {
        ++named;
        if (c.content == "..") continue;
        if (c.content.starts_with("/")) {
          EXPECT_TRUE(paths.contains(c.content)) << c.content;
          continue;
        }
        int frames = 0;  // frames of the joint or constraint
        for (const XmlElement& frame : e.require_child("frames").children)
          frames += frame.text("name") == c.content;
        EXPECT_EQ(frames, 1) << c.content;
      }
      walk(c);
    }
  };
  walk(root);
  EXPECT_GT(named, 50);
}

}  // namespace
}  // namespace borelli::test::osim_write_layout_test
