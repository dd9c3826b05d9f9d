// OpenSim models that we write: read back they move as before, and losses are named.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <set>

#include "dynamics/equations/evaluate.hpp"
#include "dynamics/equations/jacobian.hpp"
#include "dynamics/formats/model_file.hpp"
#include "dynamics/formats/model_write.hpp"
#include "dynamics/formats/scene_file.hpp"
#include "tests/dynamics/random_scene.hpp"
#include "tests/dynamics/scenes.hpp"
#include "tests/dynamics/test_folder.hpp"

namespace borelli::test::osim_write_test {
namespace {

ModelFile read_back(const WrittenModel& written) {
  const Folder folder;
  return need(read_model(folder.write("model.osim", written.text)));
}

bool any_holds(const std::vector<std::string>& lines, const std::string& part) {
  return std::any_of(lines.begin(), lines.end(),
                     [&](const std::string& line) { return line.find(part) != std::string::npos; });
}

/// A name as the writer writes it.
std::string plain(std::string name) {
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
}

const CoordinateInfo* info_of(const System& system, const std::string& name) {
  for (const CoordinateInfo& info : system.coordinates)
    if (info.name == name) return &info;
  return nullptr;
}

// ---- accelerations ----

/// Rotation and angular acceleration of a ball that three angles replace: the angles turn, one after the
/// other, about axes of the turned frame (e.g. Featherstone, Rigid Body Dynamics Algorithms, section 4.4).
struct Turned {
  Matrix3d R = Matrix3d::Identity();
  Vector3d w = Vector3d::Zero(), alpha = Vector3d::Zero();  // in the axes before the turns

  void turn(const Vector3d& axis, double q, double v, double a) {
    const Vector3d e = R * axis;
    alpha += a * e + v * w.cross(e);
    w += v * e;
    R = R * rotation_about(axis, q);
  }
};

/// Compares the accelerations at the start, coordinate by coordinate. Balls are compared by orientation,
/// velocity and angular acceleration.
void expect_alike(const Scene& scene, const Scene& again, const std::string& what) {
  const System one = compiled(scene), two = compiled(again);
  const Evaluation a = need(evaluate(one, one.initial)), b = need(evaluate(two, two.initial));
  const double scale = std::max(1., a.acceleration.cwiseAbs().maxCoeff());
  for (const CoordinateInfo& info : one.coordinates) {
    if (info.q_size == 1) {
      const CoordinateInfo* same = info_of(two, plain(info.name));
      ASSERT_TRUE(same) << info.name << ", " << what;
      EXPECT_NEAR(one.initial.q[info.q_index], two.initial.q[same->q_index], 1e-13) << info.name << what;
      EXPECT_NEAR(one.initial.v[info.v_index], two.initial.v[same->v_index], 1e-13) << info.name << what;
      EXPECT_NEAR(a.acceleration[info.v_index], b.acceleration[same->v_index], 1e-12 * scale)
          << info.name << ", " << what;
      continue;
    }
    Turned turned;
    int found = 0;
    for (const CoordinateInfo& angle : two.coordinates)  // in the order of the turns
      for (int i = 0; i < 3; ++i)
        if (angle.name == plain(info.name) + "_" + "xyz"[i]) {
          ++found;
          turned.turn(Vector3d::Unit(i), two.initial.q[angle.q_index], two.initial.v[angle.v_index],
                      b.acceleration[angle.v_index]);
        }
    ASSERT_EQ(found, 3) << info.name << ", " << what;
    const Quaternion q = one.initial.q.segment<4>(info.q_index);
    EXPECT_LT((turned.R - rotation_matrix(q)).norm(), 1e-14) << info.name << ", " << what;
    EXPECT_LT((turned.R.transpose() * turned.w - one.initial.v.segment<3>(info.v_index)).norm(), 1e-13)
        << info.name << ", " << what;
    EXPECT_LT((turned.R.transpose() * turned.alpha - a.acceleration.segment<3>(info.v_index)).norm(),
              1e-12 * scale)
        << info.name << ", " << what;
  }
}

/// Gives every free coordinate a random start, away from gimbal lock.
void set_start(Scene& scene, Random& random) {
  for (Solid& solid : scene.solids)
    for (Switch& one : solid.switches) {
      if (!std::holds_alternative<Free>(one.motion) && !std::holds_alternative<Locked>(one.motion)) continue;
      if (std::holds_alternative<Ball>(one.kind)) {
        const Quaternion q = exponential(random.vector(0.6));
        one.q = {q[0], q[1], q[2], q[3]};
        one.v = {random.number(-1, 1), random.number(-1, 1), random.number(-1, 1)};
      } else if (!std::holds_alternative<Fixed>(one.kind)) {
        one.q = {random.number(-0.8, 0.8)};
        one.v = {random.number(-1, 1)};
      }
      if (std::holds_alternative<Locked>(one.motion)) one.v.clear();
    }
}

/// Removes what OpenSim lacks: driven balls become locked; torsion springs, springs within a solid and
/// reactions in turned axes go.
void leave_out_what_is_lost(Scene& scene) {
  for (Solid& solid : scene.solids)
    for (Switch& one : solid.switches)
      if (std::holds_alternative<Ball>(one.kind) && std::holds_alternative<Driven>(one.motion))
        one.motion = Locked{};
  std::erase_if(scene.efforts, [](const Effort& e) {
    const auto* spring = std::get_if<PointSpring>(&e.kind);
    return std::holds_alternative<TorsionSpring>(e.kind) || (spring && spring->a.solid == spring->b.solid);
  });
  for (Effort& e : scene.efforts)
    if (auto* force = std::get_if<Force>(&e.kind)) force->reaction.reset();
}

TEST(OsimWrite, RandomScenesAccelerateAlikeWhenReadBack) {
  int alike = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    Scene scene = RandomScene(seed, 3 + int(seed % 10), false).scene;
    leave_out_what_is_lost(scene);
    Random random(seed + 100);
    set_start(scene, random);
    const System system = compiled(scene);
    if (!evaluate(system, system.initial)) continue;  // a coordinate moves no mass
    ++alike;
    const WrittenModel written = need(write_osim(scene));
    EXPECT_TRUE(written.omissions.empty()) << seed << ": " << written.omissions.front();
    expect_alike(scene, read_back(written).scene, fmt::format("seed {}", seed));
  }
  EXPECT_GE(alike, 30);
}

// ---- each kind of switch ----

/// A solid with these switches on a moving parent.
Scene carried(std::vector<Switch> switches) {
  Random random(7);
  Scene scene;
  scene.solids = {
      solid("base", "world", {hinge("base", Vector3d(1, 2, 2) / 3, 0.3, 0.7)}, {random.inertia().inertial()}),
      solid("s", "base", std::move(switches), {random.inertia().inertial()})};
  return scene;
}

void expect_kept(const Scene& scene, const std::string& what) {
  const WrittenModel written = need(write_osim(scene));
  EXPECT_TRUE(written.omissions.empty()) << what << ": " << written.omissions.front();
  expect_alike(scene, read_back(written).scene, what);
}

Switch guided(const std::string& name, std::vector<GuidedPart> parts) {
  Switch one;
  one.kind = Guided{std::move(parts)};
  one.coordinate = name;
  one.q = {0.4};
  one.v = {-0.6};
  return one;
}

const TimeFunction some_spline =
    Table{{-1, -0.2, 0.5, 1.1, 2}, {0.1, -0.1, 0.3, 0.2, 0.5}, SplineEnds::forsythe};
const TimeFunction other_spline = Table{{-1, -0.2, 0.5, 1.1, 2}, {0.1, -0.1, 0.3, 0.2, 0.5}};
constexpr auto turns = GuidedPart::Kind::rotation, slides = GuidedPart::Kind::translation;

TEST(OsimWrite, SwitchesOfEachKindAccelerateAlike) {
  Switch screw = hinge("screw", Vector3d::UnitZ(), 0.5, 1);
  screw.kind = Screw{Vector3d(0, 0.6, 0.8), 0.03};
  expect_kept(carried({screw}), "screw");
  expect_kept(carried({guided("knee", {{slides, Vector3d::UnitX(), some_spline},
                                       {slides, Vector3d::UnitY(), other_spline},
                                       {turns, Vector3d::UnitZ(), linear(0.1, -1.5)},
                                       {turns, Vector3d::UnitX(), Polynomial{{0.1, 0.2, -0.3, 0.4}}},
                                       {turns, Vector3d::UnitY(), Sine{0.3, 2, 0.4, 0.1}}})}),
              "knee");
  // a rotation before a translation, and a fourth rotation, need further joints
  expect_kept(carried({guided("cam", {{turns, Vector3d::UnitZ(), linear(0, 1)},
                                      {slides, Vector3d(0.6, 0.8, 0), Sine{0.2, 1, 0, 0}},
                                      {turns, Vector3d::UnitX(), linear(0, 0.5)}})}),
              "cam");
  Random random(9);
  const auto placed = [&] { return fixed(random.vector(0.4), rotation_matrix(random.turn())); };
  Scene scene = carried(
      {placed(), slide("a", random.direction(), 0.1, 1), hinge("b", random.direction(), 0.4, -1),
       fixed({0, 0, 0}, rotation_matrix(random.turn())), hinge("c", random.direction(), 1, 1), placed()});
  scene.solids.push_back(
      solid("t", "s",
            {placed(), hinge("d", random.direction(), -0.5, 0.3), slide("e", random.direction(), 0.2, 0.1),
             placed(), ball("f", random.turn(), {1, 0.5, -1}), placed()},
            {random.inertia().inertial()}));
  expect_kept(scene, "chains");
}

TEST(OsimWrite, LocksDrivesAndTiesAreKept) {
  Switch locked = hinge("locked", Vector3d::UnitX(), 0.7);
  locked.motion = Locked{};
  locked.v.clear();
  const Switch moved = driven(hinge("moved", Vector3d::UnitY()), other_spline),
               shaken = driven(slide("shaken", Vector3d::UnitZ()), Sine{0.1, 3, 0.2, 0});
  Switch tied = hinge("tied", Vector3d::UnitX());
  tied.motion = Coupled{"base", Polynomial{{0.1, 0.5, 0.2}}};
  tied.q.clear();
  tied.v.clear();
  Scene scene = carried({locked, moved, shaken, tied});
  Switch bound = hinge("bound", Vector3d::UnitZ(), 0.2, 0.1);
  bound.ranges = {{-0.1, 0.3}};
  scene.solids.push_back(solid("t", "s", {bound}, {link()}));
  const WrittenModel written = need(write_osim(scene));
  EXPECT_TRUE(written.omissions.empty());
  const Scene again = read_back(written).scene;
  const auto& switches = again.solids[1].switches;
  std::map<std::string, const Switch*> found;
  for (const Solid& one : again.solids)
    for (const Switch& its : one.switches) found[its.coordinate] = &its;
  ASSERT_FALSE(switches.empty());
  EXPECT_TRUE(std::holds_alternative<Locked>(found.at("locked")->motion));
  EXPECT_EQ(found.at("locked")->q, std::vector{0.7});
  EXPECT_NEAR(at(std::get<Driven>(found.at("moved")->motion).functions[0], 0.3).acceleration,
              at(other_spline, 0.3).acceleration, 1e-14);
  EXPECT_EQ(at(std::get<Driven>(found.at("shaken")->motion).functions[0], 0.3).value,
            at(Sine{0.1, 3, 0.2, 0}, 0.3).value);
  EXPECT_EQ(std::get<Coupled>(found.at("tied")->motion).to, "base");
  EXPECT_EQ(found.at("bound")->ranges[0].upper, 0.3);
  expect_alike(scene, again, "locks, drives and ties");
}

/// A ball that starts with its y angle at a right angle, where the axes of the x and z angles coincide.
TEST(OsimWrite, BallsNearGimbalLockGetAnotherOrderOfAngles) {
  Matrix3d all_but_lost;  // near gimbal lock in the orders xyz, yzx and zxy
  all_but_lost << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  for (const Matrix3d& R :
       {rotation_about(Vector3d::UnitY(), M_PI / 2), all_but_lost,
        Matrix3d(rotation_about(Vector3d::UnitY(), -1.5) * rotation_about(Vector3d::UnitX(), 0.4))})
    expect_kept(carried({ball("b", quaternion(R), {0.3, -0.5, 0.8})}), "gimbal lock");
}

// ---- efforts and constraints ----

TEST(OsimWrite, EffortsActAlikeWhenReadBack) {
  Random random(11);
  Scene scene = random_tree(4, {});
  set_start(scene, random);
  scene.solids[5].switches.back().ranges = {{-0.7, 0.5}};
  std::vector<std::string> names;
  for (const Solid& one : scene.solids)
    for (std::size_t i = 1; i < 3; ++i) names.push_back(coordinate_name(one, i));
  for (Solid& one : scene.solids) one.switches[1].q = {0.6}, one.switches[2].q = {-0.4};
  scene.efforts = {
      {"free spring", PointSpring{{"s0", random.vector(1)}, {"s4", random.vector(1)}, 30, 0, 0.4}},
      {"damped", PointSpring{{"s1", random.vector(1)}, {"world", random.vector(1)}, 25, 1.5, -0.2}},
      {"joint", CoordinateSpring{{names[0]}, 5, 0.3, 0.2}},
      {"holder", PdController{{names[1]}, 4, 0.2, {constant(0.3)}}},
      {"upper stop", LimitSpring{{names[2]}, 70, 0.4, {{-0.1, 0.5}}}},
      {"lower stop", LimitSpring{{names[3]}, 80, 0.3, {{-0.3, 0}}}},
      {"inner stop", LimitSpring{{names[11]}, 80, 0.3, {}}},
      {"push", Force{{"s2", random.vector(1)}, random.vector(3), Axes::solid, Sine{2, 1, 0.3, 0.1}, {}}},
      {"pair", Force{{"s3", random.vector(1)},
                     random.vector(3),
                     Axes::world,
                     Polynomial{{1, 2}},
                     SolidPoint{"s5", random.vector(1)}}},
      {"twist", Torque{{"s4"}, random.vector(3), Axes::solid, constant(0.5), {}}},
      {"turn", Torque{{"s1"}, random.vector(3), Axes::world, other_spline, SolidName{"s0"}}}};
  expect_kept(scene, "efforts");
  // each effort acts: without it the accelerations differ
  const Evaluation with = need(evaluate(compiled(scene), compiled(scene).initial));
  for (std::size_t i = 0; i < scene.efforts.size(); ++i) {
    Scene less = scene;
    less.efforts.erase(less.efforts.begin() + std::ptrdiff_t(i));
    const Evaluation without = need(evaluate(compiled(less), compiled(less).initial));
    const bool inner = scene.efforts[i].name == "inner stop";  // within its range
    EXPECT_EQ((with.acceleration - without.acceleration).norm() > 1e-6, !inner) << scene.efforts[i].name;
  }
}

TEST(OsimWrite, ConstraintsActAlikeWhenReadBack) {
  const std::vector<ConstraintKind> kinds{
      PointOnPoint{{"s2", {0.1, 0.2, 0.3}}, {"world", {0.3, -0.2, 0.1}}},
      PointOnLine{{"s3", {0.1, 0, 0.2}}, {"world", {0, 0.2, 0.1}}, Vector3d(1, 2, 2) / 3},
      PointOnLine{{"s3", {0.1, 0, 0.2}}, {"s1", {0, 0.2, 0.1}}, Vector3d(2, -1, 2) / 3},
      Distance{{"s4", {0.1, 0.1, 0.2}}, {"world", {1, 1, 1}}, constant(0.7)},
      WeldConstraint{{"s5"}, {"s0"}, {rotation_about(Vector3d(1, 2, 2) / 3, 0.3), {0.1, 0.2, 0.3}}},
      WeldConstraint{{"s5"}, {"world"}, {rotation_about(Vector3d(1, 2, 2) / 3, 0.3), {0.1, 0.2, 0.3}}},
      WeldConstraint{{"world"}, {"s5"}, {rotation_about(Vector3d(1, 2, 2) / 3, 0.3), {0.1, 0.2, 0.3}}},
      CoordinateFunction{{"c01"}, {"c30"}, some_spline},
      CoordinateCoupling{{{"c01"}, {"c30"}, {"c51"}}, {2, -1, 0.5}, constant(0.3)}};
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    Random random(unsigned(i) + 20);
    Scene scene = random_tree(4, {});
    set_start(scene, random);
    scene.constraints = {{"c", kinds[i]}};
    if (const auto* gear =
            std::get_if<CoordinateFunction>(&kinds[i])) {  // read back, it starts on its function
      const TimeValue f = at(gear->function, scene.solids[3].switches[1].q[0]);
      scene.solids[0].switches[2].q = {f.value};
      scene.solids[0].switches[2].v = {f.rate * scene.solids[3].switches[1].v[0]};
    }
    const WrittenModel written = need(write_osim(scene));
    EXPECT_TRUE(written.omissions.empty()) << i;
    expect_alike(scene, read_back(written).scene, fmt::format("constraint {}", i));
  }
}

// ---- the world, markers, shapes, names ----

TEST(OsimWrite, TheWorldIsTurnedSoThatYIsUp) {
  Scene scene;
  scene.solids = {solid("s", "world", free_switches("s"), {link()})};
  scene.solids[0].switches[2].q = {3};  // up
  scene.markers = {{"on the ground", {"world", {1, 2, 3}}}, {"tip", {"s", {0.1, 0.2, 0.3}}}};
  const Scene turned = read_back(need(write_osim(scene))).scene;
  EXPECT_EQ(turned.gravity, Vector3d(0, -9.81, 0));
  ASSERT_EQ(turned.markers.size(), 2u);
  EXPECT_EQ(turned.markers[0].name, "on_the_ground");
  EXPECT_EQ(turned.markers[0].at.point, Vector3d(1, 3, -2));
  EXPECT_EQ(turned.markers[1].at.solid, "s");
  EXPECT_EQ(turned.markers[1].at.point, Vector3d(0.1, 0.2, 0.3));
  const System system = compiled(turned);
  const Evaluation falls = need(evaluate(system, system.initial));
  EXPECT_NEAR(falls.acceleration[info_of(system, "s.z")->v_index], -9.81, 1e-14);
  const SolidPoint centre{"s", {0, 0, -0.5}};  // it hangs below
  scene.gravity = {0, -9.81, 0};               // a world with y up is not turned
  EXPECT_EQ(read_back(need(write_osim(scene))).scene.markers[0].at.point, Vector3d(1, 2, 3));
}

TEST(OsimWrite, ReplacesForbiddenNamesAndSaysSo) {
  Scene scene;
  scene.solids = {solid("ground", "world", {hinge("a b", Vector3d::UnitZ())}, {link()}),
                  solid("x/y", "ground", {hinge("a_b", Vector3d::UnitX())}, {link()})};
  const WrittenModel written = need(write_osim(scene));
  EXPECT_TRUE(
      any_holds(written.omissions, "blanks and other characters that OpenSim does not allow: a b, x/y"));
  EXPECT_TRUE(any_holds(written.omissions, "get a number: 'a_b' as 'a_b_2', 'ground' as 'ground_2'"));
  EXPECT_EQ(written.omissions.size(), 2u);
  const Scene again = read_back(written).scene;
  EXPECT_EQ(again.solids[1].name, "x_y");
  EXPECT_EQ(again.solids[1].parent, "ground_2");
}

struct Nothing {
  template <class T>
  void apply(EffortPass<T>&) const {}
};

TEST(OsimWrite, NamesWhatIsLost) {
  Scene scene = carried({ball("turn", identity_quaternion(), {0, 0, 0})});
  scene.solids[1].switches[0].ranges = {{-1, 1}, {-1, 1}, {-1, 1}};
  scene.solids[1].switches[0].armature = 0.1;
  scene.solids.push_back(solid("d", "world", {ball("spun")}, {link()}));
  scene.solids[2].switches[0].q.clear();
  scene.solids[2].switches[0].v.clear();
  scene.solids[2].switches[0].motion = Driven{{constant(0.2), linear(0, 1), constant(0)}};
  scene.solids.push_back(solid(
      "p", "world",
      {driven(hinge("wave", Vector3d::UnitX()), Table{{0, 1, 2, 3}, {0, 1, -1, 0}, SplineEnds::periodic})},
      {link()}));
  scene.solids.push_back(solid("blade", "world", {ball("glide")}, {link()}));
  scene.solids.back().switches[0].kind = OnEllipsoid{{0.3, 0.2, 0.4}};
  scene.solids[0].shapes = {{{ClosedMesh{}}, {}, {}}};
  scene.efforts = {{"torsion", TorsionSpring{{"s"}, {"base"}, 1, 0}},
                   {"air", Drag{{"s"}, 1, 0}},
                   {"stop of the ball", LimitSpring{{"turn"}, 1, 0, {{-1, 1}, {-1, 1}, {-1, 1}}}},
                   {"follower", PdController{{"base"}, 1, 0, {linear(0, 1)}}},
                   {"own", OwnEffort({{"s"}}, {}, Nothing{})}};
  scene.constraints = {
      {"rope", Rope{{"s"}, {"world", {0, 0, 5}}, 9}},
      {"floor", SphereOverPlane{{"s", {0, 0, 1}}, 0.3, {{"world", {0, 0, -9}}, Vector3d::UnitZ()}, {}}},
      {"stop", Limit{{"base"}, -2, 2, 0.5}},
      {"growing", Distance{{"s", {0, 0, 1}}, {"world", {1, 1, 1}}, linear(1, 0.1)}},
      {"wall", PointOnPlane{{"s"}, {{"world"}, Vector3d::UnitX()}, constant(0)}}};
  scene.simulation.end_time = 12;
  const WrittenModel written = need(write_osim(scene));
  for (const char* name : {"turn", "spun", "wave", "torsion", "air", "stop of the ball", "follower", "own",
                           "rope", "floor", "stop", "growing", "wall", "base", "glide"})
    EXPECT_TRUE(std::any_of(written.omissions.begin(), written.omissions.end(), [&](const std::string& line) {
      const auto list = line.find(": ");
      return list != line.npos && (line.substr(list) + ",").find(std::string(" ") + name + ",") != line.npos;
    })) << name;
  for (const char* reason : {"ellipsoid switches", "ranges of balls", "armatures", "driven balls",
                             "periodic spline", "torsion_spring", "drag", "compliant",
                             "length changes with time", "point_on_plane", "triangles", "the run's method"})
    EXPECT_TRUE(any_holds(written.omissions, reason)) << reason;
  // a guided motion by such a spline cannot be locked at its start
  const auto refused = write_osim(carried({guided(
      "cam", {{turns, Vector3d::UnitZ(), Table{{0, 1, 2, 3}, {0, 1, -1, 0}, SplineEnds::clamped}}})}));
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message().find("solid 's': its coordinate 'cam' would follow a clamped spline"),
            std::string::npos)
      << refused.error().message();
}

// ---- samples ----

TEST(OsimWrite, SampleScenesMoveAlikeOrNameWhatIsLost) {
  int alike = 0, lossy = 0;
  for (const auto& entry : std::filesystem::directory_iterator(source_folder() + "/samples")) {
    if (entry.path().extension() != ".toml") continue;
    const Scene scene = need(read_scene(entry.path()));
    const WrittenModel written = need(write_osim(scene));
    const Scene again = read_back(written).scene;
    std::size_t harmless = 0;  // settings of the run, ranges
    for (const std::string& line : written.omissions)
      harmless += line.starts_with("the run's method") || line.starts_with("ranges of balls") ||
                  line.starts_with("names have _");
    if (harmless < written.omissions.size()) {
      ++lossy;
      continue;
    }
    ++alike;
    expect_alike(scene, again, entry.path().filename());
  }
  EXPECT_GE(alike, 14);
  EXPECT_GE(lossy, 4);
}

}  // namespace
}  // namespace borelli::test::osim_write_test
