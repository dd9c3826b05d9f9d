// Bodies of the phantom and of the ICRP's male written as MJCF, URDF and OpenSim models: MuJoCo and our
// reader give the same mechanics.
#include <gtest/gtest.h>

#include <fmt/ranges.h>

#include <filesystem>

#include "dynamics/formats/model_file.hpp"
#include "dynamics/formats/model_write.hpp"
#include "pipeline/body/measure.hpp"
#include "segmentation/files/read.hpp"
#include "segmentation/labelling/segment.hpp"
#include "tests/dynamics/test_folder.hpp"
#include "tests/dynamics/three_hinges.hpp"
#include "tests/dynamics/writable_scene.hpp"
#include "tests/paths.hpp"
#include "tests/pipeline/motion/phantom_recording.hpp"
#ifdef BORELLI_MUJOCO
#include "tests/dynamics/mujoco_model.hpp"
#endif

namespace borelli::test::written_body_test {
namespace {

Scene phantom_body() {
  const Phantom phantom = build_phantom({}).value();
  return still_body(exact_parts(phantom), phantom.landmarks);
}

// The body from the CT numbers of the ICRP's reference male (publication 110).
Scene icrp_body(const std::string& file) {
  const ScannedVolume scan = need(read_volume(file, {FileQuantity::hu, {}}));
  const Segmentation found = need(segment(scan.volume, {5, 0}));  // work grid of 5 mm
  MeasureOptions options;
  options.deviations = false;
  const InertiaTable table =
      need(measure(scan.volume, found.labels, found.landmarks, options, completeness_of(found.part)));
  std::vector<Warning> ignored;
  return still_body(movable_parts(table, ignored), found.landmarks);
}

// The body's joints have no springs, so balls are measured from their starts.
BallFrames ball_frames(const Scene& body) {
  BallFrames out;
  for (const Solid& solid : body.solids)
    for (std::size_t i = 0; i < solid.switches.size(); ++i) {
      const Switch& one = solid.switches[i];
      if (!std::holds_alternative<Ball>(one.kind) || solid.parent == world_name) continue;
      BallFrame frame{identity_quaternion(), identity_quaternion()};
      if (!one.q.empty()) frame.zero = Quaternion(one.q[0], one.q[1], one.q[2], one.q[3]);
      if (i + 1 < solid.switches.size())
        frame.after = quaternion(std::get<Fixed>(solid.switches[i + 1].kind).X_AB.R);
      out[coordinate_name(solid, i)] = frame;
    }
  return out;
}

// Compares with our reader, to rounding, and with MuJoCo.
void expect_alike_in_mjcf(const Scene& body) {
  const WrittenModel written = need(write_mjcf(body));
  EXPECT_NE(written.text.find("<freejoint name=\"lower_trunk\"/>"), std::string::npos);
  const Folder folder;
  Scene back = need(read_model(folder.write("body.xml", written.text))).scene;
  EXPECT_EQ(back.solids.size(), body.solids.size());
  for (Solid& solid : back.solids)
    for (Switch& one : solid.switches)  // a free joint's coordinates are named after it
      if (one.coordinate.starts_with("lower_trunk.")) one.coordinate[11] = '_';
  const System before = compiled(body), after = compiled(back);
  ASSERT_EQ(before.nv, after.nv);
  const BallFrames balls = ball_frames(body);
  EXPECT_GT(balls.size(), 5u);
  const SameNames at(before, after);
#ifdef BORELLI_MUJOCO
  Mujoco mujoco = Mujoco::of(written.text);
  ASSERT_EQ(mujoco.model->nv, before.nv);
  const Order order = order_in(before, *mujoco.model);
#endif
  Random random(1);
  for (int trial = 0; trial < 3; ++trial) {
    const State state = trial == 0 ? before.initial : random.state(before);
    const InSolidAxes same(before, state, balls);
    State other{.t = 0, .q = Eigen::VectorXd(after.nq), .v = Eigen::VectorXd(after.nv)};
    other.q(at.q) = same.q, other.v(at.v) = same.v;
    const Evaluation a = need(evaluate(before, state)), b = need(evaluate(after, other));
    const Eigen::MatrixXd A = same.axes * a.mass_matrix * same.axes.transpose();
    EXPECT_LT((b.mass_matrix(at.v, at.v) - A).norm(), 1e-12 * A.norm());
    const Eigen::VectorXd drive = same.axes * (a.generalized_efforts - a.bias);
    EXPECT_LT(((b.generalized_efforts - b.bias)(at.v) - drive).norm(), 1e-12 * drive.norm());
#ifdef BORELLI_MUJOCO
    const Mujoco::Terms there = mujoco.at(same.q(order.q), same.v(order.v), Eigen::VectorXd::Zero(before.nv));
    const Eigen::VectorXd acceleration = same.axes * a.acceleration;
    EXPECT_LT(relative_to_largest(A(order.v, order.v), there.A), 1e-10);
    EXPECT_LT(relative_to_largest(drive(order.v), there.drive), 1e-10);
    EXPECT_LT(relative_to_largest(acceleration(order.v), there.acceleration), 1e-10);
#endif
  }
}

#ifdef BORELLI_MUJOCO
// MuJoCo's own reader of URDF: balls are three hinges there.
void expect_alike_in_urdf(const Scene& body) {
  const Folder folder;
  const auto file = folder.write("body.urdf", need(write_urdf(body)).text);
  const System system = compiled(need(read_model(file)).scene);
  ASSERT_GT(system.nv, 30);
  Mujoco mujoco(file);
  const Differences d = differences(system, mujoco, 1, order_in(system, *mujoco.model));
  EXPECT_LT(d.A, 1e-10);
  EXPECT_LT(d.drive, 1e-10);
  EXPECT_LT(d.acceleration, 1e-10);
}

// The OpenSim model by our reader, in terms of three angles a ball, against MuJoCo's reading of the MJCF,
// which has the balls: A' = J^T A J, (Q - B)' = J^T (Q - B - A J' v'), J a' = a - J' v'.
void expect_alike_in_osim(const Scene& body) {
  const Folder folder;
  const System before = compiled(body),
               after =
                   compiled(need(read_model(folder.write("body.osim", need(write_osim(body)).text))).scene);
  ASSERT_EQ(before.nv, after.nv);
  const BallFrames balls = ball_frames(body);
  Mujoco mujoco = Mujoco::of(need(write_mjcf(body)).text);
  const Order order = order_in(before, *mujoco.model);
  Random random(2);
  for (int trial = 0; trial < 3; ++trial) {
    const State state = random.state(after);
    const AsScene scene(before, after, state, "_");
    const InSolidAxes there(before, scene.state, balls);
    const Mujoco::Terms terms =
        mujoco.at(there.q(order.q), there.v(order.v), Eigen::VectorXd::Zero(before.nv));
    Eigen::MatrixXd A(before.nv, before.nv);
    Eigen::VectorXd drive(before.nv), acceleration(before.nv);
    A(order.v, order.v) = terms.A, drive(order.v) = terms.drive, acceleration(order.v) = terms.acceleration;
    A = there.axes.transpose() * A * there.axes;
    drive = there.axes.transpose() * drive, acceleration = there.axes.transpose() * acceleration;
    const Evaluation own = need(evaluate(after, state));
    EXPECT_LT(relative_to_largest(own.mass_matrix, scene.J.transpose() * A * scene.J), 1e-10);
    EXPECT_LT(relative_to_largest(own.generalized_efforts - own.bias,
                                  scene.J.transpose() * (drive - A * scene.bend)),
              1e-10);
    EXPECT_LT(relative_to_largest(scene.J * own.acceleration + scene.bend, acceleration), 1e-10);
  }
}
#endif

TEST(WrittenBody, HasTheSameMechanicsInMjcf) { expect_alike_in_mjcf(phantom_body()); }

#ifdef BORELLI_MUJOCO
TEST(WrittenBody, HasTheSameMechanicsInUrdf) { expect_alike_in_urdf(phantom_body()); }

TEST(WrittenBody, HasTheSameMechanicsInOpenSimModels) { expect_alike_in_osim(phantom_body()); }

TEST(WrittenBody, OfTheIcrpMaleHasTheSameMechanicsInEachFormat) {
  const std::string file = test::shared_folder() + "/volumes/icrp_am/AM_hu.nii.gz";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "needs " << file;
  const Scene body = icrp_body(file);
  ASSERT_EQ(body.solids.size(), 16u);
  expect_alike_in_mjcf(body);
  expect_alike_in_urdf(body);
  expect_alike_in_osim(body);
}
#endif

// The links' positions, masses and centres at zero, from the scene's switches alone, which URDF must match
// for any joints.
TEST(WrittenBody, HasTheSamePlacesAndMassesInUrdfAtZero) {
  Scene body = phantom_body();
  const WrittenModel written = need(write_urdf(body));
  const Folder folder;
  const Scene back = need(read_model(folder.write("body.urdf", written.text))).scene;
  for (Solid& solid : body.solids)  // URDF starts at zero
    for (Switch& one : solid.switches) one.q.clear(), one.v.clear(), one.ranges.clear();
  const System before = compiled(body), after = compiled(back);
  ASSERT_EQ(before.nv, after.nv);
  const Evaluation a = need(evaluate(before, before.initial)), b = need(evaluate(after, after.initial));
  EXPECT_NEAR(a.momenta.mass, b.momenta.mass, 1e-12 * a.momenta.mass);
  EXPECT_LT((a.momenta.centre - b.momenta.centre).norm(), 1e-13);
  // at zero a ball's three hinges turn about its axes, so the matrices are equal
  Eigen::VectorXi at(before.nv);
  for (const CoordinateInfo& info : before.coordinates)
    for (int i = 0; i < info.v_size; ++i) {
      const std::string hinge = info.name + "." + "xyz"[i];
      const auto found =
          std::find_if(after.coordinates.begin(), after.coordinates.end(), [&](const CoordinateInfo& other) {
            std::string name = info.name;
            if (name.starts_with("lower_trunk_")) name[11] = '.';
            return other.name == name || other.name == hinge;
          });
      ASSERT_NE(found, after.coordinates.end()) << info.name;
      at[info.v_index + i] = found->v_index + (found->v_size == 3 ? i : 0);
    }
  EXPECT_LT((b.mass_matrix(at, at) - a.mass_matrix).norm(), 1e-12 * a.mass_matrix.norm());
}

}  // namespace
}  // namespace borelli::test::written_body_test
