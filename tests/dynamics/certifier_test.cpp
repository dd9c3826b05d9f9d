// The certificate's verdict: an untrusted run names the reason, the time and the culprit.
#include "dynamics/run/certifier.hpp"

#include <tuple>

#include "dynamics/formats/scene_file.hpp"
#include "scenes.hpp"

namespace borelli::test {
namespace {

Scene swinging_rod() {
  Scene scene;
  scene.solids = {solid("point", "world", {slide("x", Vector3d::UnitX(), -1), slide("z", Vector3d::UnitZ())},
                        {inertial(1, {0, 0, 0}, {0, 0, 0})})};
  scene.constraints = {{"rod", Distance{{"point", {0, 0, 0}}, {"world", {0, 0, 0}}, constant(1)}}};
  return scene;
}

TEST(Certificate, DriftOfAConstraintIsNamed) {
  SimulationSettings how = settings("rk4", 100, 0.01);
  how.constraints = ConstraintTreatment::baumgarte;
  how.baumgarte_alpha = how.baumgarte_beta = 0;  // nothing holds the point against drift
  const Certificate certificate = run(swinging_rod(), how).certificate;
  EXPECT_FALSE(certificate.trusted);  // though its energy balance is good to 1e-6
  EXPECT_NE(certificate.reason.find("constraint 'rod' is violated by"), std::string::npos)
      << certificate.reason;
  EXPECT_GT(certificate.residuals[0].position, 1e-3);
  EXPECT_GT(certificate.reason_time, 50);
}

TEST(Certificate, AccelerationResidualIsBaumgartesCorrection) {
  // a single row with beta alone: |L a + E| = beta^2 |h| at every state, so their largest values belong
  // together
  SimulationSettings how = settings("rk4", 10, 0.01);
  how.constraints = ConstraintTreatment::baumgarte;
  how.baumgarte_alpha = 0;
  how.baumgarte_beta = 3;
  const ConstraintResidual restored = run(swinging_rod(), how).certificate.residuals[0];
  EXPECT_GT(restored.position, 1e-9);
  EXPECT_NEAR(restored.acceleration, 9 * restored.position, 1e-12);  // rounding of accelerations of 20 m/s^2
  EXPECT_EQ(restored.acceleration_time, restored.position_time);
  how.constraints = ConstraintTreatment::projection;
  EXPECT_LT(run(swinging_rod(), how).certificate.residuals[0].acceleration, 1e-12);
}

TEST(Certificate, CountsTheWorkOfProjectionsSeparately) {
  // with steps too long, projection keeps the point on its circle but changes the energy
  const Certificate certificate = run(swinging_rod(), settings("rk2", 10, 0.02)).certificate;
  EXPECT_FALSE(certificate.trusted);
  EXPECT_GT(certificate.work_projection_size, 0.1);
  EXPECT_GE(certificate.work_projection_size, std::abs(certificate.work_projection));
  EXPECT_LT(certificate.residuals[0].position, 1e-12);
}

TEST(Certificate, UserSetsTheEnergyThreshold) {
  SimulationSettings how = settings("euler", 0.5, 0.01);
  EXPECT_FALSE(run(roundabout(), how).certificate.trusted);
  how.energy_threshold = 0.5;
  const Certificate lax = run(roundabout(), how).certificate;
  EXPECT_EQ(lax.energy_threshold, 0.5);
  EXPECT_TRUE(lax.trusted) << lax.reason;
  how = settings("rk4", 0.5, 0.01);
  how.energy_threshold = 1e-12;
  EXPECT_FALSE(run(roundabout(), how).certificate.trusted);
}

TEST(Certificate, ThresholdFollowsTheToleranceOfAnAdaptiveMethod) {
  EXPECT_DOUBLE_EQ(run(roundabout(), settings("rk4", 0.1, 0.01)).certificate.energy_threshold, 1e-3);
  EXPECT_DOUBLE_EQ(run(roundabout(), settings("rk4_adaptive", 0.1, 0.01, 1e-8)).certificate.energy_threshold,
                   1e-5);
  EXPECT_DOUBLE_EQ(run(roundabout(), settings("rk4_adaptive", 0.1, 0.01, 1e-14)).certificate.energy_threshold,
                   1e-9);
}

TEST(Certificate, MomentumDriftIsTheLargestSeen) {
  Scene scene;
  scene.gravity.setZero();
  const Vector3d moments(1, 1.2, 1.5);
  scene.solids = {solid("top", "world", {ball("turn", identity_quaternion(), {3, 0, 20})},
                        {inertial(1, {0, 0, 0}, moments)})};
  SimulationSettings how = settings("euler", 1, 0.01);
  how.output_interval = 0;
  const Trajectory path = run(scene, how);
  double drift = 0, scale = 0;
  const auto momentum = [&](std::size_t i) -> Vector3d {
    return path.pose(i, 0).R * moments.asDiagonal() * path.v.row(Eigen::Index(i)).transpose();
  };
  for (std::size_t i = 0; i < path.times.size(); ++i) {
    drift = std::max(drift, (momentum(i) - momentum(0)).norm());
    scale = std::max(scale, momentum(i).norm());
  }
  ASSERT_EQ(path.certificate.conserved.size(), 1u);
  EXPECT_NEAR(path.certificate.conserved[0].drift, drift, 1e-12 * scale);
  EXPECT_NEAR(path.certificate.conserved[0].scale, scale, 1e-12 * scale);
  EXPECT_FALSE(path.certificate.trusted);
}

TEST(Certificate, EnergyTurnoverCountsEnergyThatChangedForm) {
  // a bar let go level falls half a metre of its centre: 4.9 J from potential to kinetic
  Scene scene = chain(1, false, M_PI / 2);
  const Certificate certificate = run(scene, settings("rk4", 2, 0.01)).certificate;
  EXPECT_NEAR(certificate.energy_turnover, 9.81 * 0.5, 1e-3);
}

TEST(Certificate, RoundingCausesNoDistrust) {
  Random random(4);
  Scene falls;  // does not turn: its spin is rounding
  falls.solids = {solid("stone", "world", free_switches("stone"), {random.inertia().inertial()})};
  Scene stands = chain(1, false, M_PI);  // upside down, in balance: hardly any energy is turned over
  Scene rests = chain(3, true, 0);
  Scene held = chain(3, false, 0.5);  // folded in a zigzag that constraints keep at rest
  held.constraints = {{"tip", PointOnPoint{{"l2", {0, 0, -1}}, {"world", {1, 0, -1}}}},
                      {"first", CoordinateCoupling{{{"h0"}}, {1}, constant(0.5)}}};
  Scene empty;
  for (const Scene& scene : {falls, stands, rests, held, empty})
    for (const char* method : {"rk4", "rk4_adaptive"}) {
      const Certificate certificate = run(scene, settings(method, 1, 0.01, 1e-10)).certificate;
      EXPECT_TRUE(certificate.trusted) << scene.name << ", " << method << ": " << certificate.reason;
    }
}

// A ball at rest on a ball that is up to a million times lighter: z stays 0.5 m and 1.5 m.
TEST(Certificate, TrustsAStackAtRest) {
  for (const double mass : {1., 100., 1e4, 1e6})
    for (const char* method : {"moreau", "dop853", "gbs", "rk4", "verlet", "implicit_midpoint"}) {
      Scene scene = need(parse_scene(R"(
        [[solid]]
        name = "light"
        joint = {translation = "z", value = 0.5}
        shape = {kind = "sphere", radius = 0.5, mass = 1}
        [[solid]]
        name = "heavy"
        joint = {translation = "z", value = 1.5}
        shape = {kind = "sphere", radius = 0.5, mass = 1}
        [[constraint]]
        name = "floor"
        kind = "sphere_over_plane"
        sphere = "light"
        radius = 0.5
        plane = "world"
        normal = "z"
        [[constraint]]
        name = "pair"
        kind = "sphere_over_sphere"
        a = "light"
        b = "heavy"
        radius_a = 0.5
        radius_b = 0.5)",
                                     "stack.toml"));
      scene.solids[1].shapes[0].mass = mass;
      const Trajectory path = run(scene, settings(method, 2, 1e-2, 1e-9));
      EXPECT_TRUE(path.certificate.trusted) << mass << ", " << method << ": " << path.certificate.reason;
      EXPECT_LT((last(path.q) - Eigen::Vector2d(0.5, 1.5)).cwiseAbs().maxCoeff(), 1e-5) << mass << method;
    }
}

// Bricard's mechanism (IFToMM A04) has one redundant constraint row. Long extrapolation steps give the
// constraint work to 1e-6 J only, so the sum of kinetic and potential energy judges the motion.
TEST(Certificate, JudgesOverconstrainedLoopByKineticAndPotentialEnergy) {
  const std::string file = shared_folder() + "/cases/bricard.toml";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "needs " << file;
  const Trajectory path = need(simulate(compiled(need(read_scene(file)))));
  double drift = 0;
  for (std::size_t i = 0; i < path.times.size(); ++i)
    drift =
        std::max(drift, std::abs(path.kinetic[i] + path.potential[i] - path.kinetic[0] - path.potential[0]));
  const Certificate& c = path.certificate;
  EXPECT_TRUE(c.trusted) << c.reason;
  EXPECT_LT(drift, 1e-9);
  EXPECT_NEAR(c.energy_drift, drift, 1e-12);
  EXPECT_DOUBLE_EQ(c.energy_threshold, 1e-8);  // 1000 tolerances, as everywhere
}

// A balance without the constraint work still shows a loss of energy.
TEST(Certificate, DistrustsALoopThatLosesEnergy) {
  const std::string file = shared_folder() + "/cases/bricard.toml";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "needs " << file;
  const Certificate c = run(need(read_scene(file)), settings("euler", 2, 1e-2)).certificate;
  EXPECT_FALSE(c.trusted);
}

// ---- what reasons say ----

/// 1 kg on a slide under a force of F cos(w t): x = F (1 - cos w t) / w^2.
Scene shaken(double F, double w) {
  Scene scene;
  scene.gravity.setZero();
  scene.solids = {
      solid("mass", "world", {slide("x", Vector3d::UnitX())}, {inertial(1, {0, 0, 0}, {0, 0, 0})})};
  scene.efforts = {
      {"shaker", Force{{"mass", {0, 0, 0}}, {F, 0, 0}, Axes::world, Sine{1, w, M_PI / 2, 0}, {}}}};
  return scene;
}

TEST(Certificate, DistrustsMomentumLostInAnImpact) {
  // two balls that meet in free flight: their impact conserves momentum
  Scene scene;
  scene.gravity.setZero();
  for (const char* name : {"a", "b"})
    scene.solids.push_back(solid(name, "world", free_switches(name), {inertial(1, {0, 0, 0}, {1, 1, 1})}));
  scene.constraints = {{"meet", SphereOverSphere{{"a", {0, 0, 0}}, {"b", {0, 0, 0}}, {0.5, 0.5}, {}}}};
  scene.solids[0].switches[0].q = {-1};
  scene.solids[0].switches[0].v = {1};
  scene.solids[1].switches[0].q = {1};
  scene.solids[1].switches[0].v = {-2};
  const System system = compiled(scene);
  const Trajectory met = run(system, settings("dop853", 1, 0.01, 1e-9));
  EXPECT_EQ(met.certificate.impacts, 1);
  EXPECT_TRUE(met.certificate.trusted) << met.certificate.reason;
  ASSERT_EQ(met.certificate.conserved.size(), 2u);
  EXPECT_LT(met.certificate.conserved[0].drift, 1e-12);

  // the same impact by hand, once by the law of impact (they stop at -0.5 m/s) and once with a tenth of the
  // momentum lost
  for (const double lost : {0., 0.1}) {
    Workspace w(system);
    State state = system.initial;
    Certifier certifier(system, system.parameters, 1e-3, need(assemble(system, state)));
    const auto solve = [&] {
      ASSERT_FALSE(accelerate(system, system.parameters, state.t, state.q.data(), state.v.data(), {}, w));
    };
    solve();
    const Work work(system.groups);
    certifier.observe(state, w, work);
    const double energy = w.terms.kinetic;
    state.t = 0.25;
    state.v.setZero();
    state.v[0] = state.v[6] = -0.5 + lost / 2;
    solve();
    certifier.pass_event(w, false);
    Work after = work;
    after.add_event(Eigen::VectorXd::Constant(1, w.terms.kinetic - energy));
    certifier.observe(state, w, after);
    const Certificate c = certifier.finish(after, 0);
    EXPECT_EQ(c.trusted, lost == 0) << c.reason;
    if (lost > 0) {
      EXPECT_NE(c.reason.find("the linear momentum of 'a' has an error of 0.1 at t = 0.25 s"),
                std::string::npos)
          << c.reason;
    }
  }
}

TEST(Certificate, NamesBothContradictoryRows) {
  // one coordinate held to 0.1 t and to 0.1 t + t^3: they agree at the start
  Scene scene;
  scene.solids = {
      solid("mass", "world", {slide("x", Vector3d::UnitX())}, {inertial(1, {0, 0, 0}, {1, 1, 1})})};
  scene.constraints = {{"slow", CoordinateCoupling{{{"x"}}, {1}, Polynomial{{0, 0.1}}}},
                       {"fast", CoordinateCoupling{{{"x"}}, {1}, Polynomial{{0, 0.1, 0, 1}}}}};
  const System system = compiled(scene);
  for (const auto treatment : {ConstraintTreatment::projection, ConstraintTreatment::baumgarte}) {
    SimulationSettings how = settings("rk4", 1, 0.01);
    how.constraints = treatment;
    const Result<Trajectory> out = simulate(system, system.initial, how);
    if (out) {
      EXPECT_FALSE(out->certificate.trusted);
    }
    const std::string said = out ? out->certificate.reason : out.error().message();
    for (const char* part : {"'slow'", "'fast'", "t = ", "'mass'"})
      EXPECT_NE(said.find(part), std::string::npos) << part << ": " << said;
  }
  // no row is dependent at first: two rods whose anchors move apart beyond their reach
  Scene rods;
  rods.solids = {
      solid("point", "world", {slide("x", Vector3d::UnitX(), 0.5), slide("z", Vector3d::UnitZ(), -0.9)},
            {inertial(1, {0, 0, 0}, {0, 0, 0})}),
      solid("hook", "world", {driven(slide("ride", Vector3d::UnitX(), 0), Polynomial{{1, 1}})}, {})};
  rods.constraints = {{"left", Distance{{"point", {0, 0, 0}}, {"world", {0, 0, 0}}, constant(1)}},
                      {"right", Distance{{"point", {0, 0, 0}}, {"hook", {0, 0, 0}}, constant(1)}}};
  const System parting = compiled(rods);
  const Result<Trajectory> out = simulate(parting, parting.initial, settings("rk4", 3, 0.01));
  if (out) {
    EXPECT_FALSE(out->certificate.trusted);
  }
  const std::string said = out ? out->certificate.reason : out.error().message();
  for (const char* part : {"'left'", "'right'", "t = "})
    EXPECT_NE(said.find(part), std::string::npos) << part << ": " << said;
}

TEST(Certificate, EveryReasonNamesTimeAndSource) {
  SimulationSettings loose = settings("rk4", 100, 0.01);
  loose.constraints = ConstraintTreatment::baumgarte;
  loose.baumgarte_alpha = loose.baumgarte_beta = 0;
  SimulationSettings blind = settings("rk4", 1, 0.01);
  Scene top;
  top.gravity.setZero();
  top.solids = {solid("top", "world", {ball("turn", identity_quaternion(), {3, 0, 20})},
                      {inertial(1, {0, 0, 0}, {1, 1.2, 1.5})})};
  SimulationSettings lax = settings("euler", 1, 0.01);
  const std::vector<std::tuple<Scene, SimulationSettings, std::vector<std::string>>> cases = {
      {swinging_rod(), loose, {"row 'rod'", "between 'point' and 'world'"}},
      {swinging_rod(), settings("rk2", 10, 0.02), {"'point' and the solids tied to it"}},
      {roundabout(), settings("euler", 5, 0.01), {"'s1' and the solids tied to it", "exceeded at t = "}},
      {shaken(1, 200 * M_PI), blind, {"effort 'shaker'"}},
      {top, lax, {"'top'"}}};
  for (const auto& [scene, how, parts] : cases) {
    const Certificate c = run(scene, how).certificate;
    EXPECT_FALSE(c.trusted);
    EXPECT_FALSE(std::isnan(c.reason_time)) << c.reason;
    EXPECT_NE(c.reason.find("t = "), std::string::npos) << c.reason;
    for (const std::string& part : parts) EXPECT_NE(c.reason.find(part), std::string::npos) << c.reason;
  }
}

// ---- steps longer than the waves of prescribed functions ----

TEST(Certificate, DistrustsFixedStepsLongerThanASinesPeriod) {
  const double w = 200 * M_PI;  // one step is one period: the method sees a steady force
  const Trajectory over = run(shaken(1, w), settings("rk4", 1, 0.01));
  EXPECT_GT(std::abs(last(over.q)[0]), 0.1);  // wrong: the mass stays within 2 / w^2, some micrometres
  EXPECT_FALSE(over.certificate.trusted);
  EXPECT_NE(over.certificate.reason.find("effort 'shaker'"), std::string::npos) << over.certificate.reason;
  EXPECT_NE(over.certificate.reason.find("at most 0.00125 s"), std::string::npos) << over.certificate.reason;
  // 50 steps to a period leave rk4 an energy error of (0.16 / 0.8)^4 of the 14 % that 8 steps leave
  const Trajectory fine = run(shaken(1, w), settings("rk4", 1, 2e-4));
  EXPECT_TRUE(fine.certificate.trusted) << fine.certificate.reason;
}

// A force that is zero at every stage of one step of 128 s: those of the whole, half and quarter steps and of
// the Dormand-Prince pair.
TEST(Certificate, StepsResolvePolynomialAndTableWaves) {
  std::vector<double> product{1};
  for (const double zero : {0., 0.125, 0.2, 0.25, 0.3, 0.375, 0.5, 0.625, 0.75, 0.8, 0.875, 8. / 9, 1.}) {
    std::vector<double> next(product.size() + 1, 0);  // in parts of 128 s
    for (std::size_t i = 0; i < product.size(); ++i) {
      next[i] -= zero * product[i];
      next[i + 1] += product[i] / 128;
    }
    product = next;
  }
  for (double& c : product) c *= 1e6;
  std::vector<double> times, values;
  for (int i = 0; i <= 32; ++i) {
    times.push_back(4 * i);
    values.push_back(i % 4 == 2 ? 1 : 0);
  }
  for (const TimeFunction& f : std::vector<TimeFunction>{Polynomial{product}, Table(times, values)}) {
    Scene scene = shaken(1, 1);
    std::get<Force>(scene.efforts[0].kind).factor = f;
    const Trajectory fine = run(scene, settings("dop853", 128, 0.1, 1e-12));
    ASSERT_TRUE(fine.certificate.trusted) << fine.certificate.reason;
    const double end = last(fine.q)[0];
    EXPECT_GT(std::abs(end), 1);
    for (const char* method : {"rk4", "rk4_adaptive", "dopri5", "dop853", "gbs", "gauss16"}) {
      const Trajectory t = run(scene, settings(method, 128, 128));
      if (t.certificate.trusted) {
        EXPECT_NEAR(last(t.q)[0], end, 1e-4 * std::abs(end)) << method;
      } else {
        EXPECT_NE(t.certificate.reason.find("effort 'shaker', whose shortest wave"), std::string::npos)
            << t.certificate.reason;
      }
      EXPECT_EQ(t.certificate.trusted, std::string(method) != "rk4") << method;
    }
  }
}

TEST(Certificate, LimitsAdaptiveStepsToAnEighthOfASinesPeriod) {
  const double F = 1e4, w = 800 * M_PI, t = 1.00125;  // 0.01 s and its halves and quarters are whole periods
  const Trajectory path = run(shaken(F, w), settings("rk4_adaptive", t, 0.01));
  // x stays within 3 mm, 4 m/s; a tolerance of 1e-6 a step, whose errors wander through 400 periods
  EXPECT_NEAR(last(path.q)[0], F * (1 - std::cos(w * t)) / (w * w), 1e-4);
  EXPECT_TRUE(path.certificate.trusted) << path.certificate.reason;
  for (double h : path.step_sizes) EXPECT_LE(h, 2 * M_PI / w / 8 * (1 + 1e-12));
  ASSERT_EQ(path.certificate.notes.size(), 1u);
  EXPECT_NE(path.certificate.notes[0].find("an eighth of the period of effort 'shaker'"), std::string::npos);
}

TEST(Certificate, SinesOfDrivesAndConstraintsLimitStepsToo) {
  Scene drive = shaken(0, 1);
  drive.efforts.clear();
  drive.solids[0].switches.insert(drive.solids[0].switches.begin(),
                                  driven(slide("pump", Vector3d::UnitY()), Sine{0.01, 200 * M_PI, 0, 0}));
  Scene constraint = shaken(0, 1);
  constraint.efforts.clear();
  constraint.constraints = {{"cam", CoordinateCoupling{{{"x"}}, {1}, Sine{0.01, 200 * M_PI, 0, 0}}}};
  for (const auto& [scene, name] : {std::pair(drive, "'pump'"), std::pair(constraint, "'cam'")}) {
    const Certificate certificate = run(scene, settings("rk4", 1, 0.01)).certificate;
    EXPECT_FALSE(certificate.trusted) << name;
    EXPECT_NE(certificate.reason.find("cannot follow"), std::string::npos) << certificate.reason;
    EXPECT_NE(certificate.reason.find(name), std::string::npos) << certificate.reason;
  }
}

// ---- changes by assembly ----

TEST(Certificate, NotesWhatAssemblyMoved) {
  Scene scene;  // a wall at x = 2 for a mass that is to start at 0 with 5 m/s
  scene.solids = {solid("a", "world", {slide("x", Vector3d::UnitX(), 0, 5), slide("z", Vector3d::UnitZ())},
                        {inertial(1, {0, 0, 0}, {0, 0, 0})})};
  scene.constraints = {
      {"wall", PointOnPlane{{"a", {0, 0, 0}}, {{"world", {2, 0, 0}}, {1, 0, 0}}, constant(0)}}};
  const Certificate moved = run(scene, settings("rk4_adaptive", 0.1, 0.01)).certificate;
  EXPECT_NEAR(moved.assembly_position, 2, 1e-12);
  EXPECT_EQ(moved.assembly_position_coordinate, "x");
  EXPECT_NEAR(moved.assembly_velocity, 5, 1e-12);
  EXPECT_EQ(moved.assembly_velocity_coordinate, "x");
  ASSERT_EQ(moved.notes.size(), 2u);
  EXPECT_NE(moved.notes[0].find("initial positions, most of all coordinate 'x', by 2 m"), std::string::npos);
  EXPECT_NE(moved.notes[1].find("initial velocities, most of all coordinate 'x', by 5 m/s"),
            std::string::npos);
  EXPECT_TRUE(run(swinging_rod(), settings("rk4", 0.1, 0.001)).certificate.notes.empty());
}

TEST(Certificate, DistantSolidLoosensNoLimit) {
  // a solid welded to the world, and one that moves on its own, five kilometres away
  const auto with_far = [](Scene scene) {
    const Inertial block = inertial(1, {0, 0, 0}, {1, 1, 1});
    scene.solids.push_back(solid("tower", "world", {fixed({5000, 0, 0})}, {block}));
    scene.solids.push_back(
        solid("mill", "world", {fixed({0, 5000, 0}), hinge("sail", Vector3d::UnitY())}, {block}));
    return scene;
  };
  SimulationSettings how = settings("rk4", 100, 0.01);
  how.constraints = ConstraintTreatment::baumgarte;
  how.baumgarte_alpha = how.baumgarte_beta = 0;  // the point drifts off its circle
  const Certificate alone = run(swinging_rod(), how).certificate;
  const Certificate far = run(with_far(swinging_rod()), how).certificate;
  EXPECT_FALSE(alone.trusted);
  EXPECT_FALSE(far.trusted);
  EXPECT_EQ(far.reason, alone.reason);

  Scene spring;  // 1 cm on a spring: an adaptive method takes the same steps
  spring.gravity.setZero();
  spring.solids = {
      solid("mass", "world", {slide("x", Vector3d::UnitX(), 0.01)}, {inertial(1, {0, 0, 0}, {0, 0, 0})})};
  spring.efforts = {{"spring", CoordinateSpring{{"x"}, 100, 0, 0}}};
  SimulationSettings adaptive = settings("rk4_adaptive", 2, 0.01, 1e-8);
  EXPECT_EQ(run(with_far(spring), adaptive).step_sizes, run(spring, adaptive).step_sizes);
}

TEST(Certificate, CountsStepsAndEvaluations) {
  const Certificate fixed_step = run(roundabout(), settings("rk4", 1, 0.1)).certificate;
  EXPECT_EQ(fixed_step.steps_accepted, 10);
  EXPECT_EQ(fixed_step.steps_rejected, 0);
  EXPECT_EQ(fixed_step.evaluations, 1 + 10 * 4);
  EXPECT_DOUBLE_EQ(fixed_step.smallest_step, 0.1);
  const Trajectory adaptive = run(roundabout(), settings("rk4_adaptive", 1, 0.5, 1e-6));
  EXPECT_GT(adaptive.certificate.steps_rejected, 0);
  EXPECT_EQ(adaptive.certificate.steps_accepted, long(adaptive.step_sizes.size()));
}

}  // namespace
}  // namespace borelli::test
