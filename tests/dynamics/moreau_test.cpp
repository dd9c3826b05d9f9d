// Moreau's time stepping: a block on a slope, a ball that comes to rest, a heap of balls, momentum and energy
// at impacts, and its order against runs with located impacts.
#include "dynamics/methods/moreau.hpp"

#include <cmath>

#include "dynamics/formats/model_file.hpp"
#include "each_width.hpp"
#include "moreau_scenes.hpp"
#include "tests/paths.hpp"

namespace borelli::test::moreau_test {
namespace {

TEST(Moreau, BlockOnASlopeFollowsCoulombsLaw) {
  const double tilt = 0.5, g = 9.81;
  for (double friction : {0.3, 0.7}) {  // tan(0.5) = 0.546
    Scene scene;
    Solid block = free_ball("block", {0, 0, 0.1}, 0.1, 2);
    block.inertials = {inertial(2, {0, 0, 0}, {0.02, 0.02, 0.02})};
    scene.gravity = {g * std::sin(tilt), 0, -g * std::cos(tilt)};  // the slope's own axes
    scene.solids = {block};
    BoxOverPlane kind;
    kind.box = {"block", {0, 0, 0}};
    kind.size = {0.4, 0.4, 0.2};
    kind.plane.on = {"world", {0, 0, 0}};
    kind.surface.friction = friction;
    scene.constraints = {{"slope", kind}};
    const Trajectory path = run(scene, settings("moreau", 1, 1e-3));
    const double a = std::max(0., g * (std::sin(tilt) - friction * std::cos(tilt)));
    // with constant forces the scheme is exact up to the impulses' accuracy: 1e-8 of velocities a step
    EXPECT_NEAR(last(path.q)[0], a / 2, 1e-6) << friction;
    EXPECT_NEAR(last(path.v)[0], a, 1e-6) << friction;
    EXPECT_NEAR(last(path.q)[2], 0.1, 1e-6) << friction;
    EXPECT_TRUE(path.certificate.trusted) << path.certificate.reason;
    // friction's work is in the balance
    EXPECT_NEAR(path.certificate.work_events, -2 * g * std::cos(tilt) * friction * a / 2, 1e-5) << friction;
  }
}

TEST(Moreau, BouncingBallComesToRest) {
  const double e = 0.5, height = 0.5, g = 9.81, h = 1e-4;
  Scene scene;
  scene.solids = {free_ball("ball", {0, 0, height + 0.1}, 0.1, 1)};
  scene.constraints = {over_floor("ball", 0.1, e, 0)};
  const double fall = std::sqrt(2 * height / g), rest = fall * (1 + 2 * e / (1 - e));
  const Trajectory path = run(scene, settings("moreau", 1.2 * rest, h));
  // the overlap is at most one step at the first impact's speed; the ball rests where the last impact left it
  const double deepest = h * std::sqrt(2 * g * height);
  EXPECT_LT(path.certificate.residuals[0].position, deepest);
  EXPECT_NEAR(last(path.q)[2], 0.1, deepest);
  EXPECT_LT(last(path.q)[2] - 0.1, 1e-8);  // nor above it
  EXPECT_LT(std::abs(last(path.v)[2]), 1e-9);
  EXPECT_TRUE(path.certificate.trusted) << path.certificate.reason;
  EXPECT_NEAR(path.certificate.work_events, -g * height, 10 * g * deepest);
  // before that it still moves
  EXPECT_GT(std::abs(last(run(scene, settings("moreau", 0.8 * rest, h)).v)[2]), 0.01);
}

TEST(Moreau, ConvergesToTheEventRun) {
  // a ball thrown with spin on a floor with friction, past its first two impacts
  Scene scene;
  Solid thrown = free_ball("ball", {0, 0, 0.4}, 0.1, 1);
  thrown.switches[0].v = {2};
  thrown.switches[3].v = {1, -20, 3};
  scene.solids = {thrown};
  scene.constraints = {over_floor("ball", 0.1, 0.8, 0.3)};
  const Eigen::VectorXd reference = last(run(scene, settings("dop853", 0.7, 1e-3, 1e-12)).q).head(3);
  const auto error = [&](double h) {
    SimulationSettings whole = settings("moreau", 0.7, h);
    whole.energy_threshold = 1;  // no step is made in parts
    return (last(run(scene, whole).q).head(3) - reference).norm();
  };
  // first order, measured over a factor of 64 because an impact's place in its step is random
  const double coarse = error(3.2e-3), fine = error(5e-5);
  EXPECT_LT(fine, 5e-5 * 5);  // two impacts of 2.4 m/s and less, within a step
  EXPECT_LT(fine, coarse / 16);
}

TEST(Moreau, KeepsMomentumAndNeverAddsEnergy) {
  Scene scene;
  scene.gravity.setZero();
  Random random(5);
  const double radius = 0.1;
  for (int i = 0; i < 6; ++i) {
    Solid one = free_ball(fmt::format("b{}", i), {0.3 * i, 0.04 * (i % 2), 0.03 * (i % 3)}, radius, 1 + i);
    one.switches[0].v = {1.5 - 0.6 * i};
    one.switches[3].v = {0, 0, 5. * (i - 3)};
    scene.solids.push_back(one);
  }
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < i; ++j)
      scene.constraints.push_back(between(scene.solids[i].name, scene.solids[j].name, radius, 0.9, 0.4));
  SimulationSettings how = settings("moreau", 1, 2.5e-4);
  how.output_interval = 1e-3;
  const Trajectory path = run(scene, how);
  EXPECT_GT(path.certificate.impacts, 4);
  double before = path.kinetic[0];
  for (std::size_t i = 1; i < path.kinetic.size(); ++i) {
    EXPECT_LE(path.kinetic[i], before * (1 + 1e-12)) << path.times[i];
    before = path.kinetic[i];
  }
  EXPECT_LT(before, 0.95 * path.kinetic[0]);
  ASSERT_FALSE(path.certificate.conserved.empty());
  EXPECT_LT(path.certificate.conserved[0].drift, 1e-11 * path.certificate.conserved[0].scale);
  EXPECT_TRUE(path.certificate.trusted) << path.certificate.reason;
}

TEST(Moreau, HeapOfTwentyBallsComesToRest) {
  Scene scene;
  const double radius = 0.1, h = 2e-3;
  for (int i = 0; i < 20; ++i)  // five layers of four, each turned and shifted a little
    scene.solids.push_back(free_ball(fmt::format("b{}", i),
                                     {0.102 * (2 * (i % 2) - 1) + 0.01 * (i / 4), 0.102 * (i % 4 / 2 * 2 - 1),
                                      radius + 0.21 * (i / 4) + 0.001 * (i % 4)},
                                     radius, 1));
  for (int i = 0; i < 20; ++i) {
    scene.constraints.push_back(over_floor(scene.solids[i].name, radius, 0.2, 0.6));
    for (int j = 0; j < i; ++j)
      scene.constraints.push_back(between(scene.solids[i].name, scene.solids[j].name, radius, 0.2, 0.6));
    // rolling is damped a little, or balls would roll forever
    for (const char* axis : {"x", "y", "z"}) {
      const std::string coordinate = scene.solids[i].name + "." + axis;
      scene.efforts.push_back({coordinate + " drag", CoordinateSpring{{coordinate}, 0, 3, 0}});
    }
  }
  const Trajectory path = run(scene, settings("moreau", 4, h));
  const Certificate& c = path.certificate;
  double deepest = 0;
  for (const auto& residual : c.residuals) deepest = std::max(deepest, residual.position);
  // an impact of neighbours may close a contact again, each by one step at its speed (a fall of 1 m at most)
  EXPECT_LT(deepest, 4 * h * std::sqrt(2 * 9.81));
  EXPECT_LT(last(path.v).cwiseAbs().maxCoeff(), 0.02);
  EXPECT_LT(path.kinetic.back(), 1e-4);
  EXPECT_GT(c.impacts, 20);
  EXPECT_LT(c.work_events, 0);
  EXPECT_LT(c.energy_drift, 1e-2 * c.energy_turnover);
}

TEST(Moreau, RecordsContactForces) {
  // a ball that bounces and comes to rest: the floor's impulses equal its change of momentum
  Scene scene;
  scene.solids = {free_ball("ball", {0, 0, 0.4}, 0.1, 2)};
  scene.constraints = {over_floor("ball", 0.1, 0.5, 0)};
  SimulationSettings how = settings("moreau", 2, 1e-3);
  how.output_interval = 0.02;
  const Trajectory path = run(scene, how);
  double all = 0;
  for (std::size_t row = 1; row < path.times.size(); ++row)
    all += path.contact_forces(Eigen::Index(row), 0) * (path.times[row] - path.times[row - 1]);
  EXPECT_NEAR(all, 2 * 9.81 * 2 + 2 * last(path.v)[2], 1e-8);
  EXPECT_EQ(path.contact_modes(1, 0), 0);
  EXPECT_EQ(last(path.contact_modes)[0], 1);  // without friction
  EXPECT_NEAR(last(path.contact_forces)[0], 2 * 9.81, 1e-6);
  // a ball on a floor that is pulled along sticks, and rolls: 2/7 of the pull is friction
  scene.solids = {free_ball("ball", {0, 0, 0.1}, 0.1, 2)};
  scene.constraints = {over_floor("ball", 0.1, 0, 0.5)};
  scene.gravity = {1, 0, -9.81};
  const Trajectory rolls = run(scene, how);
  EXPECT_EQ(last(rolls.contact_modes)[0], 2);
  EXPECT_NEAR(last(rolls.contact_forces)[0], 2 * 9.81, 1e-5);
  EXPECT_NEAR(last(rolls.multipliers).tail<2>().norm(), 2. / 7 * 2, 1e-5);
  // with less friction it slips
  scene.constraints = {over_floor("ball", 0.1, 0, 0.01)};
  const Trajectory slips = run(scene, how);
  EXPECT_EQ(last(slips.contact_modes)[0], 1);
  EXPECT_NEAR(last(slips.multipliers).tail<2>().norm(), 0.01 * 2 * 9.81, 1e-5);
}

TEST(Moreau, EightyContactsRestAtOnce) {
  Scene scene;
  for (int i = 0; i < 80; ++i) {
    const std::string name = fmt::format("b{}", i);
    scene.solids.push_back(free_ball(name, {0.3 * i, 0, 0.1}, 0.1, 1 + i));
    scene.constraints.push_back(over_floor(name, 0.1, 0, 0.5));
  }
  const Trajectory path = run(scene, settings("moreau", 0.1, 1e-3));
  EXPECT_LT(last(path.v).cwiseAbs().maxCoeff(), 1e-8);
  for (const auto& residual : path.certificate.residuals) EXPECT_LT(residual.position, 1e-9);
}

TEST(Moreau, CountsWorkOnRestingBodies) {
  Scene pressed;
  pressed.solids = {free_ball("ball", {0, 0, 0.1}, 0.1, 1)};
  pressed.constraints = {over_floor("ball", 0.1, 0, 0.5)};
  pressed.efforts = {{"press", Force{{"ball", {0, 0, 0}}, {0, 0, -20}, Axes::world, Polynomial{{1}}, {}}}};
  const Trajectory still = run(pressed, settings("moreau", 1, 1e-3));
  EXPECT_TRUE(still.certificate.trusted) << still.certificate.reason;
  EXPECT_NEAR(still.certificate.work_efforts, 0, 1e-12);

  Scene lift;
  lift.solids = {solid("lift", "world", {driven(slide("up", Vector3d::UnitZ()), Polynomial{{0, 1}})},
                       {inertial(1, {0, 0, 0}, {1, 1, 1})}),
                 free_ball("ball", {0, 0, 0.1}, 0.1, 2)};
  lift.solids[1].switches[2].v = {1};
  lift.constraints = {over_floor("ball", 0.1, 0, 0.5)};
  std::get<SphereOverPlane>(lift.constraints[0].kind).plane.on = {"lift", {0, 0, 0}};
  const Trajectory risen = run(lift, settings("moreau", 1, 1e-3));
  EXPECT_TRUE(risen.certificate.trusted) << risen.certificate.reason;
  EXPECT_NEAR(risen.certificate.work_drives, 3 * 9.81, 1e-6);  // both are raised by a metre

  // a block laid on a belt slips until both are equally fast: the belt's drive gives m v^2, half of it heat
  Scene belt;
  belt.solids = {solid("belt", "world", {driven(slide("along", Vector3d::UnitX()), Polynomial{{0, 1}})},
                       {inertial(1, {0, 0, 0}, {1, 1, 1})}),
                 solid("block", "world", {slide("x", Vector3d::UnitX()), slide("z", Vector3d::UnitZ(), 0.1)},
                       {inertial(2, {0, 0, 0}, {1, 1, 1})})};
  belt.constraints = {over_floor("block", 0.1, 0, 0.3)};
  std::get<SphereOverPlane>(belt.constraints[0].kind).plane.on = {"belt", {0, 0, 0}};
  const Trajectory carried = run(belt, settings("moreau", 1, 1e-4));
  EXPECT_TRUE(carried.certificate.trusted) << carried.certificate.reason;
  EXPECT_NEAR(carried.certificate.work_drives, 2, 1e-3);
  EXPECT_NEAR(carried.certificate.work_events, -1, 1e-3);
  EXPECT_NEAR(last(carried.q)[0], 1 - 0.5 / (0.3 * 9.81), 1e-3);
}

Scene human_over_floor() {
  auto model = read_model(source_folder() + "/tests/bench/human_floor.toml");
  EXPECT_TRUE(model);
  return model ? model->scene : Scene{};
}

class MoreauInRegisters : public EachWidth {};
INSTANTIATE_TEST_SUITE_P(OfEachWidth, MoreauInRegisters, ::testing::ValuesIn(all_widths()));

TEST_P(MoreauInRegisters, HumanFallsOntoTheFloor) {
  const System system = compiled(human_over_floor());
  for (const double higher : {0., 0.001, 0.002}) {  // each ends in another pose
    State start = system.initial;
    start.q[2] += higher;
    const auto ran = simulate(system, start, settings("moreau", 5, 2e-3));
    ASSERT_TRUE(ran) << ran.error().message();
    const Trajectory& path = *ran;
    const Certificate& c = path.certificate;
    EXPECT_TRUE(c.trusted) << c.reason;
    for (const ConstraintResidual& residual : c.residuals)
      EXPECT_LT(residual.position, 1e-3) << residual.constraint;
    EXPECT_GT(c.impacts, 20);
    // the floor never adds energy: any gain is the balance's error
    double least = path.kinetic[0] + path.potential[0];
    for (std::size_t i = 1; i < path.times.size(); ++i) {
      const double now = path.kinetic[i] + path.potential[i];
      EXPECT_LT(now, least + 2 * c.energy_drift + c.work_projection_size) << path.times[i];
      least = std::min(least, now);
    }
    EXPECT_LT(c.energy_drift, 1e-2 * c.energy_turnover);
    EXPECT_LT(c.work_projection_size, 1e-2 * c.energy_turnover);
  }
}

TEST(Moreau, LongStepsOfAFallingHumanAreRarelySubdivided) {
  const System system = compiled(human_over_floor());
  for (const double step : {5e-3, 1e-2})
    for (const double higher : {0., 0.001, 0.002}) {
      State start = system.initial;
      start.q[2] += higher;
      const Trajectory path = need(simulate(system, start, settings("moreau", 5, step)));
      const Certificate& c = path.certificate;
      EXPECT_TRUE(c.trusted) << step << ' ' << c.reason;
      EXPECT_LT(c.energy_drift, 1e-2 * c.energy_turnover);
      EXPECT_LT(c.work_projection_size, 1e-2 * c.energy_turnover);
      for (const ConstraintResidual& residual : c.residuals)
        EXPECT_LT(residual.position, 1e-3) << residual.constraint;
      EXPECT_GT(c.steps_rejected, 0);
      EXPECT_LT(c.steps_accepted + c.steps_rejected, 1.5 * 5 / step);
      EXPECT_GE(c.smallest_step, step / 64 * (1 - 1e-9));
      EXPECT_LT(c.smallest_step, step / 2 * (1 + 1e-9));
    }
}

/// Feet on legs swing into each other. Being nearly parallel, they are nearest at one end, and after
/// separation there at the other end.
Scene swinging_feet(Random& random) {
  Scene scene = human_over_floor();
  std::erase_if(scene.solids, [](const Solid& solid) {
    return !solid.name.starts_with("thigh") && !solid.name.starts_with("shank") &&
           !solid.name.starts_with("foot");
  });
  CapsuleOverCapsule feet;
  feet.a = {"foot left", {0.05, 0, -0.045}};
  feet.b = {"foot right", {0.05, 0, -0.045}};
  feet.axis_a = feet.axis_b = Vector3d::UnitX();
  feet.length_a = feet.length_b = 0.2;
  feet.radii = {0.03, 0.03};
  scene.constraints = {{"foot over foot", feet}};
  for (Solid& solid : scene.solids) {
    if (!solid.name.starts_with("thigh")) continue;
    solid.parent = "world";
    const double out = solid.name.ends_with("left") ? -1 : 1;
    const auto about = [&](double angle, const Vector3d& axis) {
      return Eigen::AngleAxisd(angle + random.number(-0.1, 0.1), axis);
    };
    const Eigen::Quaterniond hip =
        about(out * 0.45, Vector3d::UnitX()) * about(-0.4, Vector3d::UnitY()) * about(0, Vector3d::UnitZ());
    solid.switches[1].q = {hip.w(), hip.x(), hip.y(), hip.z()};
  }
  return scene;
}

TEST(Moreau, CorrectsOverlapOfMovingFeet) {
  Random random(1);
  int met = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const Trajectory path = run(swinging_feet(random), settings("moreau", 1, 1e-2));
    met += path.certificate.impacts > 0;
    EXPECT_LT(path.certificate.residuals[0].position, 1e-3 * 0.26) << trial;  // a thousandth of a foot
  }
  EXPECT_GE(met, 150);
}

// Constraints on bodies that nothing else touches do not change the other bodies.
TEST(Moreau, UnrelatedConstraintsChangeNothing) {
  Random random(1);
  int in_parts = 0;
  for (int trial = 0; trial < 50; ++trial) {
    Scene scene = swinging_feet(random);
    PointSpring band;
    band.a = {"foot left", {0.1, 0, 0}};
    band.b = {"foot right", {0.1, 0, 0}};
    band.stiffness = 50;
    band.damping = 5;
    band.rest_length = 0.1;
    scene.efforts = {{"band", band}};
    const Trajectory alone = run(scene, settings("moreau", 1, 1e-2));
    for (const char* name : {"one", "other"})
      scene.solids.push_back(solid(name, "world", {slide(std::string(name) + ".x", Vector3d::UnitX())},
                                   {inertial(1, {0, 0, 0}, {1, 1, 1})}));
    scene.constraints.push_back(
        {"gear", CoordinateCoupling{{{"one.x"}, {"other.x"}}, {1, -1}, Polynomial{{0}}}});
    const Trajectory beside = run(scene, settings("moreau", 1, 1e-2));
    const Certificate &a = alone.certificate, &b = beside.certificate;
    EXPECT_EQ(b.trusted, a.trusted) << trial << ' ' << a.reason << ' ' << b.reason;
    EXPECT_EQ(b.steps_rejected, a.steps_rejected) << trial;
    // sums round differently, which a second of motion amplifies
    EXPECT_NEAR(b.work_efforts, a.work_efforts, 1e-9 * a.energy_turnover) << trial;
    EXPECT_NEAR(b.energy_drift, a.energy_drift, 1e-9 * a.energy_turnover) << trial;
    in_parts += a.steps_rejected > 0;
  }
  EXPECT_GE(in_parts, 40);
}

TEST(Moreau, HumanFallConvergesToTheEventRun) {
  // feet that land, slip and stick, knees that give way: before it falls so chaotically that nothing
  // converges
  const Scene scene = human_over_floor();
  const Trajectory reference = run(scene, settings("dop853", 0.5, 1e-3, 1e-7));
  const auto error = [&](double h) {
    SimulationSettings whole = settings("moreau", 0.5, h);
    whole.energy_threshold = 1;  // no step is made in parts
    const Trajectory path = run(scene, whole);
    return (last(path.gravity_centre) - last(reference.gravity_centre)).norm();
  };
  const double coarse = error(4e-3), fine = error(2.5e-4);
  EXPECT_LT(fine, coarse / 8);  // first order would give 16; impacts fall anywhere in a step
  EXPECT_LT(fine, 1e-3);
}

TEST(Moreau, RefusesOverlapAtTheStart) {
  Scene scene;
  scene.solids = {free_ball("ball", {0, 0, 0.09}, 0.1, 1)};
  scene.constraints = {over_floor("ball", 0.1, 0, 0)};
  const System system = compiled(scene);
  const auto out = simulate(system, system.initial, settings("moreau", 1, 1e-3));
  ASSERT_FALSE(out);
  EXPECT_NE(out.error().what.find("overlaps by 0.01 at the start"), std::string::npos) << out.error().what;
}

}  // namespace
}  // namespace borelli::test::moreau_test
