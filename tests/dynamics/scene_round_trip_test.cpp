// Written scenes read back exactly: every kind of element, and numbers bit for bit.
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <random>

#include "dynamics/formats/scene_file.hpp"
#include "sample_scenes.hpp"

namespace borelli::test::scene_round_trip_test {
namespace {

namespace fs = std::filesystem;
using Eigen::Matrix3d;
using Eigen::Vector3d;

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
class VariedScene {
 public:
  explicit VariedScene(unsigned seed) : random(seed) {
    scene.name = "varied \"scene\" \\ of many kinds";
    scene.description = "first line\nsecond, with a tab\t, a \"quote\" and a \\\n\nend";
    add_settings();
    add_first_solid();
    add_second_solid();
    a = {"first", vector()}, b = {"second", vector()}, w = {"world", vector()};
    add_efforts();
    scene.markers = {{"heel", {"first", vector()}}, {"origin", {"world", vector()}}};
    add_constraints();
    add_contacts();
  }

  Scene scene;

 private:
  double number() { return half(random) * std::pow(10, exponent(random)); }
  double positive() { return std::abs(number()) + 1e-30; }
  Vector3d vector() { return Vector3d(number(), number(), number()); }
  Matrix3d turn() {
    const Vector3d axis = Vector3d(half(random), half(random), half(random)).normalized();
    return rotation_about(axis, 3 * half(random));
  }
  Inertial inertial() {
    const double m = positive(), s = positive();
    const Matrix3d R = turn();
    Matrix3d tensor = R * (s * Vector3d(2, 3, 4)).asDiagonal() * R.transpose();
    tensor = (0.5 * (tensor + tensor.transpose())).eval();
    return Inertial{m, vector(), tensor};
  }

  void add_settings() {
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
  }

  void add_first_solid() {
    Solid first{"first", "second", {}, {inertial()}, {}};
    first.switches = {
        {Fixed{{turn(), vector()}}, "", Free{}, {}, {}, {}},
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
    scene.solids.push_back(first);
  }

  void add_second_solid() {
    Solid second{"second", "world", {}, {inertial(), inertial()}, {}};
    second.switches = {
        {Ball{}, "d", Free{}, {}, {number(), number(), number()}, {{0, 1. / 3}, {-1, 0}, {-2, 2}}},
        {Rotation{}, "e", Locked{}, {number()}, {}, {}}};
    second.shapes = {{{Box{Vector3d(0.1, 0.2, 1. / 3)}, vector(), q}, positive(), {}},
                     {{Sphere{positive()}}, {}, positive()},
                     {{Ellipsoid{Vector3d(0.1, 0.2, 0.7)}}, {}, {}},
                     {{Cylinder{0.1, 0.3}}, {}, 2},
                     {{Cone{0.1, 0.3}}, 3, {}},
                     {{Capsule{0.1, 0.3}}, {}, {}},
                     {{mesh}, 1000, {}}};
    scene.solids.push_back(second);
  }

  void add_efforts() {
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
  }

  void add_constraints() {
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
        {"crate", BoxOverPlane{b, vector(), {a, Vector3d(3, 2, 1)}, {positive(), positive()}}}};
  }

  void add_contacts() {
    const std::vector<Constraint> contacts = {
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
        {"drum", ConvexOverPlane{{"first"},
                                 {Cylinder{positive(), positive()}, vector(), q},
                                 {w, -Vector3d::UnitX()},
                                 {0, 1},
                                 {}}},
        {"bricks",
         ConvexOverConvex{
             {"first"}, {"second"}, {Box{vector()}, vector(), q}, {mesh}, {positive(), 1}, {}, {}}}};
    scene.constraints.insert(scene.constraints.end(), contacts.begin(), contacts.end());
  }

  std::mt19937_64 random;
  std::uniform_real_distribution<double> exponent{-20, 20}, half{-1, 1};
  const TimeFunction wave = Sine{number(), number(), number(), number()};
  const TimeFunction ramp = Polynomial{{number(), number(), number()}};
  const Eigen::Quaterniond q = Eigen::Quaterniond(turn()).normalized();
  const ClosedMesh mesh{{{0, 0, 0}, {0.1, 0, 0}, {0, 0.2, 0}, {0, 0, 0.3}},
                        {{{0, 2, 1}}, {{0, 1, 3}}, {{0, 3, 2}}, {{1, 2, 3}}}};
  SolidPoint a, b, w;
};

Scene varied(unsigned seed) { return VariedScene(seed).scene; }

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

}  // namespace
}  // namespace borelli::test::scene_round_trip_test
