// The phantom's body written as MJCF and URDF: MuJoCo and our reader make the same mechanics of it.
#include <gtest/gtest.h>

#include <fmt/ranges.h>

#include "dynamics/formats/model_file.hpp"
#include "dynamics/formats/model_write.hpp"
#include "tests/dynamics/test_folder.hpp"
#include "tests/dynamics/writable_scene.hpp"
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

// The body's joints have no springs, so that balls count from their starts.
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

TEST(WrittenBody, HasTheSameMechanicsInMjcf) {
  const Scene body = phantom_body();
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

// The links' places, masses and centres at zero, from the scene's switches alone: what URDF holds whatever its
// joints are.
TEST(WrittenBody, StandsAlikeInUrdf) {
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
  // at zero a ball's three hinges turn about its own axes: the matrices are the same
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
