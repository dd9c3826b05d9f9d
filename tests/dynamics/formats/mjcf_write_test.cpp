// Scenes written as MJCF: MuJoCo and our reader give the same mechanics, and each loss is named.
#include <gtest/gtest.h>

#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "dynamics/formats/model_file.hpp"
#include "dynamics/formats/model_write.hpp"
#include "tests/dynamics/test_folder.hpp"
#include "tests/dynamics/writable_scene.hpp"
#ifdef BORELLI_MUJOCO
#include "tests/dynamics/mujoco_model.hpp"
#endif

namespace borelli::test::mjcf_write_test {
namespace {

constexpr int seeds = 200;

WritableScene random_scene(unsigned seed) {
  return {seed, 7, {.springs = true, .balls = true, .free_root = seed % 3 != 0}};
}

ModelFile read_back(const Scene& scene) {
  const Folder folder;
  return need(read_model(folder.write("written.xml", need(write_mjcf(scene)).text)));
}

TEST(MjcfWrite, ReadsBackWithTheSameMechanics) {
  for (unsigned seed = 0; seed < seeds; ++seed) {
    const WritableScene made = random_scene(seed);
    const ModelFile back = read_back(made.scene);
    const System before = compiled(made.scene), after = compiled(back.scene);
    ASSERT_EQ(before.nv, after.nv) << seed;
    const SameNames at(before, after);
    Random random(seed);
    for (int trial = 0; trial < 3; ++trial) {
      // the first trial compares the starts
      const State state = trial == 0 ? before.initial : random.state(before);
      State other{.t = 0, .q = Eigen::VectorXd(after.nq), .v = Eigen::VectorXd(after.nv)};
      const InSolidAxes same(before, state, made.balls);
      other.q(at.q) = same.q;
      other.v(at.v) = same.v;
      if (trial == 0) {
        EXPECT_LT((other.q - after.initial.q).norm(), 1e-14) << seed;
        EXPECT_LT((other.v - after.initial.v).norm(), 1e-14) << seed;
      }
      const Evaluation a = need(evaluate(before, state)), b = need(evaluate(after, other));
      const Eigen::MatrixXd A = same.axes * a.mass_matrix * same.axes.transpose();
      // products of about ten poses round to about 1e-15 of the largest entry
      EXPECT_LT((b.mass_matrix(at.v, at.v) - A).norm(), 1e-12 * A.norm()) << seed;
      const Eigen::VectorXd drive = same.axes * (a.generalized_efforts - a.bias),
                            other_drive = (b.generalized_efforts - b.bias)(at.v);
      EXPECT_LT((other_drive - drive).norm(), 1e-12 * drive.norm()) << seed;
    }
  }
}

#ifdef BORELLI_MUJOCO
TEST(MjcfWrite, MovesInMujocoAsHere) {
  double worst = 0;
  for (unsigned seed = 0; seed < seeds; ++seed) {
    const WritableScene made = random_scene(seed);
    const System system = compiled(made.scene);
    Mujoco mujoco = Mujoco::of(need(write_mjcf(made.scene)).text);
    ASSERT_EQ(mujoco.model->nv, system.nv) << seed;
    const Order order = order_in(system, *mujoco.model);
    Random random(seed);
    for (int trial = 0; trial < 2; ++trial) {
      const State state = trial == 0 ? system.initial : random.state(system);
      Eigen::VectorXd efforts(system.nv);
      for (double& e : efforts) e = random.number(-10, 10);
      const Evaluation own = need(evaluate(system, state, efforts));
      const InSolidAxes same(system, state, made.balls);
      const Eigen::VectorXd turned = same.axes * efforts;
      const Mujoco::Terms other = mujoco.at(same.q(order.q), same.v(order.v), turned(order.v));
      const Eigen::MatrixXd A = same.axes * own.mass_matrix * same.axes.transpose();
      const Eigen::VectorXd drive = same.axes * (own.generalized_efforts - own.bias),
                            acceleration = same.axes * own.acceleration;
      EXPECT_LT(relative_to_largest(A(order.v, order.v), other.A), 1e-10) << seed;
      EXPECT_LT(relative_to_largest(drive(order.v), other.drive), 1e-10) << seed;
      const double off = relative_to_largest(acceleration(order.v), other.acceleration);
      EXPECT_LT(off, 1e-10) << seed;
      worst = std::max(worst, off);
    }
    // the start: the model's pose, or else the keyframe
    if (mujoco.model->nkey > 0) mj_resetDataKeyframe(mujoco.model, mujoco.data, 0);
    const Eigen::Map<const Eigen::VectorXd> q(mujoco.data->qpos, system.nq), v(mujoco.data->qvel, system.nv);
    const InSolidAxes start(system, system.initial, made.balls);
    EXPECT_LT((start.q(order.q) - q).norm(), 1e-14) << seed;
    EXPECT_LT((start.v(order.v) - v).norm(), 1e-14) << seed;
  }
  RecordProperty("worst_acceleration", fmt::format("{:.1e}", worst));
}

TEST(MjcfWrite, PutsMarkersWhereTheyAre) {
  const WritableScene made = random_scene(1);
  Mujoco mujoco = Mujoco::of(need(write_mjcf(made.scene)).text);
  mj_kinematics(mujoco.model, mujoco.data);
  for (const Marker& marker : made.scene.markers) {
    const int site = mj_name2id(mujoco.model, mjOBJ_SITE, marker.name.c_str());
    ASSERT_GE(site, 0) << marker.name;
    EXPECT_EQ(mujoco.model->site_bodyid[site], mj_name2id(mujoco.model, mjOBJ_BODY, marker.at.solid.c_str()));
    for (int i = 0; i < 3; ++i) EXPECT_EQ(mujoco.model->site_pos[3 * site + i], marker.at.point[i]);
  }
}
#endif

// Samples that lose only run settings keep their mechanics; MuJoCo reads all samples.
TEST(MjcfWrite, ConvertsAllSamplesOrNamesWhatIsLost) {
  int kept = 0;
  for (const auto& file : std::filesystem::directory_iterator(source_folder() + "/samples")) {
    if (file.path().extension() != ".toml") continue;
    const Scene scene = need(read_scene(file.path()));
    const WrittenModel written = need(write_mjcf(scene));
    const System before = compiled(scene), after = compiled(read_back(scene).scene);
#ifdef BORELLI_MUJOCO
    const Mujoco mujoco = Mujoco::of(written.text);
    EXPECT_EQ(mujoco.model->nv, after.nv) << file.path();
#endif
    if (!scene.constraints.empty() || scene.efforts.size() > 1) {
      EXPECT_FALSE(written.omissions.empty()) << file.path();
      continue;
    }
    if (before.nv != after.nv) {
      EXPECT_FALSE(written.omissions.empty()) << file.path();
      continue;
    }
    ++kept;
    const Evaluation a = need(evaluate(before, before.initial)), b = need(evaluate(after, after.initial));
    EXPECT_NEAR(a.kinetic_energy, b.kinetic_energy, 1e-12 * (1 + a.kinetic_energy)) << file.path();
  }
  EXPECT_GT(kept, 5);
}

TEST(MjcfWrite, KeepsRangesMarkersGravityAndStep) {
  WritableScene made = random_scene(2);
  made.scene.simulation.step = 0.0035;
  const Scene back = read_back(made.scene).scene;
  EXPECT_EQ(back.gravity, made.scene.gravity);
  EXPECT_EQ(back.simulation.step, 0.0035);
  ASSERT_EQ(back.markers.size(), made.scene.markers.size());
  std::map<std::string, SolidPoint> markers;
  for (const Marker& m : back.markers) markers[m.name] = m.at;
  for (const Marker& m : made.scene.markers) {
    EXPECT_EQ(markers.at(m.name).solid, m.at.solid);
    EXPECT_EQ(markers.at(m.name).point, m.at.point);
  }
  std::map<std::string, std::vector<Range>> ranges;
  for (const Solid& s : back.solids)
    for (std::size_t i = 0; i < s.switches.size(); ++i) ranges[coordinate_name(s, i)] = s.switches[i].ranges;
  int count = 0;
  for (const Solid& s : made.scene.solids)
    for (const Switch& one : s.switches)
      if (!one.ranges.empty()) {
        ++count;
        EXPECT_EQ(ranges.at(one.coordinate).at(0).lower, one.ranges[0].lower);
        EXPECT_EQ(ranges.at(one.coordinate).at(0).upper, one.ranges[0].upper);
      }
  EXPECT_GT(count, 0);
}

// ---- losses ----

/// One hinged link, modified by `change`.
template <class Change>
WrittenModel changed(const Change& change) {
  Scene scene = chain(2, true, 0.2);
  change(scene);
  return need(write_mjcf(scene));
}

void expect_named(const WrittenModel& written, const std::string& reason, const std::string& name) {
  const auto found =
      std::find_if(written.omissions.begin(), written.omissions.end(), [&](const std::string& line) {
        return line.find(reason) != std::string::npos && line.find(name) != std::string::npos;
      });
  EXPECT_NE(found, written.omissions.end())
      << reason << ", " << name << " not in: " << fmt::format("{}", fmt::join(written.omissions, "\n"));
}

TEST(MjcfWrite, LosesNothingOfPlainScenes) {
  EXPECT_TRUE(changed([](Scene&) {}).omissions.empty());
}

TEST(MjcfWrite, NamesCoordinatesThatItFixes) {
  const auto with = [](SwitchKind kind, Motion motion) {
    return changed([&](Scene& scene) {
      Switch one = hinge("lost", Vector3d::UnitX());
      one.kind = std::move(kind);
      one.motion = std::move(motion);
      one.q.clear(), one.v.clear();
      scene.solids[1].switches.push_back(one);
    });
  };
  expect_named(with(Rotation{}, Driven{{linear(0.3, 1)}}), "driven", "lost");
  expect_named(with(Rotation{}, Locked{}), "locked", "lost");
  expect_named(with(Screw{Vector3d::UnitX(), 0.1}, Free{}), "screw", "lost");
  Guided guided;
  guided.parts.push_back({GuidedPart::Kind::rotation, Vector3d::UnitX(), linear(0, 1)});
  expect_named(with(guided, Free{}), "guided", "lost");
  expect_named(with(OnEllipsoid{{0.3, 0.2, 0.4}}, Free{}), "ellipsoid", "lost");
  expect_named(with(Rotation{Vector3d::UnitX()}, Coupled{"h0", Sine{}}), "coupled by other functions",
               "lost");
  expect_named(with(Rotation{Vector3d::UnitX()}, Coupled{"h0", Polynomial{{0, 1, 2}}}), "soft", "lost");
}

TEST(MjcfWrite, FixesDrivenCoordinatesWhereTheyAreAtTimeZero) {
  Scene scene = chain(2, true, 0.2);
  scene.solids[0].switches[0] = driven(scene.solids[0].switches[0], linear(0.7, 1));
  const System system = compiled(read_back(scene).scene);
  ASSERT_EQ(system.nv, 1);
  // the second link; the moment of the weight is that of the pose at 0.7 rad
  scene.solids[0].switches[0] = hinge("h0", Vector3d::UnitY(), 0.7);
  const System free = compiled(scene);
  const Evaluation a = need(evaluate(system, system.initial)), b = need(evaluate(free, free.initial));
  EXPECT_NEAR(a.bias[0] - a.generalized_efforts[0], b.bias[1] - b.generalized_efforts[1], 1e-13);
}

TEST(MjcfWrite, NamesEffortsConstraintsAndRanges) {
  const WrittenModel written = changed([](Scene& scene) {
    scene.solids.push_back(solid("top", "l1", {ball("turn")}, {link()}));
    scene.solids.back().switches[0].ranges = {{-1, 1}, {-1, 1}, {-1, 1}};
    scene.efforts = {{"push", Force{{"l0", {0, 0, 0}}, {1, 0, 0}, Axes::world, constant(1), {}}},
                     {"twist", Torque{{"l0"}, {1, 0, 0}, Axes::world, constant(1), {}}},
                     {"air", Drag{{"l0", {0, 0, 0}}, 1, 0}},
                     {"swirl", AngularDrag{{"l0"}, 1, 0}},
                     {"across", TorsionSpring{{"l1"}, {"world"}, 1, 0, Vector3d::Zero()}},
                     {"soft stop", LimitSpring{{"h0"}, 100, 0, {{-1, 1}}}},
                     {"follow", PdController{{"h1"}, 1, 1, {linear(0, 1)}}}};
    scene.constraints = {{"rod", Distance{{"l1", {0, 0, -1}}, {"world", {3, 0, 0}}, constant(3)}},
                         {"stop", Limit{{"h1"}, -2, 2, 0.5}},
                         {"one-sided", Limit{{"h0"}, -2, {}, 0}}};
  });
  for (const char* name : {"push (force)", "twist (torque)", "air (drag)", "swirl (angular_drag)",
                           "across (torsion_spring)", "follow (pd_controller)"})
    expect_named(written, "efforts are not written", name);
  expect_named(written, "springs at limits", "soft stop");
  expect_named(written, "constraints are not written", "rod (distance)");
  expect_named(written, "constraints are not written", "one-sided (limit)");
  expect_named(written, "stops are ranges", "stop");
  expect_named(written, "ranges of balls", "turn");
  EXPECT_NE(written.text.find("Lost or changed: ranges of balls"), std::string::npos);
}

// A limit spring that already pushes at the start is not written as a joint range, because a range would move
// the start.
TEST(MjcfWrite, KeepsStartsThatPushAgainstTheirLimits) {
  Scene scene = chain(1, false, 0.2);
  scene.efforts = {{"stop", LimitSpring{{"h0"}, 100, 0, {{0.5, 1}}}}};
  expect_named(need(write_mjcf(scene)), "efforts are not written", "stop (limit_spring)");
  scene.solids[0].switches[0].ranges = {{-1, 2}};
  expect_named(need(write_mjcf(scene)), "springs at limits", "stop");
  const Switch back = read_back(scene).scene.solids.at(0).switches.back();
  EXPECT_EQ(back.ranges.at(0).lower, -1);
  EXPECT_EQ(back.q.at(0), 0.2);
}

TEST(MjcfWrite, NamesBodiesThatGetTheLeastInertia) {
  expect_named(changed([](Scene& scene) {
                 scene.solids[1].inertials.clear();
                 scene.solids.push_back(solid("end", "l1", {fixed({0, 0, -1})}, {link()}));
               }),
               "without mass", "l1");
  expect_named(changed([](Scene& scene) {
                 scene.solids[1].inertials = {{1, {0, 0, -1}, Matrix3d::Zero()}};
               }),
               "moments of inertia", "l1");
}

TEST(MjcfWrite, KeepsLoopsAndSaysThatTheyAreSoft) {
  Scene scene = chain(3, false, 0.3);
  const System system = compiled(scene);
  const Pose X = {rotation_about(Vector3d::UnitY(), 0.3), Vector3d::Zero()};
  scene.solids.push_back(solid("post", "world", {hinge("post", Vector3d::UnitY())}, {link()}));
  const Vector3d elbow = X * Vector3d(0, 0, -1);
  scene.constraints = {{"pin", PointOnPoint{{"l0", {0, 0, -1}}, {"post", elbow}}},
                       {"hold", WeldConstraint{{"l2"}, {"l0"}, Pose{X.R, {0.1, 0.2, 0.3}}}},
                       {"gear", CoordinateCoupling{{{"h1"}, {"h2"}}, {2, -3}, constant(0.4)}},
                       {"cam", CoordinateFunction{{"h2"}, {"h0"}, Polynomial{{0.1, 0.2, 0.3, 0.4, 0.5}}}}};
  const WrittenModel written = need(write_mjcf(scene));
  for (const char* name : {"pin", "hold", "gear", "cam"}) expect_named(written, "soft there", name);
  const System before = compiled(scene), after = compiled(read_back(scene).scene);
  const SameNames at(before, after);
  Random random(3);
  for (int trial = 0; trial < 5; ++trial) {
    const State state = random.state(before);
    State other{.t = 0, .q = Eigen::VectorXd(after.nq), .v = Eigen::VectorXd(after.nv)};
    other.q(at.q) = state.q, other.v(at.v) = state.v;
    const Evaluation a = need(evaluate(before, state)), b = need(evaluate(after, other));
    // rows may be scaled (a coupling by its first ratio) and swap their ends, so accelerations are compared
    EXPECT_LT((b.acceleration(at.v) - a.acceleration).norm(), 1e-10 * a.acceleration.norm()) << trial;
  }
}

TEST(MjcfWrite, SaysHowFarALoopIsOpen) {
  const WrittenModel written = changed([](Scene& scene) {
    scene.constraints = {{"pin", PointOnPoint{{"l1", {0, 0, -1}}, {"world", {5, 0, 0}}}}};
  });
  expect_named(written, "open at the start", "pin (");
}

/// The lengths, points and unit axes of a contact, and its friction.
std::vector<double> numbers_of(const ConstraintKind& kind) {
  std::vector<double> out{surface_of(kind).friction};
  const auto add = [&](const Vector3d& v) { out.insert(out.end(), v.begin(), v.end()); };
  const auto add_plane = [&](const Plane& p) { add(p.on.point), add(p.normal.normalized()); };
  if (const auto* c = std::get_if<SphereOverPlane>(&kind))
    add(c->sphere.point), out.push_back(c->radius), add_plane(c->plane);
  if (const auto* c = std::get_if<CapsuleOverPlane>(&kind)) {
    add(c->capsule.point), add(c->axis.normalized()), add_plane(c->plane);
    out.push_back(c->length), out.push_back(c->radius);
  }
  if (const auto* c = std::get_if<BoxOverPlane>(&kind)) add(c->box.point), add(c->size), add_plane(c->plane);
  if (const auto* c = std::get_if<CapsuleOverCapsule>(&kind)) {
    const bool swapped = c->a.solid == world_name;  // ends have no order
    add(swapped ? c->b.point : c->a.point), add(swapped ? c->a.point : c->b.point);
    add((swapped ? c->axis_b : c->axis_a).normalized()), add((swapped ? c->axis_a : c->axis_b).normalized());
    out.push_back(swapped ? c->length_b : c->length_a), out.push_back(swapped ? c->length_a : c->length_b);
    out.push_back(swapped ? c->radii.b : c->radii.a), out.push_back(swapped ? c->radii.a : c->radii.b);
  }
  return out;
}

void expect_same_numbers(const std::vector<double>& a, const std::vector<double>& b,
                         const std::string& name) {
  ASSERT_EQ(a.size(), b.size()) << name;
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-14) << name << " " << i;
}

TEST(MjcfWrite, KeepsContactsAndSaysThatTheyAreSoft) {
  Scene scene = chain(2, true, 0.2);
  const ContactSurface rough{.restitution = 0, .friction = 0.7}, bouncy{.restitution = 0.4, .friction = 0};
  const Plane floor{{"world", {0, 0, -4}}, {0, 0.6, 0.8}};
  const Plane moving{{"l0", {0, 0, -9}}, {0, 0, 1}};
  scene.constraints = {
      {"ball over floor", SphereOverPlane{{"l1", {0, 0, -1}}, 0.1, floor, rough}},
      {"bar over floor", CapsuleOverPlane{{"l0", {0, 0, -0.5}}, {1, 0, 1}, 0.8, 0.05, floor, rough}},
      {"box over floor", BoxOverPlane{{"l1", {0, 0, -0.5}}, {0.1, 0.2, 0.3}, floor, bouncy}},
      {"bars",
       CapsuleOverCapsule{
           {"l0", {2, 0, 0}}, {"world", {3, 0, 0}}, {0, 0, 1}, {0, 1, 0}, 0.5, 0.6, {0.1, 0.2}, rough}},
      {"point over floor", SphereOverPlane{{"l1", {0, 0, -1}}, 0, floor, rough}},
      {"ball over lid", SphereOverPlane{{"world", {0, 0, 0}}, 0.1, moving, rough}}};
  const WrittenModel written = need(write_mjcf(scene));
  for (const char* name : {"ball over floor", "bar over floor", "bars"})
    expect_named(written, "soft there", name);
  expect_named(written, "do not rebound", "box over floor");
  expect_named(written, "contacts of points", "point over floor");
  expect_named(written, "planes that move", "ball over lid");
  const Scene back = read_back(scene).scene;
  ASSERT_EQ(back.constraints.size(), 4u);
  for (const Constraint& one : scene.constraints) {
    if (one.name.find("over lid") != std::string::npos || one.name.find("point") == 0) continue;
    const auto twin = std::find_if(back.constraints.begin(), back.constraints.end(),
                                   [&](const Constraint& c) { return c.kind.index() == one.kind.index(); });
    ASSERT_NE(twin, back.constraints.end()) << one.name;
    expect_same_numbers(numbers_of(one.kind), numbers_of(twin->kind), one.name);
  }
  // a second writing adds no geoms
  const auto geoms = [](const std::string& text) {
    int count = 0;
    for (auto at = text.find("<geom"); at != std::string::npos; at = text.find("<geom", at + 1)) ++count;
    return count;
  };
  EXPECT_EQ(geoms(written.text), geoms(need(write_mjcf(back)).text));
  EXPECT_EQ(geoms(written.text), 6);
}

TEST(MjcfWrite, RefusesScenesThatDoNotCompile) {
  Scene scene = chain(2, true);
  scene.solids[1].parent = "nobody";
  const auto written = write_mjcf(scene);
  ASSERT_FALSE(written);
  EXPECT_NE(written.error().message().find("nobody"), std::string::npos);
}

TEST(MjcfWrite, EscapesNamesAndComments) {
  Scene scene = chain(2, true);
  scene.solids[1].name = "a<b>&\"c\" \xC3\xA9";
  const Folder folder;
  const std::string text = need(write_mjcf(scene, {.meshes = {}, .comments = {"one -- two --"}})).text;
  const Scene back = need(read_model(folder.write("m.xml", text))).scene;
  EXPECT_EQ(back.solids.at(1).name, scene.solids[1].name);
}

}  // namespace
}  // namespace borelli::test::mjcf_write_test
