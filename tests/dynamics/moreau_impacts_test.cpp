// Impacts in Moreau's time stepping: fast bodies, more than one impact in a step, impacts without a solution, and
// bodies on a rod.
#include "dynamics/methods/moreau.hpp"

#include <cmath>

#include "moreau_scenes.hpp"

namespace borelli::test::moreau_test {
namespace {

// Newton's law along a line: a target that whole steps would pass is hit by parts of steps. Only the law's
// energy is lost, and the position of the impact is exact to one part.
TEST(Moreau, FastBallDoesNotPassThroughATarget) {
  const double step = 1e-2, radius = 0.02, mass = 0.5, other = 2;
  int in_parts = 0;
  for (const double e : {0., 0.5, 1.})
    for (const double speed : {10., 30., 60.})
      for (const double away : {1., 1.13, 1.57}) {
        Scene scene;
        scene.gravity.setZero();
        scene.solids = {free_ball("fast", {0, 0, 0}, radius, mass),
                        free_ball("still", {away, 0, 0}, radius, other)};
        scene.solids[0].switches[0].v = {speed};
        scene.constraints = {between("fast", "still", radius, e, 0)};
        const double end = 2 * away / speed, meets = (away - 2 * radius) / speed;
        const Trajectory path = run(scene, settings("moreau", end, step));
        EXPECT_TRUE(path.certificate.trusted) << path.certificate.reason;
        in_parts += path.certificate.steps_rejected > 0;
        const double common = mass * speed / (mass + other), after = common * (1 - e * other / mass),
                     driven = common * (1 + e);
        EXPECT_NEAR(last(path.v)[0], after, ContactSolver::settled * speed);
        EXPECT_NEAR(last(path.v)[6], driven, ContactSolver::settled * speed);
        // the path is straight before and after the impact, which is located within one part
        const double part = speed * path.certificate.smallest_step;
        EXPECT_NEAR(last(path.q)[0], speed * meets + after * (end - meets), 2 * part);
        EXPECT_NEAR(last(path.q)[7], away + driven * (end - meets), 2 * part);
      }
  EXPECT_GE(in_parts, 9);  // when the other ball lies in the first half of a step
}

// A ball that rebounds without loss keeps its energy for any step. The impact's time is known only to a step;
// the resulting change of energy, a gain or a loss, is bounded per step and in total.
TEST(Moreau, ElasticReboundsKeepEnergy) {
  for (const double height : {0.3, 0.5, 1., 2.})
    for (const double step : {2e-3, 5e-3, 1e-2, 2e-2})
      for (const double e : {1., 0.999}) {
        Scene scene;
        scene.solids = {free_ball("ball", {0, 0, 0.1 + height}, 0.1, 1)};
        scene.constraints = {over_floor("ball", 0.1, e, 0)};
        const Trajectory path = run(scene, settings("moreau", 10, step));
        EXPECT_TRUE(path.certificate.trusted) << path.certificate.reason;
        const auto end = path.times.size() - 1;
        const double kept = (path.kinetic[end] + path.potential[end] - 0.1 * 9.81) / (height * 9.81);
        EXPECT_NEAR(kept, std::pow(e, 2 * path.certificate.impacts), 1e-2) << height << ' ' << step;
        if (e < 1) continue;
        // the certificate reports the gain or loss
        const double told = path.certificate.contact_error + path.certificate.energy_drift;
        EXPECT_LE(std::abs(kept - 1) * height * 9.81, told + 1e-9) << height << ' ' << step;
        EXPECT_LT(told, 1e-2 * path.certificate.energy_turnover);
      }
}

// Between two walls: more than one impact in a whole step.
TEST(Moreau, BallBetweenTwoWallsHitsBothOrIsDistrusted) {
  for (const double room : {0.005, 0.02, 0.8})
    for (const double speed : {1., 3., 30., 200.}) {
      Scene scene;
      scene.gravity.setZero();
      scene.solids = {free_ball("ball", {0, 0, 0.1}, 0.1, 1)};
      scene.solids[0].switches[2].v = {speed};
      scene.constraints = {over_floor("ball", 0.1, 1, 0), over_floor("ball", 0.1, 1, 0)};
      scene.constraints[1].name = "ceiling";
      auto& above = std::get<SphereOverPlane>(scene.constraints[1].kind);
      above.plane.on = {"world", {0, 0, 0.2 + room}};
      above.plane.normal = {0, 0, -1};
      const Trajectory path = run(scene, settings("moreau", 0.5, 1e-2));
      const double flights = speed * 0.5 / room;  // number of flights between the walls
      if (path.certificate.trusted) {
        EXPECT_NEAR(double(path.certificate.impacts), flights, std::max(1.5, 0.1 * flights))
            << room << ' ' << speed;
      }
    }
}

// A lid presses a ball onto a floor: no step, however short, has a solution for the impulses. The run reports
// that and makes about twenty tries per step.
TEST(Moreau, UnsolvableStepsAreNamedAtBoundedCost) {
  Scene scene;
  scene.solids = {free_ball("ball", {0, 0, 0.1}, 0.1, 1),
                  solid("lid", "world", {driven(slide("down", Vector3d::UnitZ()), Polynomial{{0.25, -0.1}})},
                        {inertial(1, {0, 0, 0}, {1, 1, 1})})};
  scene.constraints = {over_floor("ball", 0.1, 0, 0), over_floor("ball", 0.1, 0, 0)};
  scene.constraints[1].name = "ball under lid";
  auto& above = std::get<SphereOverPlane>(scene.constraints[1].kind);
  above.plane.on = {"lid", {0, 0, 0}};
  above.plane.normal = {0, 0, -1};
  const System system = compiled(scene);
  const double step = 1e-2;
  const auto ran = simulate(system, system.initial, settings("moreau", 1, step));
  ASSERT_TRUE(ran) << ran.error().message();
  EXPECT_FALSE(ran->certificate.trusted);
  EXPECT_NE(ran->certificate.reason.find("did not converge at t = 0.5"), std::string::npos)
      << ran->certificate.reason;
  // the ball is jammed in half of all steps. Each of them costs 6 tries that are too long, four of the
  // smallest part with two tries of longer ones, and then ever longer parts
  EXPECT_LE(ran->certificate.steps_accepted + ran->certificate.steps_rejected, (0.5 + 0.5 * 20) / step);
}

// Two balls on a rod (given twice, so one row is dependent) land one after the other; reference: a run that
// locates the impacts.
TEST(Moreau, BallsOnARodLandAsInEventRuns) {
  for (const bool twice : {false, true}) {
    Scene scene;
    scene.solids = {free_ball("left", {0, 0, 0.3}, 0.1, 1), free_ball("right", {0.4, 0, 0.6}, 0.1, 2)};
    scene.constraints = {over_floor("left", 0.1, 0, 0.2), over_floor("right", 0.1, 0, 0.2)};
    Distance rod;
    rod.a = {"left", {0, 0, 0}};
    rod.b = {"right", {0, 0, 0}};
    rod.distance = Polynomial{{0.5}};
    scene.constraints.push_back({"rod", rod});
    if (twice) scene.constraints.push_back({"rod again", rod});
    const double end = 0.45;  // both have landed
    const Trajectory reference = run(scene, settings("dop853", end, 1e-3, 1e-9));
    EXPECT_EQ(reference.certificate.impacts, 2);
    const auto error = [&](double h) {
      const Trajectory path = run(scene, settings("moreau", end, h));
      EXPECT_TRUE(path.certificate.trusted) << path.certificate.reason;
      return (last(path.q) - last(reference.q)).cwiseAbs().maxCoeff();
    };
    const double coarse = error(4e-3), fine = error(2.5e-4);
    EXPECT_LT(fine, coarse / 4);  // first order would give 16; impacts fall anywhere in a step
    EXPECT_LT(fine, 1e-3);
  }
}

}  // namespace
}  // namespace borelli::test::moreau_test
