// Scenes written as URDF: our reader and MuJoCo's give the same mechanics, and each loss is named.
#include <gtest/gtest.h>

#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

#include "dynamics/formats/model_file.hpp"
#include "dynamics/formats/model_write.hpp"
#include "tests/dynamics/test_folder.hpp"
#include "tests/dynamics/three_hinges.hpp"
#include "tests/dynamics/writable_scene.hpp"
#ifdef BORELLI_MUJOCO
#include "tests/dynamics/mujoco_model.hpp"
#endif

namespace borelli::test::urdf_write_test {
namespace {

constexpr int seeds = 200;

Scene read_back(const std::string& text) {
  const Folder folder;
  return need(read_model(folder.write("written.urdf", text))).scene;
}

// M' = J^T M J and (Q - B)' = J^T (Q - B - M J' v')
TEST(UrdfWrite, ReadsBackWithTheSameMechanics) {
  for (unsigned seed = 0; seed < seeds; ++seed) {
    const WritableScene made(seed, 7, {.springs = false, .balls = true, .free_root = seed % 3 != 0});
    const System before = compiled(made.scene),
                 after = compiled(read_back(need(write_urdf(made.scene)).text));
    ASSERT_EQ(before.nv, after.nv) << seed;
    Random random(seed);
    for (int trial = 0; trial < 3; ++trial) {
      const State state = random.state(after);
      const AsScene same(before, after, state, ".");
      const Evaluation a = need(evaluate(before, same.state)), b = need(evaluate(after, state));
      const Eigen::MatrixXd M = same.J.transpose() * a.mass_matrix * same.J;
      EXPECT_LT((b.mass_matrix - M).norm(), 1e-12 * M.norm()) << seed;
      const Eigen::VectorXd drive =
          same.J.transpose() * (a.generalized_efforts - a.bias - a.mass_matrix * same.bend);
      EXPECT_LT((b.generalized_efforts - b.bias - drive).norm(), 1e-12 * drive.norm()) << seed;
    }
  }
}

// A rod, a plate, a ball and bodies in between, turned or not: tensors are exact to rounding of their largest
// moment.
TEST(UrdfWrite, KeepsTensorsOfTurnedBodies) {
  const Vector3d shapes[] = {{1, 1, 1}, {1e-6, 1, 1},           {1, 1, 2},
                             {1, 2, 3}, {0.5, 0.5 + 1e-9, 0.7}, {2, 1, 2}};
  const double quarter = std::acos(0.0);
  const Matrix3d turns[] = {Matrix3d::Identity(), rotation_about(Vector3d::UnitY(), quarter),
                            rotation_about(Vector3d(1, 2, 3).normalized(), 0.7),
                            rotation_about(Vector3d::UnitX(), 1e-9)};
  for (const Vector3d& moments : shapes)
    for (const Matrix3d& R : turns) {
      Scene scene = chain(1, false);
      const Matrix3d tensor = R * moments.asDiagonal() * R.transpose();
      scene.solids[0].inertials = {{3, {0.1, 0.2, 0.3}, 0.5 * (tensor + tensor.transpose())}};
      const Inertial back = read_back(need(write_urdf(scene)).text).solids.at(0).inertials.at(0);
      EXPECT_EQ(back.mass, 3);
      EXPECT_EQ(back.centre, Vector3d(0.1, 0.2, 0.3));
      EXPECT_LT((back.tensor - tensor).norm(), 1e-14 * tensor.norm()) << moments << "\n" << R;
    }
}

#ifdef BORELLI_MUJOCO
// MuJoCo's own reader of URDF, for trees without balls (apart from a free joint's).
TEST(UrdfWrite, MovesInMujocoAsHere) {
  for (unsigned seed = 0; seed < seeds; ++seed) {
    const WritableScene made(seed, 7, {.springs = false, .balls = false, .free_root = seed % 3 != 0});
    const Folder folder;
    const System system = compiled(made.scene);
    Mujoco mujoco(folder.write("m.urdf", need(write_urdf(made.scene)).text));
    const Differences d = differences(system, mujoco, seed, order_in(system, *mujoco.model));
    EXPECT_LT(d.A, 1e-10) << seed;
    EXPECT_LT(d.drive, 1e-10) << seed;
    EXPECT_LT(d.acceleration, 1e-10) << seed;
  }
}
#endif

// ---- losses ----

template <class Change>
WrittenModel changed(const Change& change) {
  Scene scene = chain(2, true);
  change(scene);
  return need(write_urdf(scene));
}

void expect_named(const WrittenModel& written, const std::string& reason, const std::string& name) {
  const bool found =
      std::any_of(written.omissions.begin(), written.omissions.end(), [&](const std::string& line) {
        return line.find(reason) != std::string::npos && line.find(name) != std::string::npos;
      });
  EXPECT_TRUE(found) << reason << ", " << name
                     << " not in: " << fmt::format("{}", fmt::join(written.omissions, "\n"));
}

TEST(UrdfWrite, ConvertsAllSamplesOrNamesWhatIsLost) {
  for (const auto& file : std::filesystem::directory_iterator(source_folder() + "/samples")) {
    if (file.path().extension() != ".toml") continue;
    const Scene scene = need(read_scene(file.path()));
    const WrittenModel written = need(write_urdf(scene));
    const System before = compiled(scene), after = compiled(read_back(written.text));
    EXPECT_TRUE(before.nv == after.nv || !written.omissions.empty()) << file.path();
    EXPECT_GE(written.omissions.size(), scene.constraints.empty() ? 0u : 1u) << file.path();
  }
}

TEST(UrdfWrite, LosesNothingOfPlainScenes) {
  EXPECT_TRUE(changed([](Scene&) {}).omissions.empty());
}

TEST(UrdfWrite, NamesWhatItLoses) {
  const WrittenModel written = changed([](Scene& scene) {
    scene.gravity = {0, -9.81, 0};
    scene.solids[0].switches[0].q = {0.3};
    scene.solids[1].switches.back().armature = 0.1;
    scene.solids.push_back(solid("top", "l1", {ball("turn"), slide("rail", Vector3d::UnitX())}, {link()}));
    scene.solids.back().shapes.push_back({{Ellipsoid{{1, 2, 3}}}, {}, {}});
    scene.solids.push_back(
        solid("lost", "l1", {driven(hinge("crank", Vector3d::UnitX()), linear(0, 1))}, {}));
    scene.efforts = {{"push", Force{{"l0", {0, 0, 0}}, {1, 0, 0}, Axes::world, constant(1), {}}},
                     {"elastic", CoordinateSpring{{"h0"}, 3, 0.5, 0}},
                     {"round", TorsionSpring{{"top"}, {"l1"}, 1, 2, Vector3d::Zero()}},
                     {"thread", PointSpring{{"l0", {0, 0, 0}}, {"world", {1, 0, 0}}, 1, 0, 1}}};
    scene.constraints = {{"pin", PointOnPoint{{"l1", {0, 0, -1}}, {"world", {0, 0, -2}}}},
                         {"cam", CoordinateFunction{{"h1"}, {"rail"}, Polynomial{{0, 0, 1}}}},
                         {"gear", CoordinateCoupling{{{"h1"}, {"rail"}}, {2, 3}, constant(0)}}};
    scene.markers = {{"l0", {"l0", {1, 2, 3}}, 0}};
  });
  expect_named(written, "gravity", "0 -9.81 0");
  expect_named(written, "starts other than zero", "h0");
  expect_named(written, "armatures", "h1");
  expect_named(written, "balls are three hinges", "turn");
  expect_named(written, "links of 1e-15 kg", "turn.x_link");
  expect_named(written, "slides without a range", "rail");
  expect_named(written, "not drawn", "top");
  expect_named(written, "driven", "crank");
  expect_named(written, "efforts are not written", "push (force)");
  expect_named(written, "efforts are not written", "thread (point_spring)");
  expect_named(written, "springs of joints", "h0");
  expect_named(written, "springs of joints", "turn");
  expect_named(written, "dampers of balls", "turn");
  expect_named(written, "constraints are not written", "pin (point_on_point)");
  expect_named(written, "constraints are not written", "cam (coordinate_function)");
  expect_named(written, "<mimic>", "gear");
  expect_named(written, "markers are links", "l0");
  expect_named(written, "names", "l0 is l0_");
}

TEST(UrdfWrite, KeepsRangesDampersAndCouplings) {
  Scene scene = chain(3, true);
  scene.solids[1].switches.back().ranges = {{-0.25, 1.5}};
  scene.efforts = {{"d", CoordinateSpring{.on = {"h2"}, .damping = 0.75}}};
  scene.constraints = {{"gear", CoordinateCoupling{{{"h0"}, {"h2"}}, {2, -3}, constant(0.5)}}};
  const Scene back = read_back(need(write_urdf(scene)).text);
  const auto& ranges = back.solids.at(1).switches.back().ranges;
  ASSERT_EQ(ranges.size(), 1u);
  EXPECT_EQ(ranges[0].lower, -0.25);
  EXPECT_EQ(ranges[0].upper, 1.5);
  EXPECT_EQ(std::get<CoordinateSpring>(back.efforts.at(0).kind).damping, 0.75);
  const auto& gear = std::get<CoordinateCoupling>(back.constraints.at(0).kind);
  EXPECT_EQ(gear.ratios, (std::vector{1.0, -1.5}));
  EXPECT_EQ(at(gear.value, 0).value, 0.25);
}

// At a pitch of a right angle, roll and yaw turn about one line.
TEST(UrdfWrite, PlacesLinksAtAPitchOfARightAngle) {
  for (const double pitch : {1.0, -1.0})
    for (const double off : {0.0, 1e-9, 1e-5}) {
      Scene scene = chain(1, false);
      const Matrix3d R = rotation_about(Vector3d::UnitZ(), 0.7) *
                         rotation_about(Vector3d::UnitY(), pitch * (std::acos(0.0) - off)) *
                         rotation_about(Vector3d::UnitX(), 0.4);
      scene.solids[0].switches.insert(scene.solids[0].switches.begin(), fixed({1, 2, 3}, R));
      const Scene back = read_back(need(write_urdf(scene)).text);
      const Pose X = std::get<Fixed>(back.solids.at(0).switches.at(0).kind).X_AB;
      EXPECT_LT((X.R - R).norm(), 1e-15 * 10) << pitch << " " << off;
      EXPECT_EQ(X.p, Vector3d(1, 2, 3));
    }
}

}  // namespace
}  // namespace borelli::test::urdf_write_test
