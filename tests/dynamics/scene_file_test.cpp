// Scene files: reading is correct, written scenes read back exactly, and errors are refused with their line.
// Thousands of damaged samples do not crash the reader.
#include "dynamics/formats/scene_file.hpp"
#include "tests/paths.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numbers>
#include <random>

#include "dynamics/system/system.hpp"

namespace borelli {
namespace {

namespace fs = std::filesystem;
using Eigen::Matrix3d;
using Eigen::Vector3d;

std::vector<fs::path> samples() {
  std::vector<fs::path> out;
  for (const auto& entry : fs::directory_iterator(test::source_folder() + "/samples"))
    if (entry.path().extension() == ".toml") out.push_back(entry.path());
  std::sort(out.begin(), out.end());
  return out;
}

std::string text_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

Scene parsed(const std::string& text) {
  auto scene = parse_scene(text, "scene.toml");
  EXPECT_TRUE(scene) << scene.error().message() << "\n" << text;
  return scene.value_or(Scene{});
}

// ---- equality, bit for bit ----

bool same(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }

struct Compare {
  bool equal = true;
  void operator()(double a, double b) { equal &= same(a, b); }
  void operator()(const std::string& a, const std::string& b) { equal &= a == b; }
  void operator()(bool a, bool b) { equal &= a == b; }
  template <class T>
  void operator()(const std::vector<T>& a, const std::vector<T>& b) {
    equal &= a.size() == b.size();
    for (std::size_t i = 0; equal && i < a.size(); ++i) (*this)(a[i], b[i]);
  }
  template <class T>
  void operator()(const std::optional<T>& a, const std::optional<T>& b) {
    equal &= a.has_value() == b.has_value();
    if (a && b) (*this)(*a, *b);
  }
  template <class T, int r, int c, int o>
  void operator()(const Eigen::Matrix<T, r, c, o>& a, const Eigen::Matrix<T, r, c, o>& b) {
    for (Eigen::Index i = 0; i < a.size(); ++i) (*this)(a.data()[i], b.data()[i]);
  }
  template <class T, std::size_t n>
  void operator()(const std::array<T, n>& a, const std::array<T, n>& b) {
    equal &= a == b;
  }
  template <class... T>
  void operator()(const std::variant<T...>& a, const std::variant<T...>& b) {
    equal &= a.index() == b.index();
    if (!equal) return;
    std::visit([&]<class K>(const K& k) { (*this)(k, std::get<K>(b)); }, a);
  }
  template <class T>
  requires requires { T::kind; }
  void operator()(const T& a, const T& b) {  // structs with named fields: compares field by field
    std::vector<const void*> of_b;
    T::fields(b, [&](const char*, const auto& field) { of_b.push_back(&field); });
    std::size_t i = 0;
    T::fields(
        a, [&]<class F>(const char*, const F& field) { (*this)(field, *static_cast<const F*>(of_b[i++])); });
  }
  void operator()(const Free&, const Free&) {}
  void operator()(const Locked&, const Locked&) {}
  void operator()(const Driven& a, const Driven& b) { (*this)(a.functions, b.functions); }
  void operator()(const Coupled& a, const Coupled& b) {
    (*this)(a.to, b.to), (*this)(a.function, b.function);
  }
  void operator()(const GuidedPart& a, const GuidedPart& b) {
    equal &= a.kind == b.kind;
    (*this)(a.axis, b.axis), (*this)(a.by, b.by);
  }
  void operator()(const Marker& a, const Marker& b) { (*this)(a.name, b.name), (*this)(a.at, b.at); }
  void operator()(Axes a, Axes b) { equal &= a == b; }
  void operator()(SplineEnds a, SplineEnds b) { equal &= a == b; }
  void operator()(const Pose& a, const Pose& b) { (*this)(a.R, b.R), (*this)(a.p, b.p); }
  void operator()(const SolidPoint& a, const SolidPoint& b) {
    (*this)(a.solid, b.solid), (*this)(a.point, b.point);
  }
  void operator()(const SolidName& a, const SolidName& b) { (*this)(a.solid, b.solid); }
  void operator()(const CoordinateName& a, const CoordinateName& b) { (*this)(a.coordinate, b.coordinate); }
  void operator()(const AnyCoordinate& a, const AnyCoordinate& b) { (*this)(a.coordinate, b.coordinate); }
  void operator()(const Range& a, const Range& b) { (*this)(a.lower, b.lower), (*this)(a.upper, b.upper); }
  void operator()(const Switch& a, const Switch& b) {
    (*this)(a.kind, b.kind), (*this)(a.coordinate, b.coordinate), (*this)(a.motion, b.motion);
    (*this)(a.q, b.q), (*this)(a.v, b.v), (*this)(a.ranges, b.ranges);
  }
  void operator()(const Inertial& a, const Inertial& b) {
    (*this)(a.mass, b.mass), (*this)(a.centre, b.centre), (*this)(a.tensor, b.tensor);
  }
  void operator()(const Box& a, const Box& b) { (*this)(a.size, b.size); }
  void operator()(const Sphere& a, const Sphere& b) { (*this)(a.radius, b.radius); }
  void operator()(const Ellipsoid& a, const Ellipsoid& b) { (*this)(a.radii, b.radii); }
  template <class T>
  requires std::is_same_v<T, Cylinder> || std::is_same_v<T, Cone> || std::is_same_v<T, Capsule>
  void operator()(const T& a, const T& b) { (*this)(a.radius, b.radius), (*this)(a.length, b.length); }
  void operator()(const ClosedMesh& a, const ClosedMesh& b) {
    (*this)(a.vertices, b.vertices), (*this)(a.triangles, b.triangles);
  }
  void operator()(const Shape& a, const Shape& b) {
    (*this)(a.form, b.form), (*this)(a.position, b.position);
    (*this)(a.orientation.coeffs(), b.orientation.coeffs());
  }
  void operator()(const ShapeElement& a, const ShapeElement& b) {
    (*this)(a.shape, b.shape);
    (*this)(a.density, b.density), (*this)(a.mass, b.mass);
  }
  void operator()(const Solid& a, const Solid& b) {
    (*this)(a.name, b.name), (*this)(a.parent, b.parent), (*this)(a.switches, b.switches);
    (*this)(a.inertials, b.inertials), (*this)(a.shapes, b.shapes);
  }
  void operator()(const Effort& a, const Effort& b) { (*this)(a.name, b.name), (*this)(a.kind, b.kind); }
  void operator()(const Constraint& a, const Constraint& b) {
    (*this)(a.name, b.name), (*this)(a.kind, b.kind);
  }
  void operator()(const SimulationSettings& a, const SimulationSettings& b) {
    (*this)(a.end_time, b.end_time), (*this)(a.step, b.step);
    (*this)(a.accuracy, b.accuracy);
    if (a.accuracy == 0) (*this)(a.method, b.method), (*this)(a.tolerance, b.tolerance);  // else chosen
    equal &= a.verify == b.verify, (*this)(a.spectral_radius, b.spectral_radius);
    (*this)(a.output_interval, b.output_interval);
    equal &= a.constraints == b.constraints;
    (*this)(a.baumgarte_alpha, b.baumgarte_alpha), (*this)(a.baumgarte_beta, b.baumgarte_beta);
    (*this)(a.energy_threshold, b.energy_threshold);
    equal &= a.impacts == b.impacts && a.restitution == b.restitution;
    (*this)(a.rest_speed, b.rest_speed);
    equal &= a.equations == b.equations;
  }
  void operator()(const Scene& a, const Scene& b) {
    (*this)(a.name, b.name), (*this)(a.description, b.description), (*this)(a.gravity, b.gravity);
    (*this)(a.solids, b.solids), (*this)(a.efforts, b.efforts), (*this)(a.constraints, b.constraints);
    (*this)(a.markers, b.markers);
    (*this)(a.simulation, b.simulation);
  }
};

bool same(const Scene& a, const Scene& b) {
  Compare compare;
  compare(a, b);
  return compare.equal;
}

void expect_round_trip(const Scene& scene) {
  const auto text = write_scene(scene);
  ASSERT_TRUE(text) << text.error().message();
  const auto back = parse_scene(*text, "scene.toml");
  ASSERT_TRUE(back) << back.error().message() << "\n" << *text;
  EXPECT_EQ(*write_scene(*back), *text);
  EXPECT_TRUE(same(scene, *back)) << *text;
  if (scene.simulation.accuracy == 0) return;
  Scene otherwise = scene;
  otherwise.simulation.accuracy = 0;
  expect_round_trip(otherwise);
}

// A scene with every kind of element and numbers of many orders of magnitude.
Scene varied(unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> exponent(-20, 20), half(-1, 1);
  const auto number = [&] { return half(random) * std::pow(10, exponent(random)); };
  const auto positive = [&] { return std::abs(number()) + 1e-30; };
  const auto vector = [&] { return Vector3d(number(), number(), number()); };
  const auto turn = [&] {
    const Vector3d axis = Vector3d(half(random), half(random), half(random)).normalized();
    return rotation_about(axis, 3 * half(random));
  };
  const auto inertial = [&] {
    const double m = positive(), s = positive();
    const Matrix3d R = turn();
    Matrix3d tensor = R * (s * Vector3d(2, 3, 4)).asDiagonal() * R.transpose();
    tensor = (0.5 * (tensor + tensor.transpose())).eval();
    return Inertial{m, vector(), tensor};
  };
  const TimeFunction wave = Sine{number(), number(), number(), number()};
  const TimeFunction ramp = Polynomial{{number(), number(), number()}};
  Eigen::Quaterniond q(turn());
  q.normalize();

  Scene scene;
  scene.name = "varied \"scene\" \\ of many kinds";
  scene.description = "first line\nsecond, with a tab\t, a \"quote\" and a \\\n\nend";
  scene.gravity = vector();
  scene.simulation = {positive(),
                      "rk4",
                      positive(),
                      positive(),
                      positive(),
                      true,
                      std::abs(half(random)),
                      positive(),
                      Equations::lagrange,
                      ConstraintTreatment::baumgarte,
                      positive(),
                      positive(),
                      positive()};
  scene.simulation.impacts = ImpactLaw::simultaneous;
  scene.simulation.restitution = RestitutionLaw::poisson;
  scene.simulation.rest_speed = positive();
  Solid first{"first", "second", {}, {inertial()}, {}};
  first.switches = {{Fixed{{turn(), vector()}}, "", Free{}, {}, {}, {}},
                    {Rotation{-Vector3d::UnitY()}, "a", Free{}, {half(random)}, {number()}, {Range{-1.5, 2}}},
                    {Translation{turn().col(0)}, "b", Driven{{wave}}, {}, {}, {}},
                    {Screw{-Vector3d::UnitZ(), number()},
                     "s",
                     Driven{{Table({0, 1, 2, 4}, {1, 0, 2, 1}, SplineEnds::periodic)}},
                     {},
                     {},
                     {}},
                    {Screw{Vector3d::UnitX(), number()}, "t", Coupled{"a", ramp}, {}, {}, {}},
                    {Translation{}, "", Free{}, {-0.}, {0.}, {}},
                    {Guided{{{GuidedPart::Kind::translation, turn().col(0), wave},
                             {GuidedPart::Kind::rotation, -Vector3d::UnitZ(),
                              Table({0, 1, 2, 4}, {1, 0, 2, 1}, SplineEnds::forsythe)}}},
                     "g",
                     Free{},
                     {number()},
                     {},
                     {}},
                    {Ball{}, "c", Driven{{ramp, constant(0.1), wave}}, {q.w(), q.x(), q.y(), q.z()}, {}, {}}};
  Solid second{"second", "world", {}, {inertial(), inertial()}, {}};
  second.switches = {
      {Ball{}, "d", Free{}, {}, {number(), number(), number()}, {{0, 1. / 3}, {-1, 0}, {-2, 2}}},
      {Rotation{}, "e", Locked{}, {number()}, {}, {}}};
  const ClosedMesh mesh{{{0, 0, 0}, {0.1, 0, 0}, {0, 0.2, 0}, {0, 0, 0.3}},
                        {{{0, 2, 1}}, {{0, 1, 3}}, {{0, 3, 2}}, {{1, 2, 3}}}};
  second.shapes = {{{Box{Vector3d(0.1, 0.2, 1. / 3)}, vector(), q}, positive(), {}},
                   {{Sphere{positive()}}, {}, positive()},
                   {{Ellipsoid{Vector3d(0.1, 0.2, 0.7)}}, {}, {}},
                   {{Cylinder{0.1, 0.3}}, {}, 2},
                   {{Cone{0.1, 0.3}}, 3, {}},
                   {{Capsule{0.1, 0.3}}, {}, {}},
                   {{mesh}, 1000, {}}};
  scene.solids = {first, second};
  const SolidPoint a{"first", vector()}, b{"second", vector()}, w{"world", vector()};
  scene.efforts = {
      {"push", Force{a, vector(), Axes::solid, wave, b}},
      {"pull", Force{b, vector(), Axes::world, constant(1), {}}},
      {"none", Force{SolidPoint{}, Vector3d::Zero(), Axes::world, constant(1), {}}},
      {"twist", Torque{{"first"}, vector(), Axes::world, ramp, SolidName{"second"}}},
      {"band", PointSpring{a, w, positive(), positive(), positive()}},
      {"coil", TorsionSpring{{"first"}, {"world"}, positive(), positive(), vector()}},
      {"stop", CoordinateSpring{{"a"}, positive(), positive(), number()}},
      {"bumper", LimitSpring{{"a"}, positive(), positive(), {{-0.5, positive()}}}},
      {"own bumper", LimitSpring{{"a"}, positive(), 0, {}}},
      {"socket", LimitSpring{{"d"}, positive(), positive(), {{-1, 1. / 3}, {0, positive()}, {-1, 0}}}},
      {"servo", PdController{{"a"}, positive(), positive(), {wave}}},
      {"gimbal", PdController{{"d"}, positive(), positive(), {constant(number()), ramp, wave}}},
      {"rest", PdController{{"a"}, positive(), 0, {constant(0)}}},
      {"air", Drag{a, positive(), positive()}},
      {"oil", AngularDrag{{"second"}, positive(), positive()}}};
  scene.markers = {{"heel", {"first", vector()}}, {"origin", {"world", vector()}}};
  scene.constraints = {
      {"pin", PointOnPoint{a, b}},
      {"table", PointOnPlane{a, {w, Vector3d(1, 2, 3)}, wave}},
      {"rod", Distance{a, b, constant(positive())}},
      {"slot", PointOnLine{a, w, Vector3d(1, 2, 3)}},
      {"rail", PointOnCurve{a, {"second"}, {vector(), vector(), vector()}, true}},
      {"lean", AngleConstraint{{"first"}, Vector3d(1, 2, 3), {"world"}, Vector3d::UnitX(), ramp}},
      {"cam", CoordinateFunction{{"a"}, {"b"}, Table({0, 1, 3}, {number(), number(), number()})}},
      {"rod at its default", Distance{a, b, constant(1)}},
      {"gear", CoordinateCoupling{{{"a"}, {"b"}}, {number(), number()}, ramp}},
      {"glue", WeldConstraint{{"first"}, {"second"}, {turn(), vector()}}},
      {"coin", RollingDisc{a, vector(), positive(), {w, Vector3d(1, 2, 3)}, true}},
      {"marble", RollingSphere{b, positive(), {a, -Vector3d::UnitX()}, false}},
      {"skate", KnifeEdge{a, Vector3d(1, 2, 3), {"second"}}},
      {"stops", Limit{{"a"}, number(), number(), positive()}},
      {"stop below", Limit{{"b"}, number(), {}, 0}},
      {"rope", Rope{a, w, positive(), positive()}},
      {"bead", SphereOverPlane{a, positive(), {b, Vector3d(1, 2, 3)}, {positive(), positive()}}},
      {"pill",
       CapsuleOverPlane{
           a, vector(), positive(), positive(), {w, -Vector3d::UnitX()}, {positive(), positive()}}},
      {"crate", BoxOverPlane{b, vector(), {a, Vector3d(3, 2, 1)}, {positive(), positive()}}},
      {"marbles", SphereOverSphere{a, b, positive(), positive(), {positive(), positive()}}},
      {"sticks", CapsuleOverCapsule{a,
                                    b,
                                    vector(),
                                    Vector3d::UnitY(),
                                    positive(),
                                    positive(),
                                    positive(),
                                    positive(),
                                    {positive(), positive()}}},
      {"drum",
       ConvexOverPlane{
           {"first"}, {Cylinder{positive(), positive()}, vector(), q}, {w, -Vector3d::UnitX()}, {0, 1}, {}}},
      {"bricks", ConvexOverConvex{
                     {"first"}, {"second"}, {Box{vector()}, vector(), q}, {mesh}, {positive(), 1}, {}, {}}}};
  return scene;
}

TEST(SceneFile, EverySampleIsReadAndRoundTrips) {
  ASSERT_GE(samples().size(), 6u);
  for (const fs::path& path : samples()) {
    SCOPED_TRACE(path.filename());
    const auto scene = read_scene(path);
    ASSERT_TRUE(scene) << scene.error().message();
    EXPECT_FALSE(scene->name.empty());
    expect_round_trip(*scene);
  }
}

TEST(SceneFile, EveryKindRoundTripsBitForBit) {
  for (unsigned seed = 0; seed < 200; ++seed) expect_round_trip(varied(seed));
}

TEST(SceneFile, RandomNumbersRoundTripBitForBit) {
  // toml++ must read the shortest decimal form of any finite number exactly
  std::mt19937_64 random(1);
  for (int i = 0; i < 20000; ++i) {
    const std::uint64_t bits = random();
    double value;
    std::memcpy(&value, &bits, sizeof value);
    if (!std::isfinite(value)) continue;
    Scene scene;
    scene.gravity.x() = value;
    const auto back = parse_scene(*write_scene(scene), "s");
    ASSERT_TRUE(back) << back.error().message();
    ASSERT_TRUE(same(back->gravity.x(), value)) << value;
  }
}

TEST(SceneFile, ReadsHandwrittenScenes) {
  const Scene scene = parsed(R"(
gravity = [0, 0, -1.62]
[[solid]]
name = "door"
joint = [{fixed = [1, 2, 3], axis = "z", angle_deg = 90},
         {rotation = "-y", name = "hinge", value_deg = 30, velocity_deg = 180, range_deg = [-10, 45]}]
mass = 2
tensor = [1, 2, 2.5, 0.1, 0.2, 0.3]
[[effort]]
name = "closer"
kind = "coordinate_spring"
on = "hinge"
stiffness = 3
rest_deg = -90
[[constraint]]
name = "floor"
kind = "point_on_plane"
point = "door"
plane = {point = [0, 0, 1]}
normal = "z"
)");
  const double pi = std::numbers::pi;
  EXPECT_EQ(scene.gravity, Vector3d(0, 0, -1.62));
  ASSERT_EQ(scene.solids.size(), 1u);
  const Solid& door = scene.solids[0];
  EXPECT_EQ(door.parent, "world");
  const Pose& fixed = std::get<Fixed>(door.switches[0].kind).X_AB;
  EXPECT_EQ(fixed.p, Vector3d(1, 2, 3));
  EXPECT_LT((fixed.R * Vector3d::UnitX() - Vector3d::UnitY()).norm(), 1e-15);  // a rounding of pi / 2
  const Switch& hinge = door.switches[1];
  EXPECT_EQ(std::get<Rotation>(hinge.kind).axis, Vector3d(0, -1, 0));
  EXPECT_DOUBLE_EQ(hinge.q[0], pi / 6);
  EXPECT_DOUBLE_EQ(hinge.v[0], pi);
  EXPECT_DOUBLE_EQ(hinge.ranges.at(0).lower, -pi / 18);
  EXPECT_DOUBLE_EQ(hinge.ranges.at(0).upper, pi / 4);
  EXPECT_EQ(door.inertials[0].tensor(1, 2), 0.3);
  EXPECT_EQ(door.inertials[0].tensor(2, 0), 0.2);
  const auto& spring = std::get<CoordinateSpring>(scene.efforts[0].kind);
  EXPECT_EQ(spring.on.coordinate, "hinge");
  EXPECT_DOUBLE_EQ(spring.rest, -pi / 2);
  const auto& floor = std::get<PointOnPlane>(scene.constraints[0].kind);
  EXPECT_EQ(floor.point.solid, "door");
  EXPECT_EQ(floor.plane.on.solid, "world");
  EXPECT_EQ(floor.plane.on.point, Vector3d(0, 0, 1));
}

TEST(SceneFile, BallHasThreeRanges) {
  const Scene scene = parsed(R"(
[[solid]]
name = "arm"
joint = {ball = true, value = [0.8, 0.6, 0, 0], range_deg = [[0, 90], [-10, 0], [-180, 180]]}
)");
  const std::vector<Range>& ranges = scene.solids.at(0).switches.at(0).ranges;
  ASSERT_EQ(ranges.size(), 3u);
  const double pi = std::numbers::pi;
  EXPECT_DOUBLE_EQ(ranges[0].upper, pi / 2);
  EXPECT_DOUBLE_EQ(ranges[1].lower, -pi / 18);
  EXPECT_DOUBLE_EQ(ranges[2].upper, pi);
}

TEST(SceneFile, CompileNamesTheLineOfWhatItRefuses) {
  const Scene massless =
      parsed("[[solid]]\nname='a'\nmass=1\ntensor=[1,1,1]\n\n[[solid]]\nname='b'\njoint={rotation='x'}\n");
  EXPECT_EQ(
      compile(massless).error().message().find("scene.toml:6: solid 'b', coordinate 'b': moves no mass"), 0u)
      << compile(massless).error().message();
  const Scene spring = parsed(
      "[[solid]]\nname='a'\njoint={ball=true}\nmass=1\ntensor=[1,1,1]\n[[effort]]\nname='s'\n"
      "kind='coordinate_spring'\non='a'\n");
  EXPECT_EQ(compile(spring).error().message().find("scene.toml:6: effort 's': "), 0u)
      << compile(spring).error().message();
}

// ---- refusals ----

const std::string solid_a =
    "[[solid]]\nname = 'a'\njoint = {rotation = 'z', name = 'qa'}\nmass = 1\ntensor = [1, 1, 1]\n";

struct Refused {
  const char* title;
  std::string text;
  int line;
  const char* said;
};

class SceneFileRefusal : public ::testing::TestWithParam<Refused> {};

TEST_P(SceneFileRefusal, NamesTheLine) {
  const Refused& r = GetParam();
  const auto answer = parse_scene(r.text, "scene.toml");
  ASSERT_FALSE(answer) << r.text;
  const std::string message = answer.error().message();
  EXPECT_EQ(answer.error().where, "scene.toml:" + std::to_string(r.line)) << message;
  EXPECT_NE(message.find(r.said), std::string::npos) << message;
  EXPECT_EQ(answer.error().kind, Error::Kind::use);
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

INSTANTIATE_TEST_SUITE_P(
    Bad, SceneFileRefusal,
    ::testing::Values(
        Refused{"syntax", "gravity = [0, 0\nname = 1", 2, ""},
        Refused{"unknown_key", solid_a + "masss = 3\n", 6, "unknown key 'masss'"},
        Refused{"unknown_key_at_the_top", "gravty = [0, 0, 1]\n", 1,
                "unknown key 'gravty'; known here: name"},
        Refused{"unknown_key_in_joint", "[[solid]]\nname = 'a'\njoint = [\n {rotation = 'z', nme = 'q'}]\n",
                4, "'nme'"},
        Refused{"unknown_key_in_simulation", "[simulation]\nstep = 1\nstap = 1\n", 3, "unknown key 'stap'"},
        Refused{"wrong_type", "[[solid]]\nname = 'a'\nmass = 'heavy'\n", 3, "expected a number"},
        Refused{"wrong_type_of_list", "gravity = [0, 'down', 1]\n", 1, "the text \"down\""},
        Refused{"text_for_a_joint", "[[solid]]\nname='a'\njoint='ball'\n", 3,
                "joint is the text \"ball\", expected a table or a list of tables"},
        Refused{"number_for_true", "[[solid]]\nname='a'\njoint={ball=1}\n", 3, "expected true or false"},
        Refused{"text_for_a_function", "[[solid]]\nname='a'\njoint={rotation='x', driven='sine'}\n", 3,
                "driven is the text \"sine\", expected a number, a list of polynomial coefficients"},
        Refused{"mixed_tensor", "[[solid]]\nname='a'\nmass=1\ntensor=[[1,0,0],[0,1,0],'x']\n", 4,
                "a row of tensor is the text \"x\""},
        Refused{"table_and_list_of_one_name", "[solid]\nname='a'\n[[solid]]\nname='b'\n", 3, ""},
        Refused{"dotted_key_into_a_list", "gravity=[0,0,1]\ngravity.x=1\n", 2, ""},
        Refused{"wrong_length", "gravity = [0, 1]\n", 1, "a list of 2, expected a list of 3 numbers"},
        Refused{"name_missing", "[[solid]]\nmass = 1\ntensor = [1, 1, 1]\n", 1, "name is missing"},
        Refused{"name_empty", "[[solid]]\nname = ''\n", 2, "name is empty"},
        Refused{"effort_without_name", solid_a + "[[effort]]\nkind = 'torque'\n", 6, "name is missing"},
        Refused{"world_taken", "[[solid]]\nname = 'world'\n", 1, "is reserved for the fixed frame"},
        Refused{"unknown_parent", solid_a + "parent = 'b'\n", 6, "there is no solid named 'b'"},
        Refused{"circle", "[[solid]]\nname='a'\nparent='b'\n[[solid]]\nname='b'\nparent='a'\n", 1,
                "a -> b -> a"},
        Refused{"own_parent", "[[solid]]\nname='a'\nparent='a'\n", 1, "a -> a"},
        Refused{"solid_twice", solid_a + "[[solid]]\nname = 'a'\n", 7, "the first is at scene.toml:2"},
        Refused{"coordinate_twice",
                solid_a + "[[solid]]\nname = 'b'\njoint = {rotation = 'y', name = 'qa'}\n", 8,
                "two coordinates named 'qa'"},
        Refused{
            "effort_twice",
            solid_a + "[[effort]]\nname='t'\nkind='torque'\non='a'\ntorque=[1,0,0]\n[[effort]]\nname='t'\n",
            12, "two efforts named 't'"},
        Refused{"effort_on_nothing",
                solid_a + "[[effort]]\nname='t'\nkind='torque'\non='b'\ntorque=[1,0,0]\n", 9,
                "there is no solid named 'b'"},
        Refused{"effort_without_value", solid_a + "[[effort]]\nname='t'\nkind='torque'\non='a'\n", 6,
                "torque is missing"},
        Refused{"unknown_kind", solid_a + "[[effort]]\nname='t'\nkind='wind'\n", 8, "known: force, torque"},
        Refused{"function_constraint", "[[constraint]]\nname='t'\nkind='function'\n", 3,
                "there is no kind named"},
        Refused{"unknown_coordinate",
                solid_a + "[[effort]]\nname='t'\nkind='coordinate_spring'\non='qb'\nstiffness=1\n", 9,
                "there is no coordinate named 'qb', expected one of: qa"},
        Refused{"unnamed_coordinate_twice", solid_a + "[[solid]]\nname = 'qa'\njoint = {rotation = 'y'}\n", 8,
                "two coordinates named 'qa'"},
        Refused{"zero_axis", "[[solid]]\nname='a'\njoint = {rotation = [0, 0, 0]}\n", 3, "has length 0"},
        Refused{"long_axis", "[[solid]]\nname='a'\njoint = {rotation = [1, 1, 0]}\n", 3,
                "expected a unit vector: [0.707"},
        Refused{"odd_axis", "[[solid]]\nname='a'\njoint = {rotation = 'w'}\n", 3, "expected \"x\""},
        Refused{"two_switches_in_one", "[[solid]]\nname='a'\njoint = {rotation = 'x', ball = true}\n", 3,
                "has rotation and ball"},
        Refused{"no_switch", "[[solid]]\nname='a'\njoint = {name = 'q'}\n", 3, "expected one of fixed"},
        Refused{"degrees_and_radians", "[[solid]]\nname='a'\njoint = {rotation='x', value=1, value_deg=2}\n",
                3, "expected one of them"},
        Refused{"degrees_of_a_slide", "[[solid]]\nname='a'\njoint = {translation='x', value_deg=2}\n", 3,
                "unknown key 'value_deg'"},
        Refused{"rest_degrees_of_a_slide",
                "[[solid]]\nname='a'\njoint={translation='x',name='q'}\n"
                "[[effort]]\nname='s'\nkind='coordinate_spring'\non='q'\nrest_deg=3\n",
                7, "'q' is a translation"},
        Refused{"long_quaternion", "[[solid]]\nname='a'\njoint = {ball = true, value = [1, 1, 0, 0]}\n", 3,
                "expected a unit quaternion: [0.707"},
        Refused{"nan", "[[solid]]\nname='a'\nmass = nan\ntensor=[1,1,1]\n", 3, "expected a finite number"},
        Refused{"infinite", "gravity = [0, 0, -inf]\n", 1, "expected a finite number"},
        Refused{"negative_mass", "[[solid]]\nname='a'\nmass = -1\ntensor=[1,1,1]\n", 3, "-1"},
        Refused{"not_positive", "[[solid]]\nname='a'\nmass = 1\ntensor=[1,1,-0.25]\n", 4, "-0.25"},
        Refused{"not_positive_by_products", "[[solid]]\nname='a'\nmass = 1\ntensor=[1,1,1,2,0,0]\n", 4, "-1"},
        Refused{"triangle_broken", "[[solid]]\nname='a'\nmass = 1\ntensor=[1,2,3.5]\n", 4, "3.5"},
        Refused{"mass_without_tensor", "[[solid]]\nname='a'\nmass = 1\nshape = {kind='sphere', radius=1}\n",
                3, "mass needs a tensor"},
        Refused{"tensor_without_mass", "[[solid]]\nname='a'\ntensor=[1,1,1]\n", 3, "mass is missing"},
        Refused{"shape_size", "[[solid]]\nname='a'\nshape={kind='sphere', radius=-2, mass=1}\n", 3,
                "radius is -2"},
        Refused{"shape_kind", "[[solid]]\nname='a'\nshape={kind='egg', mass=1}\n", 3,
                "there is no shape named \"egg\""},
        Refused{"shape_mass_and_density",
                "[[solid]]\nname='a'\nshape={kind='sphere', radius=1, mass=1, density=2}\n", 3,
                "density and a mass"},
        Refused{"open_mesh",
                "[[solid]]\nname='a'\nshape={kind='mesh', mass=1, vertices=[[0,0,0],[1,0,0],[0,1,0]], "
                "triangles=[[0,1,2]]}\n",
                3, "is not closed"},
        Refused{"mesh_index",
                "[[solid]]\nname='a'\nshape={kind='mesh', vertices=[[0,0,0]], triangles=[[0,1,2]]}\n", 3,
                "refers to vertex 1"},
        Refused{"velocity_of_locked", "[[solid]]\nname='a'\njoint={rotation='x', locked=true, velocity=1}\n",
                3, "only a free coordinate"},
        Refused{"value_of_driven", "[[solid]]\nname='a'\njoint={rotation='x', driven=[0,1], value=1}\n", 3,
                "takes the value of its function"},
        Refused{"range_upside_down", "[[solid]]\nname='a'\njoint={rotation='x', range=[1,0]}\n", 3,
                "runs from 1 to 0"},
        Refused{"range_of_three_numbers", "[[solid]]\nname='a'\njoint={rotation='x', range=[0,1,2]}\n", 3,
                "range is a list of 3, expected a list of 2 numbers"},
        Refused{"ranges_of_a_hinge", "[[solid]]\nname='a'\njoint={rotation='x', range=[[0,1]]}\n", 3,
                "expected a list of 2 numbers"},
        Refused{"range_without_end", "[[solid]]\nname='a'\njoint={rotation='x', range=[0,inf]}\n", 3,
                "expected a finite number"},
        Refused{"range_of_driven", "[[solid]]\nname='a'\njoint={rotation='x', driven=[0], range=[0,1]}\n", 3,
                "a range has no effect"},
        Refused{"one_range_of_a_ball", "[[solid]]\nname='a'\njoint={ball=true, range=[0,1]}\n", 3,
                "expected three ranges"},
        Refused{"numbers_for_a_balls_ranges", "[[solid]]\nname='a'\njoint={ball=true, range=[0,1,2]}\n", 3,
                "one of its ranges is the number 0"},
        Refused{"ball_range_upside_down",
                "[[solid]]\nname='a'\njoint=[{fixed=[0,0,0]},\n{ball=true, range=[[0,1],[1,0],[0,1]]}]\n", 4,
                "range about its y axis runs from 1 to 0"},
        Refused{
            "ball_outside_its_range",
            "[[solid]]\nname='a'\njoint={ball=true, value=[0.8,0,0,0.6], range_deg=[[0,1],[0,1],[0,60]]}\n",
            3, "about its z axis, outside its range of 0 to 1.047"},
        Refused{"value_outside_range", "[[solid]]\nname='a'\njoint={rotation='x', value=2, range=[0,1]}\n", 3,
                "starts at 2, outside its range of 0 to 1 (rad)"},
        Refused{"no_value_outside_range", "[[solid]]\nname='a'\njoint={translation='x', range=[1,2]}\n", 3,
                "starts at 0, outside its range of 1 to 2 (m)"},
        Refused{"unknown_method", "[simulation]\nmethod='magic'\n", 2,
                "expected one of euler, rk2, rk4, rk4_adaptive"},
        Refused{"method_beside_accuracy", "[simulation]\naccuracy=1e-3\nmethod='rk4'\n", 3,
                "method has no effect with accuracy"},
        Refused{"tolerance_beside_accuracy", "[simulation]\ntolerance=1e-3\naccuracy=1e-3\n", 2,
                "tolerance has no effect with accuracy"},
        Refused{"negative_damping",
                "[[solid]]\nname='a'\njoint={rotation='x'}\n[[effort]]\nname='s'\nkind='coordinate_spring'\n"
                "on='a'\ndamping=-1\n",
                8, "damping is -1, expected 0 or more"},
        Refused{"bad_treatment", "[simulation]\nconstraints='magic'\n", 2, "projection"},
        Refused{"bad_equations", "[simulation]\nequations='newton'\n", 2,
                "equations is \"newton\", expected \"recursive\" or \"lagrange\""},
        Refused{"step_of_nothing", "[simulation]\nstep=0\n", 2, "expected a positive number"},
        Refused{"sine_field", "[[solid]]\nname='a'\njoint={rotation='x', driven={kind='sine', amplitud=1}}\n",
                3, "unknown key 'amplitud'"},
        Refused{"not_a_rotation",
                "[[solid]]\nname='a'\njoint={fixed=[0,0,0], matrix=[[1,0,0],[0,1,0],[0,0,-1]]}\n", 3,
                "not a rotation"}),
    [](const auto& param) { return std::string(param.param.title); });

TEST(SceneFile, RefusesMissingAndOtherFiles) {
  EXPECT_EQ(read_scene("/no/such/scene.toml").error().message(), "/no/such/scene.toml: no such file");
  EXPECT_NE(read_scene(test::source_folder()).error().message().find("is a folder"), std::string::npos);
}

TEST(SceneFile, FunctionConstraintsAreNotWritten) {
  Scene scene;
  scene.constraints = {{"mine", FunctionConstraint{}}};
  const auto answer = write_scene(scene);
  ASSERT_FALSE(answer);
  EXPECT_NE(answer.error().message().find("'mine'"), std::string::npos);
}

// ---- damage ----

void expect_sane(const std::string& text) {
  const auto answer = parse_scene(text, "scene.toml");
  if (answer) return;
  EXPECT_TRUE(answer.error().where.starts_with("scene.toml")) << answer.error().message();
  EXPECT_FALSE(answer.error().what.empty());
}

TEST(SceneFile, TruncationsNeverCrash) {
  for (const fs::path& path : samples()) {
    const std::string text = text_of(path);
    for (std::size_t length = 0; length<text.size(); length += text.size()> 4000 ? 7 : 1)
      expect_sane(text.substr(0, length));
  }
}

TEST(SceneFile, RandomDamageNeverCrashes) {
  std::mt19937 random(7);
  for (const fs::path& path : samples()) {
    const std::string text = text_of(path);
    std::uniform_int_distribution<std::size_t> where(0, text.size() - 1);
    for (int i = 0; i < 1000; ++i) {
      std::string bad = text;
      const int count = 1 + i % 4;
      for (int k = 0; k < count; ++k) {
        switch (random() % 3) {
          case 0:
            bad[where(random) % bad.size()] = static_cast<char>(random());
            break;
          case 1:
            bad.erase(where(random) % bad.size(), 1 + random() % 9);
            break;
          default:  // repeats a piece of the file elsewhere: duplicate names, nested tables
            bad.insert(where(random) % bad.size(), text.substr(where(random), random() % 60));
        }
        if (bad.empty()) bad = "x";
      }
      expect_sane(bad);
    }
  }
}

TEST(SceneFile, DeepNestingIsRefused) {
  expect_sane("a = " + std::string(100000, '['));
  expect_sane("gravity = " + std::string(200, '[') + std::string(200, ']'));
  std::string dotted = "a";
  for (int i = 0; i < 20000; ++i) dotted += ".a";
  expect_sane(dotted + " = 1\n");
}

}  // namespace
}  // namespace borelli
