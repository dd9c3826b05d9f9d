// Runs with contacts, against closed forms: rebounds, rows of balls, rest, stick and slip, Painleve's rod.
#include "dynamics/run/contact_events.hpp"

#include "scenes.hpp"

namespace borelli::test::contact_events_test {
namespace {

constexpr double g = 9.81, degree_for_tests = 0.017453292519943295;

std::vector<LoggedEvent> events(const Trajectory& t, const std::string& kind) {
  std::vector<LoggedEvent> out;
  for (const LoggedEvent& e : t.certificate.events)
    if (e.kind == kind) out.push_back(e);
  return out;
}

double last(const Trajectory& t, int i) { return t.times.empty() ? NAN : t.q(t.q.rows() - 1, i); }
double last_velocity(const Trajectory& t, int i) { return t.times.empty() ? NAN : t.v(t.v.rows() - 1, i); }

template <class Kind>
Kind& kind_of(Scene& scene, int i = 0) {
  return std::get<Kind>(scene.constraints[i].kind);
}

TEST(ContactRuns, ReboundsEndAtTheLimitOfTheGeometricSeries) {
  for (const double e : {0.5, 0.8}) {
    Scene scene = sample("bouncing_ball.toml");
    kind_of<SphereOverPlane>(scene).surface.restitution = e;
    scene.simulation.end_time = 5;
    const Trajectory t = run(scene);
    const double fall = std::sqrt(2 / g), end = fall * (1 + e) / (1 - e);
    const auto impacts = events(t, "impact"), closed = events(t, "contact_closed");
    ASSERT_GT(impacts.size(), 15u);
    EXPECT_NEAR(impacts[0].time, fall, 1e-12);  // the path is a parabola, which the method has exactly
    EXPECT_NEAR(impacts[1].time, fall * (1 + 2 * e), 1e-11);
    EXPECT_NEAR(impacts[0].impulse, (1 + e) * std::sqrt(2 * g), 1e-11);
    EXPECT_NEAR(impacts[0].energy_lost, g * (1 - e * e), 1e-11);
    ASSERT_EQ(closed.size(), 1u);
    // time left when the rest speed of 3e-7 m/s is reached: at most 2 v / g / (1 - e) = 3e-7 s
    EXPECT_NEAR(closed[0].time, end, 3.1e-7);
    EXPECT_NEAR(last(t, 0), 0.1, 1e-12);
    EXPECT_NEAR(t.certificate.impact_loss, g, 1e-9);
    EXPECT_EQ(t.contact_modes(t.contact_modes.rows() - 1, 0), 1);
    EXPECT_NEAR(t.contact_forces(t.contact_forces.rows() - 1, 0), g, 1e-11);
    EXPECT_EQ(t.certificate.impacts, long(impacts.size()));
  }
}

TEST(ContactRuns, OutputRowsBeforeAnImpactAreUnaffectedByIt) {
  Scene scene = sample("bouncing_ball.toml");
  kind_of<SphereOverPlane>(scene).surface.restitution = 0;  // after landing, the ground holds the ball
  scene.simulation.output_interval = 0.05;
  scene.simulation.end_time = 1;
  const Trajectory t = run(scene);
  ASSERT_EQ(t.times.size(), 21u);
  for (std::size_t i = 0; i < t.times.size(); ++i) {
    const double fallen = 0.5 * g * t.times[i] * t.times[i];
    EXPECT_NEAR(t.q(Eigen::Index(i), 0), std::max(1.1 - fallen, 0.1), 1e-11) << t.times[i];
    EXPECT_EQ(t.contact_modes(Eigen::Index(i), 0), fallen > 1);
  }
}

TEST(ContactRuns, OpenContactCostsNoEvaluations) {
  Scene scene = sample("bouncing_ball.toml");
  scene.simulation.end_time = 0.2;  // it lands after 0.4515 s
  for (const char* method : {"dopri5", "dop853", "rk4", "gbs", "gauss16"}) {
    scene.simulation.method = method;
    Scene alone = scene;
    alone.constraints.clear();
    const Trajectory with = run(scene), without = run(alone);
    EXPECT_LE(with.certificate.evaluations, without.certificate.evaluations + 1) << method;  // at its start
    EXPECT_EQ(with.q, without.q) << method;
  }
}

// A mass on a spring, x = cos t, hits a post on its way and is thrown back. A step may span half a swing,
// with the mass at rest at both ends.
TEST(ContactRuns, LongStepDoesNotPassOverAPost) {
  Scene scene;
  scene.gravity.setZero();
  scene.solids = {
      solid("mass", "world", {slide("x", Vector3d::UnitX(), 1)}, {inertial(1, {0, 0, 0}, {0, 0, 0})})};
  scene.efforts = {{"spring", CoordinateSpring{{"x"}, 1, 0, 0}}};
  SphereOverSphere post;
  post.a = {"mass", {0, 0, 0}};
  post.b = {"world", {-0.3, 0.105, 0}};
  post.radii = {0.1, 0.01};
  post.surface.restitution = 1;
  scene.constraints = {{"post", post}};
  const double first = std::acos(-0.3 + std::sqrt(0.11 * 0.11 - 0.105 * 0.105)), end = 40;
  for (const char* method : {"gauss16", "gbs", "dop853"})
    for (int k = 0; k <= 16; ++k) {
      const double tolerance = std::pow(10, -4 - 0.5 * k);
      const Trajectory out = run(scene, settings(method, end, 1e-3, tolerance));
      const auto impacts = events(out, "impact");
      ASSERT_EQ(impacts.size(), std::size_t((end / first + 1) / 2)) << method << ", " << tolerance;
      for (std::size_t i = 0; i < impacts.size(); ++i)
        // one tolerance per step at most; it flies past the post at about 1 m/s
        EXPECT_NEAR(impacts[i].time, (2 * double(i) + 1) * first,
                    double(out.certificate.steps_accepted) * tolerance)
            << method << ", " << tolerance;
    }
}

TEST(ContactRuns, NewtonsCradlePassesItsSpeedOn) {
  Scene scene = sample("cradle.toml");
  scene.simulation.end_time = 0.6;  // the first ball arrives after a quarter of 2.01 s
  for (const auto law : {ImpactLaw::sequential, ImpactLaw::simultaneous}) {
    scene.simulation.impacts = law;
    const Trajectory t = run(scene);
    const auto impacts = events(t, "impact");
    ASSERT_EQ(impacts.size(), 4u);
    // a quarter of the pendulum's period, 4 K(sin 0.1) / sqrt g
    EXPECT_NEAR(impacts[0].time, std::comp_ellint_1(std::sin(0.1)) / std::sqrt(g), 1e-9);
    Eigen::Index row = 0;
    while (t.times[static_cast<std::size_t>(row)] < impacts[0].time) ++row;
    const double speed = 2 * std::sqrt(g) * std::sin(0.1);
    const double parted[] = {-0.6, 0.4, 0.4, 0.4, 0.4};
    for (int i = 0; i < 5; ++i) {
      const double share = law == ImpactLaw::sequential ? i == 4 : parted[i];
      // swings to the one side are turns about -y; located to 1e-12 s, integrated at 1e-10 a step
      EXPECT_NEAR(std::abs(t.v(row, i)), std::abs(share) * speed, 1e-8) << i;
    }
    EXPECT_NEAR(t.certificate.impact_loss, 0, 1e-10);
  }
}

TEST(ContactRuns, NewtonsCradleSwingsBack) {
  const Trajectory t = run(sample("cradle.toml"));
  // 0, 0, 0, 0, 1 and back again: after a whole period, at 4 of the 4.03 s of two, the first ball nears its
  // start
  EXPECT_GT(std::abs(last(t, 0)), 0.19);
  for (int i = 1; i < 5; ++i) EXPECT_NEAR(last(t, i), 0, 1e-8);
}

TEST(ContactRuns, BlockThrownUpASlopeStopsAndSlidesBack) {
  Scene scene = sample("block_on_slope.toml");
  const double a = 30 * degree_for_tests, mu = 0.4;
  const Trajectory t = run(scene);
  const double down = g * (std::sin(a) + mu * std::cos(a)), back = g * (std::sin(a) - mu * std::cos(a));
  const double stop = 2 / down, after = scene.simulation.end_time - stop;
  EXPECT_NEAR(last(t, 0), 2 / down - 0.5 * back * after * after, 1e-8);
  EXPECT_NEAR(last_velocity(t, 0), -back * after, 1e-8);
  // its corners begin to slide at the start and again where it turns
  const auto slips = events(t, "slip");
  ASSERT_EQ(slips.size(), 8u);
  for (std::size_t i = 0; i < 8; ++i) EXPECT_NEAR(slips[i].time, i < 4 ? 0 : stop, 1e-8);
}

TEST(ContactRuns, BlockSticksBelowTheFrictionAngle) {
  for (const double factor : {1.01, 1.2}) {
    Scene scene = sample("block_on_slope.toml");
    scene.solids[1].switches[0].v = {0};
    kind_of<BoxOverPlane>(scene).surface.friction = factor * std::tan(30 * degree_for_tests);
    const Trajectory t = run(scene);
    EXPECT_NEAR(last(t, 0), 0, 1e-10);
    EXPECT_NEAR(last_velocity(t, 0), 0, 1e-10);
  }
  Scene scene = sample("block_on_slope.toml");
  scene.solids[1].switches[0].v = {0};
  const double mu = 0.9 * std::tan(30 * degree_for_tests), a = 30 * degree_for_tests;
  kind_of<BoxOverPlane>(scene).surface.friction = mu;
  const Trajectory t = run(scene);
  EXPECT_NEAR(last_velocity(t, 0), -g * (std::sin(a) - mu * std::cos(a)), 1e-8);
}

TEST(ContactRuns, PointSticksUpToTheFrictionLimit) {
  // tan 30 degrees is the limit itself: it sticks; a millionth below it slides with g (sin a - mu cos a)
  const double a = 30 * degree_for_tests;
  for (const double factor : {1.0, 1 - 1e-6}) {
    Scene scene = sample("block_on_slope.toml");
    scene.solids[1].switches = {slide("up", Vector3d::UnitX()), slide("across", Vector3d::UnitY()),
                                slide("off", Vector3d::UnitZ())};
    SphereOverPlane slope;
    slope.sphere.solid = "block";
    slope.plane.on.solid = "slope";
    slope.surface.friction = factor * std::tan(a);
    scene.constraints = {{"slope", slope}};
    const Trajectory t = run(scene);
    const double down = factor == 1 ? 0 : g * (std::sin(a) - slope.surface.friction * std::cos(a));
    EXPECT_NEAR(last_velocity(t, 0), -down, 1e-12);
    EXPECT_EQ(t.contact_modes(t.contact_modes.rows() - 1, 0), factor == 1 ? 2 : 1);
  }
}

TEST(ContactRuns, NamesPainlevesParadox) {
  const auto out = compile(sample("painleve_rod.toml")).and_then([](const System& s) { return simulate(s); });
  ASSERT_FALSE(out);
  EXPECT_EQ(out.error().where, "contact 'tip'");
  EXPECT_NE(out.error().what.find("no contact force solves the equations"), std::string::npos);
  EXPECT_NE(out.error().what.find("t = 0 s"), std::string::npos);
  Scene scene = sample("painleve_rod.toml");
  kind_of<SphereOverPlane>(scene).surface.friction = 0.5;  // below 4/3 there is no such case
  scene.simulation.end_time = 0.1;
  run(scene);
}

TEST(ContactRuns, FallingBoxLandsFlatAndRests) {
  Scene scene;
  scene.name = "box";
  Solid box = solid("box", "world", free_switches("box"), {inertial(2, {0, 0, 0}, {0.1, 0.2, 0.3})});
  box.switches[2].q = {1};
  scene.solids = {box};
  BoxOverPlane ground;
  ground.box.solid = "box";
  ground.size = {1, 0.6, 0.4};
  ground.surface.friction = 0.5;
  ground.surface.restitution = 0.3;
  scene.constraints = {{"ground", ground}};
  scene.simulation = {.end_time = 2, .method = "dopri5", .step = 1e-3, .tolerance = 1e-9};
  const Trajectory t = run(scene);
  EXPECT_NEAR(last(t, 2), 0.2, 1e-10);
  const Eigen::Index end = t.contact_forces.rows() - 1;
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(t.contact_forces(end, k), 2 * g / 4, 1e-8) << k;
  for (int k = 4; k < 8; ++k) EXPECT_EQ(t.contact_modes(end, k), 0);
  EXPECT_NEAR(t.certificate.impact_loss, 2 * g * 0.8, 1e-8);  // it stays flat, so friction does no work
}

TEST(ContactRuns, ContactOpensWhenItsForceVanishes) {
  // a point on a ground that is driven up and down faster than it can fall: it leaves where a omega^2 sin = g
  Scene scene;
  scene.name = "shaken";
  const double amplitude = 0.1, frequency = 12;
  scene.solids = {solid("table", "world",
                        {driven(slide("shake", Vector3d::UnitZ()), Sine{amplitude, frequency, 0, 0})}, {}),
                  solid("grain", "world", {slide("height", Vector3d::UnitZ(), 0, amplitude * frequency)},
                        {inertial(1, {0, 0, 0}, {0, 0, 0})})};
  SphereOverPlane ground;
  ground.sphere.solid = "grain";
  ground.plane.on.solid = "table";
  scene.constraints = {{"ground", ground}};
  scene.simulation = {.end_time = 0.3, .method = "dop853", .step = 1e-3, .tolerance = 1e-11};
  const Trajectory t = run(scene);
  const auto opened = events(t, "contact_opened");
  ASSERT_EQ(opened.size(), 1u);
  const double leave = std::asin(g / (amplitude * frequency * frequency)) / frequency;
  EXPECT_NEAR(opened[0].time, leave, 1e-9);
  const double after = 0.3 - leave;
  EXPECT_NEAR(last(t, 0),
              amplitude * std::sin(frequency * leave) +
                  amplitude * frequency * std::cos(frequency * leave) * after - 0.5 * g * after * after,
              1e-8);
}

TEST(ContactRuns, LimitReboundsACoordinate) {
  Scene scene;
  scene.name = "stop";
  scene.gravity.setZero();
  scene.solids = {
      solid("slider", "world", {slide("x", Vector3d::UnitX(), 0, 1)}, {inertial(1, {0, 0, 0}, {0, 0, 0})})};
  scene.constraints = {{"stops", Limit{{"x"}, -0.5, 0.25, 0.5}}};
  scene.simulation = {.end_time = 2, .method = "rk4", .step = 0.01};
  const Trajectory t = run(scene);
  // there at 0.25 s, back with half the speed: at -0.5 m after 1.5 s, then 0.25 m/s for the rest
  EXPECT_NEAR(last(t, 0), -0.5 + 0.25 * 0.25, 1e-12);
  EXPECT_EQ(events(t, "impact").size(), 2u);
}

TEST(ContactRuns, TautRopeBecomesAPendulum) {
  Scene scene;
  scene.name = "rope";
  scene.solids = {solid("bob", "world",
                        {slide("x", Vector3d::UnitX(), 0.6), slide("z", Vector3d::UnitZ(), 0)},
                        {inertial(1, {0, 0, 0}, {0, 0, 0})})};
  scene.constraints = {{"rope", Rope{{"bob", {0, 0, 0}}, {"world", {0, 0, 0}}, 1}}};
  scene.simulation = {.end_time = 2, .method = "dop853", .step = 1e-3, .tolerance = 1e-11};
  const Trajectory t = run(scene);
  const auto impacts = events(t, "impact");
  ASSERT_EQ(impacts.size(), 1u);
  // falls 0.8 m, then the rope stops the velocity along itself, 0.8 of the speed
  EXPECT_NEAR(impacts[0].time, std::sqrt(2 * 0.8 / g), 1e-10);
  EXPECT_NEAR(impacts[0].energy_lost, 0.64 * g * 0.8, 1e-9);
  for (Eigen::Index i = 0; i < t.q.rows(); ++i) EXPECT_LT(t.q.row(i).norm(), 1 + 1e-9);
}

/// A solid sphere of 1 kg on the ground, or on a slope that rises along x.
Scene billiard(double slope, double friction) {
  Scene scene;
  scene.name = "billiard";
  const double radius = 0.1, moment = 0.4 * radius * radius;
  Solid ball =
      solid("ball", "world", free_switches("ball"), {inertial(1, {0, 0, 0}, {moment, moment, moment})});
  ball.switches[2].q = {radius};
  scene.solids = {ball};
  scene.gravity = g * Vector3d(-std::sin(slope), 0, -std::cos(slope));
  SphereOverPlane ground;
  ground.sphere.solid = "ball";
  ground.radius = radius;
  ground.surface.friction = friction;
  scene.constraints = {{"ground", ground}};
  scene.simulation = {.end_time = 1, .method = "dopri5", .step = 1e-3, .tolerance = 1e-10};
  return scene;
}

TEST(ContactRuns, SlidingBallRollsAtFiveSeventhsOfItsSpeed) {
  Scene scene = billiard(0, 0.3);
  scene.solids[0].switches[0].v = {2};
  scene.solids[0].switches[1].v = {1};
  const Trajectory t = run(scene);
  const double speed = std::sqrt(5.);
  const auto stuck = events(t, "stick");
  ASSERT_EQ(stuck.size(), 1u);
  // mu g t = 2/7 v
  EXPECT_NEAR(stuck[0].time, 2 * speed / (7 * 0.3 * g), 1e-8);
  EXPECT_NEAR(last_velocity(t, 0), 2 * 5. / 7, 1e-8);
  EXPECT_NEAR(last_velocity(t, 1), 1 * 5. / 7, 1e-8);
  // friction's work: 2/7 of the energy
  EXPECT_NEAR(t.certificate.work_efforts, -0.5 * 5 * 2 / 7, 1e-8);
}

TEST(ContactRuns, BallRollsDownASlopeWithFiveSeventhsOfGravity) {
  const Trajectory t = run(billiard(0.3, 0.5));
  EXPECT_NEAR(last_velocity(t, 0), -5. / 7 * g * std::sin(0.3), 1e-9);
  // steeper than 7/2 of its friction it slides too: mu g cos a less
  const double steep = 1.2, mu = 0.3;
  const Trajectory slides = run(billiard(steep, mu));
  EXPECT_NEAR(last_velocity(slides, 0), -g * (std::sin(steep) - mu * std::cos(steep)), 1e-9);
}

TEST(ContactRuns, CollidingFreeBallsKeepTheirMomentum) {
  Scene scene;
  scene.name = "billiard balls";
  scene.gravity.setZero();
  for (const char* name : {"a", "b"}) {
    const double mass = name[0] == 'a' ? 1 : 2, moment = 0.004 * mass;
    scene.solids.push_back(
        solid(name, "world", free_switches(name), {inertial(mass, {0, 0, 0}, {moment, moment, moment})}));
  }
  scene.solids[0].switches[0].v = {3};
  scene.solids[1].switches[0].q = {1};
  scene.solids[1].switches[1].q = {0.08};
  SphereOverSphere meet;
  meet.a.solid = "a";
  meet.b.solid = "b";
  meet.surface.restitution = 0.7;
  meet.surface.friction = 0.4;
  scene.constraints = {{"balls", meet}};
  scene.simulation = {.end_time = 1, .method = "dopri5", .step = 1e-3, .tolerance = 1e-10};
  const Trajectory t = run(scene);
  ASSERT_EQ(events(t, "impact").size(), 1u);
  const Eigen::Index end = t.v.rows() - 1;
  const auto row = t.v.row(end);
  EXPECT_NEAR(row[0] + 2 * row[6], 3, 1e-12);
  EXPECT_NEAR(row[1] + 2 * row[7], 0, 1e-12);
  // along the line of centres they part with 0.7 of the speed at which they met: 3 cos, with sin = 0.08 / 0.2
  const double sine = 0.4, cosine = std::sqrt(1 - sine * sine);
  EXPECT_NEAR((row[6] - row[0]) * cosine + (row[7] - row[1]) * sine, 0.7 * 3 * cosine, 1e-11);
  EXPECT_GT(t.certificate.impact_loss, 0);
  EXPECT_NEAR(t.certificate.impact_loss, 4.5 - t.kinetic.back(), 1e-10);
  // the certificate checks both momenta, across the impact too, whose friction spins the balls
  ASSERT_EQ(t.certificate.conserved.size(), 2u);
  for (const Conserved& c : t.certificate.conserved) {
    EXPECT_GT(c.scale, 0.1) << c.name;
    EXPECT_LT(c.drift, 1e-12 * std::max(1., c.scale)) << c.name;
  }
  EXPECT_GT(std::abs(row[5]), 0.1);
}

TEST(ContactRuns, ContactsWorkWithBaumgarte) {
  // sliding, sticking and rolling again, with Baumgarte instead of projection: gains of 10 / s remove the
  // error of an event's location, 1e-12 m
  Scene slope = sample("block_on_slope.toml");
  slope.simulation.constraints = ConstraintTreatment::baumgarte;
  const double a = 30 * degree_for_tests, mu = 0.4;
  const double down = g * (std::sin(a) + mu * std::cos(a)), back = g * (std::sin(a) - mu * std::cos(a));
  const double after = slope.simulation.end_time - 2 / down;
  const Trajectory slid = run(slope);
  EXPECT_NEAR(last(slid, 0), 2 / down - 0.5 * back * after * after, 1e-8);
  EXPECT_NEAR(last_velocity(slid, 0), -back * after, 1e-8);

  Scene rolls = billiard(0, 0.3);
  rolls.solids[0].switches[0].v = {2};
  rolls.simulation.constraints = ConstraintTreatment::baumgarte;
  const Trajectory rolled = run(rolls);
  EXPECT_NEAR(last_velocity(rolled, 0), 2 * 5. / 7, 1e-8);
  EXPECT_EQ(events(rolled, "stick").size(), 1u);

  Scene bounces = sample("bouncing_ball.toml");
  bounces.simulation.constraints = ConstraintTreatment::baumgarte;
  const Trajectory rests = run(bounces);
  EXPECT_NEAR(last(rests, 0), 0.1, 1e-9);
  EXPECT_NEAR(rests.certificate.impact_loss, g, 1e-9);
}

TEST(ContactRuns, BoxOnFourCornersSlidesAboveTheFrictionAngle) {
  // pushed with 4 N/s: it slides from mu m g on, by (F(t) - mu m g) / m
  for (double friction : {0.2, 0.4, 0.6})
    for (const char* method : {"dopri5", "dop853"}) {
      SCOPED_TRACE(fmt::format("{} at {}", method, friction));
      Scene scene;
      scene.solids = {solid("box", "world", free_switches("box"),
                            {inertial(1, {0, 0, 0}, {0.1 / 12, 0.17 / 12, 0.25 / 12})})};
      scene.solids[0].switches[2].q = {0.05};
      BoxOverPlane meet;
      meet.box = {"box", {0, 0, 0}};
      meet.size = {0.4, 0.3, 0.1};
      meet.plane.on = {"world", {0, 0, 0}};
      meet.surface.friction = friction;
      scene.constraints = {{"ground", meet}};
      scene.efforts = {{"push", Force{{"box", {0, 0, 0}}, {1, 0, 0}, Axes::world, Polynomial{{0, 4}}, {}}}};
      const Trajectory path = run(scene, settings(method, 2, 1e-3, 1e-9));
      EXPECT_TRUE(path.certificate.trusted) << path.certificate.reason;
      const double begins = friction * g / 4, slid = 2 - begins;
      EXPECT_NEAR(last(path, 0), 4 * slid * slid * slid / 6, 1e-7);
      ASSERT_EQ(events(path, "slip").size(), 4u);
      EXPECT_NEAR(events(path, "slip")[0].time, begins, 1e-7);
    }
}

TEST(ContactRuns, BoxNearTheFrictionLimitStaysOrCreeps) {
  const double angle = std::atan(0.4);
  for (double beside : {-1e-2, -1e-3, -1e-4, 0., 1e-6, 1e-4, 1e-2}) {
    SCOPED_TRACE(beside);
    Scene scene = sample("block_on_slope.toml");
    scene.solids[0].switches[0] = fixed({0, 0, 0}, Eigen::AngleAxisd(-angle, Vector3d::UnitY()).matrix());
    scene.solids[1].switches[0].v = {0};
    scene.simulation.end_time = 0.5;
    std::get<BoxOverPlane>(scene.constraints[0].kind).surface.friction = 0.4 * (1 + beside);
    const Trajectory path = run(scene);
    EXPECT_TRUE(path.certificate.trusted) << path.certificate.reason;
    const double down = std::max(0., -beside) * g * std::sin(angle);
    EXPECT_NEAR(last(path, 0), -0.5 * down * 0.25, 1e-9);
  }
}

TEST(ContactRuns, NamesBodiesDrivenTogether) {
  Scene scene;
  scene.solids = {
      solid("driven", "world", {driven(slide("z", Vector3d::UnitZ()), Polynomial{{1, -1}})},
            {inertial(1, {0, 0, 0}, {1, 1, 1})}),
      solid("free", "world", {slide("x", Vector3d::UnitX(), 0, 1)}, {inertial(1, {0, 0, 0}, {1, 1, 1})})};
  SphereOverPlane meet;
  meet.sphere = {"driven", {0, 0, 0}};
  meet.radius = 0.1;
  meet.plane.on = {"world", {0, 0, 0}};
  scene.constraints = {{"ground", meet}};
  const System system = compiled(scene);
  const auto out = simulate(system, system.initial, settings("dopri5", 2, 1e-2, 1e-8));
  ASSERT_FALSE(out);
  EXPECT_EQ(out.error().where, "contact 'ground'");
  EXPECT_NE(out.error().what.find("closes at t = 0.9 s at 1 per second, and no impulse can stop it"),
            std::string::npos)
      << out.error().what;
}

TEST(ContactRuns, NamesAnOverlapAtTheStart) {
  Scene scene = sample("bouncing_ball.toml");
  scene.solids[0].switches[0].q = {0.05};
  const auto out = compile(scene).and_then([](const System& s) { return simulate(s); });
  ASSERT_FALSE(out);
  EXPECT_EQ(out.error().where, "contact 'ground'");
  EXPECT_NE(out.error().what.find("overlaps by 0.05"), std::string::npos);
}

}  // namespace
}  // namespace borelli::test::contact_events_test
