// Joint reactions against statics and a pendulum by hand, the equations of motion of every coordinate, and
// MuJoCo's interaction forces.
#include "dynamics/equations/reaction.hpp"

#include "dynamics/constraints/local_coordinates.hpp"
#include "dynamics/equations/evaluate.hpp"
#include "random_scene.hpp"

#ifdef BORELLI_MUJOCO
#include "mujoco_twin.hpp"
#endif

namespace borelli::test {
namespace {

std::vector<JointReaction> reactions_at(const Scene& scene, const State& state) {
  const Evaluation e = need(evaluate(compiled(scene), state));
  return need(Reactions::of(scene)).at(state, e.acceleration, e.multipliers);
}

TEST(Reaction, OfAPendulumEqualsItsTension) {
  const double mass = 2, length = 1.5;
  Scene scene;
  scene.solids = {solid("bob", "world", {fixed({1, 2, 3}), hinge("swing", Vector3d::UnitY())},
                        {inertial(mass, {0, 0, -length}, {0, 0, 0})})};
  State state{.t = 0, .q = Eigen::VectorXd::Zero(1), .v = Eigen::VectorXd::Zero(1)};
  for (const double angle : {0.0, 0.7, 2.5})
    for (const double speed : {0.0, 3.0}) {
      state.q[0] = angle, state.v[0] = speed;
      const JointReaction r = reactions_at(scene, state)[0];
      const Vector3d up = rotation_about(Vector3d::UnitY(), angle) * Vector3d::UnitZ();
      const double tension = mass * (9.81 * std::cos(angle) + length * speed * speed);
      EXPECT_LT((r.force - tension * up).norm(), 1e-12 * (1 + std::abs(tension)));
      EXPECT_LT(r.moment.norm(), 1e-12 * (1 + std::abs(tension)));
      EXPECT_LT((r.point - Vector3d(1, 2, 3)).norm(), 1e-15);
      EXPECT_TRUE(r.unique);
    }
}

TEST(Reaction, OfAHangingChainEqualsTheWeightBelow) {
  const Scene scene = chain(5, true);
  const auto r = reactions_at(scene, compiled(scene).initial);
  for (int i = 0; i < 5; ++i) {
    EXPECT_LT((r[i].force - Vector3d(0, 0, 9.81 * (5 - i))).norm(), 1e-11);
    EXPECT_LT(r[i].moment.norm(), 1e-11);
    EXPECT_LT((r[i].point - Vector3d(0, 0, -i)).norm(), 1e-14);
  }
}

// A bar of four welded or locked pieces of 0.5 m and 3 kg sticks out of a wall: each weld bears the moment of
// the weight beyond it.
TEST(Reaction, OfWeldsAndLockedJointsEqualsABeams) {
  Scene scene;
  for (int i = 0; i < 4; ++i) {
    std::vector<Switch> joint{fixed({i ? 0.5 : 0, 0, 0}, rotation_about(Vector3d::UnitX(), 0.3))};
    if (i == 2) {
      joint.push_back(hinge("lock", Vector3d::UnitY(), 0));
      joint.back().motion = Locked{};
    }
    scene.solids.push_back(solid(fmt::format("piece{}", i), i ? fmt::format("piece{}", i - 1) : "world",
                                 joint, {inertial(3, {0.25, 0, 0}, {0.1, 0.1, 0.1})}));
  }
  const auto r = reactions_at(scene, {.t = 0, .q = Eigen::VectorXd(0), .v = Eigen::VectorXd(0)});
  for (int i = 0; i < 4; ++i) {
    const double beyond = 4 - i, weight = 3 * 9.81 * beyond;
    EXPECT_LT((r[i].force - Vector3d(0, 0, weight)).norm(), 1e-11) << i;
    // weight down at x = beyond/4 of the piece's end: its moment about y is +x W, and the weld's the opposite
    EXPECT_LT((r[i].moment - Vector3d(0, -weight * beyond * 0.25, 0)).norm(), 1e-11) << i;
    EXPECT_LT((r[i].point - Vector3d(0.5 * i, 0, 0)).norm(), 1e-15);
  }
  EXPECT_LT((r[2].R_WP - rotation_about(Vector3d::UnitX(), 0.6)).norm(), 1e-15);
}

// Along the twist of a joint's last switch, the reaction equals the efforts on the coordinate itself plus the
// drive's effort. (Other tests check A, B, Q, L and the drives' efforts.) Scenes have all kinds of joints,
// springs, forces, constraints, welds and locks.
TEST(Reaction, AlongEachCoordinateEqualsItsEffort) {
  int compared = 0;
  for (const bool constrained : {false, true})
    for (unsigned seed = 0; seed < 40; ++seed) {
      Scene scene = RandomScene(seed, 6, constrained).scene;
      std::erase_if(scene.constraints, [](const Constraint& c) { return c.name == "gear"; });
      const auto system = compile(scene);
      if (!system || system->nv == 0) continue;
      State state = Random(seed + 900).state(*system);
      state.t = 0.3;
      const auto e = evaluate(*system, state);
      if (!e || e->acceleration.norm() > 1e4) continue;
      const auto r = need(Reactions::of(scene)).at(state, e->acceleration, e->multipliers);
      Kinematics k(*system, Equations::recursive);
      EffortSums efforts(*system);
      update_kinematics(*system, system->parameters, state.t, state.q.data(), state.v.data(), k);
      scan_efforts(*system, system->parameters, k, efforts);
      double load = 1;
      for (const JointReaction& one : r) load = std::max({load, one.force.norm(), one.moment.norm()});
      for (std::size_t i = 0; i < scene.solids.size(); ++i) {
        const Body& body = system->bodies[std::size_t(system->solid_bodies[i])];
        if (body.step_count == 0 || body.solids[0] != int(i)) continue;  // a weld
        const SwitchStep& step = system->steps[std::size_t(body.first_step + body.step_count - 1)];
        for (int u = step.u; u < step.u + step.nv; ++u) {
          const double along = k.angular(u).dot(r[i].moment) + k.linear(u).dot(r[i].force);
          const double own = efforts.coordinate[u] + (u < system->nv ? 0 : e->drive_efforts[u - system->nv]);
          EXPECT_NEAR(along, own, 1e-10 * load) << "seed " << seed << ", solid " << i;
          ++compared;
        }
      }
    }
  EXPECT_GT(compared, 100);
}

// A door on two hinges: the second hinge, a constraint, can bear any share of the load along the axis.
TEST(Reaction, WithRedundantConstraintsIsNotUnique) {
  Scene scene;
  scene.solids = {solid("door", "world", {hinge("turn", Vector3d::UnitZ(), 0, 2)},
                        {inertial(20, {0.4, 0, 1}, {5, 6, 1.5})}),
                  solid("handle", "door", {fixed({0.8, 0, 1}), hinge("grip", Vector3d::UnitY())},
                        {inertial(0.5, {0.1, 0, 0}, {0.001, 0.001, 0.001})})};
  scene.constraints = {{"upper hinge", PointOnPoint{{"door", {0, 0, 2}}, {"world", {0, 0, 2}}}}};
  const System system = compiled(scene);
  const auto r = reactions_at(scene, system.initial);
  EXPECT_FALSE(r[0].unique);
  EXPECT_TRUE(r[1].unique);
  scene.constraints.clear();
  EXPECT_TRUE(reactions_at(scene, system.initial)[0].unique);
  // a rod alone holds the door
  scene.constraints = {{"rod", Distance{{"door", {0.8, 0, 1}}, {"world", {0.8, -1, 1}}, constant(1)}}};
  EXPECT_TRUE(reactions_at(scene, system.initial)[0].unique);
}

TEST(Reaction, IsWrittenForEveryRowOfATrajectory) {
  Scene scene = chain(2, false, 0.5);
  SimulationSettings how = settings("dopri5", 1, 1e-3, 1e-9);
  how.output_interval = 0.25;
  const System system = compiled(scene);
  Trajectory motion = run(system, how);
  ASSERT_TRUE(add_reactions(scene, motion));
  ASSERT_EQ(motion.reaction_forces.rows(), 5);
  ASSERT_EQ(motion.reaction_forces.cols(), 6);
  for (Eigen::Index row = 0; row < 5; ++row) {
    const State state{.t = motion.times[row], .q = motion.q.row(row), .v = motion.v.row(row)};
    const auto r = reactions_at(scene, state);
    for (int j = 0; j < 2; ++j) {
      EXPECT_LT((motion.reaction_forces.row(row).segment<3>(3 * j).transpose() - r[j].force).norm(), 1e-10);
      EXPECT_LT((motion.reaction_moments.row(row).segment<3>(3 * j).transpose() - r[j].moment).norm(), 1e-10);
    }
  }
}

// The ground's force on a resting ball is a contact force; its joints transmit nothing.
TEST(Reaction, IncludesContactForces) {
  Scene scene;
  scene.solids = {
      solid("ball", "world", free_switches("ball"), {inertial(1, {0, 0, 0}, {0.004, 0.004, 0.004})})};
  scene.solids[0].switches[2].q = {0.1};
  scene.constraints = {
      {"ground",
       SphereOverPlane{{"ball", {0, 0, 0}}, 0.1, {{"world", {0, 0, 0}}, Vector3d::UnitZ()}, {0, 0.5}}}};
  Trajectory motion = run(scene, settings("dopri5", 1, 1e-2));
  ASSERT_TRUE(add_reactions(scene, motion));
  EXPECT_NEAR(motion.contact_forces(1, 0), 9.81, 1e-9);
  EXPECT_LT(last(motion.reaction_forces).norm(), 1e-9);
  EXPECT_LT(last(motion.reaction_moments).norm(), 1e-9);
}

#ifdef BORELLI_MUJOCO
TEST(Reaction, MatchesMuJoCosInteractionForce) {
  for (Joints joints : {Joints::hinges, Joints::balls, Joints::mixed, Joints::free})
    for (unsigned seed : {5u, 6u}) {
      const Twin twin = TwinMaker(seed, joints, 6).make();
      const System system = compiled(twin.scene);
      const Mujoco mujoco = Mujoco::of(twin.xml);
      const State state = Random(3).state(system);
      std::copy(state.q.begin(), state.q.end(), mujoco.data->qpos);
      std::copy(state.v.begin(), state.v.end(), mujoco.data->qvel);
      mj_forward(mujoco.model, mujoco.data);
      mj_rnePostConstraint(mujoco.model, mujoco.data);
      const auto r = reactions_at(twin.scene, state);
      for (std::size_t i = 0; i < r.size(); ++i) {
        const int body = mj_name2id(mujoco.model, mjOBJ_BODY, twin.scene.solids[i].name.c_str());
        ASSERT_GT(body, 0);
        // torque and force, about the gravity centre of the whole tree
        const Eigen::Map<Vector3d> torque(mujoco.data->cfrc_int + 6 * body),
            force(mujoco.data->cfrc_int + 6 * body + 3),
            about(mujoco.data->subtree_com + 3 * mujoco.model->body_rootid[body]);
        const double size = 1 + force.norm() + torque.norm();
        EXPECT_LT((r[i].force - force).norm(), 1e-10 * size);
        EXPECT_LT((r[i].moment + (r[i].point - about).cross(r[i].force) - torque).norm(), 1e-10 * size);
      }
    }
}
#endif

}  // namespace
}  // namespace borelli::test
