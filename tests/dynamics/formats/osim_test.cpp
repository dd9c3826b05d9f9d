// OpenSim models: both layouts against the same tree in Simbody (OpenSim's engine), joint by joint; OpenSim's
// gait models; refusals and listed losses.
#include "dynamics/formats/osim.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "dynamics/constraints/assembly.hpp"
#include "dynamics/equations/evaluate.hpp"
#include "dynamics/equations/jacobian.hpp"
#include "dynamics/formats/model_file.hpp"
#include "tests/dynamics/formats/osim_text.hpp"
#include "tests/dynamics/scenes.hpp"
#include "tests/dynamics/test_folder.hpp"
#ifdef BORELLI_SIMBODY
#include "tests/dynamics/simbody_tree.hpp"
#endif

namespace borelli::test::osim_test {
namespace {

Result<ModelFile> try_text(const std::string& text) {
  const Folder folder;
  return read_model(folder.write("model.osim", text));
}

ModelFile read_text(const std::string& text) { return need(try_text(text)); }

std::string complaint(const std::string& text) {
  const auto model = try_text(text);
  return model ? "" : model.error().message();
}

bool any_holds(const std::vector<std::string>& lines, const std::string& part) {
  return std::any_of(lines.begin(), lines.end(),
                     [&](const std::string& line) { return line.find(part) != std::string::npos; });
}

using Motions = std::map<std::string, std::pair<double, double>>;

/// A position and a rate for each free coordinate.
Motions random_state(const System& system, unsigned seed) {
  Random random(seed);
  Motions out;
  for (const CoordinateInfo& info : system.coordinates)
    out[info.name] = {random.number(-0.9, 0.9), random.number(-2, 2)};
  return out;
}

std::map<std::string, double> accelerations(const Scene& scene, const Motions& at, Equations equations) {
  System system = compiled(scene);
  system.settings.equations = equations;
  State state = system.initial;
  for (const CoordinateInfo& info : system.coordinates) {
    state.q[info.q_index] = at.at(info.name).first;
    state.v[info.v_index] = at.at(info.name).second;
  }
  const Evaluation now = need(evaluate(system, state));
  std::map<std::string, double> out;
  for (const CoordinateInfo& info : system.coordinates) out[info.name] = now.acceleration[info.v_index];
  return out;
}

double largest(const std::map<std::string, double>& a) {
  double out = 0;
  for (const auto& [name, x] : a) out = std::max(out, std::abs(x));
  return out;
}

TEST(Osim, BothLayoutsAccelerateAlike) {
  const Scene old = read_text(old_layout(all_joints())).scene,
              now = read_text(new_layout(all_joints())).scene;
  const Motions state = random_state(compiled(old), 5);
  EXPECT_EQ(state.size(), 23u);
  const auto a = accelerations(old, state, Equations::recursive),
             b = accelerations(now, state, Equations::recursive);
  for (const auto& [name, x] : a) EXPECT_NEAR(x, b.at(name), 1e-13 * largest(a)) << name;
}

#ifdef BORELLI_SIMBODY
SimbodyTree simbody_of(const std::vector<OsimPart>& parts) {
  SimbodyTree tree;
  for (const OsimPart& part : parts) {
    SimbodyMass mass;
    mass.mass = part.mass;
    mass.centre = part.centre;
    std::copy(part.inertia, part.inertia + 6, mass.inertia);
    std::vector<SimbodyAxis> axes;
    for (const OsimAxis& axis : part.axes) {
      const auto at = std::find(part.coordinates.begin(), part.coordinates.end(), axis.coordinate);
      axes.push_back(
          {axis.axis, at == part.coordinates.end() ? -1 : int(at - part.coordinates.begin()), axis.by});
    }
    std::string joint = part.joint.substr(0, part.joint.size() - 5);  // "PinJoint"
    joint[0] = char(std::tolower(joint[0]));
    tree.add(part.name, part.parent == "ground" ? "" : part.parent, joint,
             {part.place_in_parent, part.angles_in_parent}, {part.place, part.angles}, mass, part.coordinates,
             axes, part.reversed);
  }
  return tree;
}

void expect_simbodys(const std::vector<OsimPart>& parts, const std::string& text, unsigned seeds) {
  const Scene scene = read_text(text).scene;
  for (unsigned seed = 0; seed < seeds; ++seed) {
    SimbodyTree tree = simbody_of(parts);
    const Motions state = random_state(compiled(scene), seed);
    std::map<std::string, SimbodyTree::Motion> same;
    for (const auto& [name, x] : state) same[name] = {x.first, x.second};
    const auto theirs = tree.accelerations(same, {0, -9.80665, 0});
    for (const Equations equations : {Equations::recursive, Equations::lagrange}) {
      const auto ours = accelerations(scene, state, equations);
      ASSERT_EQ(ours.size(), theirs.size());
      for (const auto& [name, x] : ours)
        EXPECT_NEAR(x, theirs.at(name), 1e-10 * largest(ours)) << name << ", seed " << seed;
    }
  }
}

TEST(Osim, AllJointsAccelerateAsInSimbody) { expect_simbodys(all_joints(), old_layout(all_joints()), 5); }

TEST(Osim, ReversedJointsAccelerateAsInSimbody) {
  std::vector<OsimPart> parts = all_joints();
  for (OsimPart& part : parts)
    part.reversed = part.joint == "PinJoint" || part.joint == "CustomJoint" ||
                    part.joint == "UniversalJoint" || part.joint == "PlanarJoint";
  expect_simbodys(parts, old_layout(parts), 3);
}
#endif

// M(q) q'' + M'(q) q'^2 / 2 = Q(q). (Simbody 3.7's FunctionBased violates this if the first and third
// rotations share a coordinate, so it is no reference here.)
TEST(Osim, AKneeOfThreeRotationsObeysLagrangesEquation) {
  const System system = compiled(read_text(new_layout({turning_knee()})).scene);
  ASSERT_EQ(system.nv, 1);
  for (const double q : {-1.0, -0.5, 0.25, 0.65, 1.3}) {
    State state = system.initial, rest = state;
    state.q[0] = rest.q[0] = q;
    state.v[0] = 1.7;
    const auto mass = [&](double by) {
      State beside = rest;
      beside.q[0] += by;
      return need(evaluate(system, beside)).mass_matrix(0, 0);
    };
    const double h = 1e-3, slope = (8 * (mass(h) - mass(-h)) - mass(2 * h) + mass(-2 * h)) / (12 * h);
    const double a = need(evaluate(system, rest)).acceleration[0] - slope * 1.7 * 1.7 / (2 * mass(0));
    // the difference's error: h^4 times a fifth derivative, below 1e3
    EXPECT_NEAR(need(evaluate(system, state)).acceleration[0], a, 1e-8 * std::abs(a)) << q;
  }
}

TEST(Osim, AJointToTheGroundIsTakenTheOtherWay) {
  const std::string head =
      "<OpenSimDocument Version=\"40000\"><Model name=\"m\"><BodySet><objects><Body name=\"a\">"
      "<mass>1</mass><inertia>1 1 1 0 0 0</inertia></Body></objects></BodySet><JointSet>"
      "<objects><PinJoint name=\"j\"><socket_parent_frame>";
  const std::string middle = "</socket_parent_frame><socket_child_frame>";
  const std::string tail =
      "</socket_child_frame><coordinates><Coordinate name=\"q\"/></coordinates></PinJoint>"
      "</objects></JointSet></Model></OpenSimDocument>";
  const Scene out = read_text(head + "/ground" + middle + "/bodyset/a" + tail).scene,
              in = read_text(head + "/bodyset/a" + middle + "/ground" + tail).scene;
  EXPECT_EQ(std::get<Rotation>(out.solids[0].switches[0].kind).axis, Vector3d::UnitZ());
  EXPECT_EQ(std::get<Rotation>(in.solids[0].switches[0].kind).axis, -Vector3d::UnitZ());
}

TEST(Osim, CoordinatesAreLockedDrivenAndLimited) {
  std::vector<OsimPart> parts = all_joints();
  const auto said = [&](const std::string& text) {
    std::vector<OsimPart> one{parts[1]};
    one[0].parent = "ground";
    one[0].said = text;
    return read_text(new_layout(one));
  };
  const auto first = [](const ModelFile& m) {
    for (const Switch& s : m.scene.solids[0].switches)
      if (!s.coordinate.empty()) return s;
    return Switch{};
  };
  const Switch locked = first(said("<default_value>0.3</default_value><locked>true</locked>"));
  EXPECT_TRUE(std::holds_alternative<Locked>(locked.motion));
  EXPECT_EQ(locked.q, std::vector<double>{0.3});
  const Switch driven =
      first(said("<prescribed>true</prescribed><prescribed_function><PolynomialFunction>"
                 "<coefficients>3 2 1</coefficients></PolynomialFunction></prescribed_function>"));
  ASSERT_TRUE(std::holds_alternative<Driven>(driven.motion));
  const TimeValue value = at(std::get<Driven>(driven.motion).functions[0], 2);
  EXPECT_EQ(value.value, 17);  // 3 t^2 + 2 t + 1
  EXPECT_EQ(value.rate, 14);
  const ModelFile limited = said(
      "<default_value>2</default_value><default_speed_value>0.5</default_speed_value>"
      "<range>-1 1.5</range><clamped>true</clamped>");
  ASSERT_EQ(first(limited).ranges.size(), 1u);
  EXPECT_EQ(first(limited).ranges[0].upper, 1.5);
  EXPECT_EQ(first(limited).q, std::vector<double>{1.5});
  EXPECT_EQ(first(limited).v, std::vector<double>{0.5});
  EXPECT_TRUE(any_holds(limited.not_modelled.motion, "outside its range"));
  EXPECT_TRUE(first(said("<range>-1 1.5</range><clamped>false</clamped>")).ranges.empty());
}

TEST(Osim, CouplersTieCoordinates) {
  std::vector<OsimPart> parts = all_joints();
  const std::string pin = parts[1].coordinates[0], slider = parts[2].coordinates[0];
  const auto coupler = [&](const std::string& function, const std::string& of) {
    return read_text(new_layout(
        parts,
        "<ConstraintSet><objects><CoordinateCouplerConstraint name=\"c\"><isEnforced>true</isEnforced>"
        "<coupled_coordinates_function>" +
            function + "</coupled_coordinates_function><independent_coordinate_names>" + of +
            "</independent_coordinate_names><dependent_coordinate_name>" + slider +
            "</dependent_coordinate_name><scale_factor>2</scale_factor>"
            "</CoordinateCouplerConstraint></objects></ConstraintSet>"));
  };
  const std::string line = "<LinearFunction><coefficients>0.5 0.1</coefficients></LinearFunction>";
  const System one = compiled(coupler(line, pin).scene);
  EXPECT_EQ(one.rows, 1);
  for (const CoordinateInfo& info : one.coordinates)
    if (info.name == slider) {
      EXPECT_EQ(one.initial.q[info.q_index], 0.2);  // 2 (0.5 x + 0.1) at 0
    }
  const System two = compiled(
      coupler("<LinearFunction><coefficients>1 2 3</coefficients></LinearFunction>", pin + " pelvis_rx")
          .scene);
  const auto& tie = std::get<CoordinateCoupling>(two.parameters.constraints[0].kind);
  EXPECT_EQ(tie.ratios, (std::vector<double>{1, -2, -4}));
  EXPECT_EQ(at(tie.value, 0).value, 6);
}

TEST(Osim, AMasslessBodyThatFollowsIsLocked) {
  std::vector<OsimPart> parts = all_joints();
  std::string text = new_layout(
      parts,
      "<ConstraintSet><objects><CoordinateCouplerConstraint name=\"c\"><coupled_coordinates_function>"
      "<LinearFunction><coefficients>2 0.3</coefficients></LinearFunction></coupled_coordinates_function>"
      "<independent_coordinate_names>pin_q</"
      "independent_coordinate_names><dependent_coordinate_name>knee_angle"
      "</dependent_coordinate_name></CoordinateCouplerConstraint></objects></ConstraintSet>");
  const std::size_t tibia = text.find("<Body name=\"tibia\">"), end = text.find("</Body>", tibia);
  text.replace(tibia, end - tibia, "<Body name=\"tibia\">");
  const ModelFile model = read_text(text);
  EXPECT_TRUE(any_holds(model.not_modelled.motion,
                        "locked coordinates, which follow others and move no mass: knee_angle"));
  const System system = compiled(model.scene);
  EXPECT_EQ(system.nv, 22);
  EXPECT_EQ(system.rows, 0);
}

TEST(Osim, PointsAndWeldsAreHeldAndSpringsPull) {
  const std::vector<OsimPart> parts = all_joints();
  const std::string a = "/bodyset/" + parts[0].name, b = "/bodyset/" + parts[1].name;
  const std::string sets =
      "<ConstraintSet><objects><PointConstraint name=\"p\"><socket_body_1>" + a +
      "</socket_body_1><socket_body_2>" + b +
      "</socket_body_2><location_body_1>1 2 3</location_body_1></PointConstraint>"
      "<ConstantDistanceConstraint name=\"d\"><socket_body_1>" +
      a +
      "</socket_body_1><socket_body_2>/ground"
      "</socket_body_2><constant_distance>0.7</constant_distance></ConstantDistanceConstraint>"
      "<WeldConstraint name=\"w\"><socket_frame1>" +
      a + "</socket_frame1><socket_frame2>" + b +
      "</socket_frame2></WeldConstraint><PointConstraint name=\"off\"><isEnforced>false</isEnforced>"
      "</PointConstraint><RollingOnSurfaceConstraint "
      "name=\"r\"/></objects></ConstraintSet><ForceSet><objects>"
      "<PointToPointSpring name=\"s\"><socket_body1>" +
      a +
      "</socket_body1><socket_body2>/ground</socket_body2>"
      "<stiffness>5</stiffness><rest_length>0.2</rest_length></PointToPointSpring>"
      "<Thelen2003Muscle name=\"m\"/></objects></ForceSet>";
  const auto outside = [&](const std::string& begin, const std::string& end) {
    std::string out = sets;
    for (const auto& [from, to] : {std::pair{std::string("<ConstraintSet><objects>"), begin},
                                   {"</objects></ConstraintSet><ForceSet><objects>", ""},
                                   {"</objects></ForceSet>", end}})
      out.replace(out.find(from), from.size(), to);
    return out;
  };
  for (const std::string& where : {sets, outside("<components>", "</components>"),
                                   outside("<ComponentSet><objects>", "</objects></ComponentSet>")}) {
    const ModelFile model = read_text(new_layout(parts, where));
    ASSERT_EQ(model.scene.constraints.size(), 3u);
    EXPECT_EQ(std::get<PointOnPoint>(model.scene.constraints[0].kind).a.point, Vector3d(1, 2, 3));
    EXPECT_EQ(at(std::get<Distance>(model.scene.constraints[1].kind).distance, 0).value, 0.7);
    EXPECT_TRUE(std::holds_alternative<WeldConstraint>(model.scene.constraints[2].kind));
    ASSERT_EQ(model.scene.efforts.size(), 1u);
    EXPECT_EQ(std::get<PointSpring>(model.scene.efforts[0].kind).rest_length, 0.2);
    EXPECT_TRUE(any_holds(model.not_modelled.motion, "Thelen2003Muscle"));
    EXPECT_TRUE(any_holds(model.not_modelled.motion, "RollingOnSurfaceConstraint"));
    EXPECT_FALSE(any_holds(model.not_modelled.motion, "<PointConstraint>"));
    EXPECT_TRUE(any_holds(model.not_modelled.other, "<PointConstraint>"));
  }
}

TEST(Osim, RefusesUnsupportedContentByName) {
  std::vector<OsimPart> parts{all_joints()[1]};
  parts[0].parent = "ground";
  const std::string good = new_layout(parts);
  EXPECT_EQ(complaint(good), "");
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    for (std::size_t at; (at = text.find(from)) != std::string::npos;) text.replace(at, from.size(), to);
    return complaint(text);
  };
  EXPECT_NE(with("PinJoint", "EllipsoidJoint").find("joints of type EllipsoidJoint are not supported"),
            std::string::npos);
  EXPECT_NE(with("/bodyset/upper", "/bodyset/nobody").find("nobody"), std::string::npos);
  EXPECT_NE(with("<mass>2</mass>", "<mass>two</mass>").find("expected finite numbers"), std::string::npos);
  EXPECT_NE(with("<mass>2</mass>", "<mass>-2</mass>").find("expected 0 or more"), std::string::npos);
  EXPECT_NE(with("<BodySet name", "<BodySet file=\"b.xml\" name").find("another file"), std::string::npos);
  EXPECT_NE(complaint("<OpenSimDocument Version=\"40000\"><InverseKinematicsTool/></OpenSimDocument>")
                .find("Model"),
            std::string::npos);
  EXPECT_NE(with("Version=\"40000\"", "Version=\"10800\"").find("before OpenSim 2"), std::string::npos);
  std::vector<OsimPart> loop = {all_joints()[0], all_joints()[1]};
  loop[0].parent = "upper";
  EXPECT_NE(complaint(new_layout(loop)).find("its own ancestor"), std::string::npos);
}

// ---- the gait models of OpenSim ----

double mass_of(const Scene& scene) {
  double mass = 0;
  for (const Solid& solid : scene.solids)
    for (const Inertial& one : solid.inertials) mass += one.mass;
  return mass;
}

std::filesystem::path shared(const std::string& name) {
  return std::filesystem::path(shared_folder()) / name;
}

TEST(Osim, ReadsTheGaitModelsOfBothLayouts) {
  const auto old = shared("models/gait10dof18musc_subject01.osim"),
             now = shared("motion/gait10dof/subject01.osim");
  if (!exists(old) || !exists(now)) GTEST_SKIP() << "no " << old << " or " << now;
  for (const auto& path : {old, now}) {
    const ModelFile model = need(read_model(path));
    const System system = compiled(model.scene);
    EXPECT_EQ(system.nv, 10) << path;
    EXPECT_EQ(system.rows, 0) << path;  // the knees need no constraints
    EXPECT_NEAR(mass_of(model.scene), 72.6, 1e-9) << path;
    EXPECT_TRUE(any_holds(model.not_modelled.motion, "Thelen2003Muscle") ||
                any_holds(model.not_modelled.motion, "Millard2012EquilibriumMuscle"))
        << path;
    const Evaluation start = need(evaluate(system, system.initial));
    EXPECT_TRUE(start.acceleration.allFinite());
  }
  EXPECT_EQ(need(read_model(now)).scene.markers.size(), 39u);
}

}  // namespace
}  // namespace borelli::test::osim_test
