// Points on lines and curves, angles, coupled coordinates: motions against closed forms, and refusals.
#include "dynamics/constraints/assembly.hpp"
#include "dynamics/equations/evaluate.hpp"
#include "dynamics/formats/scene_file.hpp"
#include "scenes.hpp"

namespace borelli::test::guides_test {
namespace {

constexpr double g = 9.81;

Solid bead(const Vector3d& p, const Vector3d& v) {
  std::vector<Switch> switches;
  for (int i = 0; i < 3; ++i)
    switches.push_back(slide(fmt::format("{}", "xyz"[i]), Vector3d::Unit(i), p[i], v[i]));
  return solid("bead", "world", switches, {inertial(1, {0, 0, 0}, {0, 0, 0})});
}

TEST(Guides, BeadSlidesDownAStraightWire) {
  // the same by a line, and by a curve through points of it
  const Vector3d along = Vector3d(1, 2, -2) / 3, start(0.3, -0.1, 0.5);
  const std::vector<Vector3d> points{start - along, start, start + 0.7 * along, start + 3 * along};
  for (const ConstraintKind& kind :
       std::vector<ConstraintKind>{PointOnLine{{"bead", {0, 0, 0}}, {"world", start}, along},
                                   PointOnCurve{{"bead", {0, 0, 0}}, {"world"}, points, false}}) {
    Scene scene;
    scene.solids = {bead(start, 0.5 * along)};
    scene.constraints = {{"wire", kind}};
    const Trajectory t = run(scene, settings("rk4", 1.5, 0.05));  // beyond the curve's last point
    EXPECT_TRUE(t.certificate.trusted) << t.certificate.reason;
    const double s = 0.5 * 1.5 + g * (2.0 / 3) * 1.5 * 1.5 / 2;
    EXPECT_GT(s, 3);
    EXPECT_LT((last(t.q) - (start + s * along)).norm(), 1e-12);
    // the wire's force: the weight's component across the wire
    EXPECT_NEAR(t.multipliers.row(0).norm(), g * std::sqrt(5.0) / 3, 1e-12);
    EXPECT_TRUE(t.certificate.redundant.empty());
  }
}

TEST(Guides, BeadSlidesDownAHelix) {
  // radius 1 m, pitch angle a: s = g sin a t^2 / 2; from rest, far from the curve's ends
  const double climb = 0.5, length = std::sqrt(1 + climb * climb), end = 1.5;
  const auto place = [&](double turn) { return Vector3d(std::cos(turn), std::sin(turn), -climb * turn); };
  std::vector<double> errors;
  for (int n : {80, 160}) {
    PointOnCurve helix{{"bead", {0, 0, 0}}, {"world"}, {}, false};
    for (int i = 0; i <= n; ++i) helix.through.push_back(place(-6 + 18.0 * i / n));
    Scene scene;
    scene.solids = {bead(place(0), {0, 0, 0})};
    scene.constraints = {{"helix", helix}};
    const Trajectory t = run(scene, settings("dop853", end, 0.01, 1e-10));
    EXPECT_TRUE(t.certificate.trusted) << t.certificate.reason;
    EXPECT_LT(t.certificate.residuals[0].position, 1e-12);
    const double turn = g * climb / length * end * end / 2 / length;
    errors.push_back((last(t.q) - place(turn)).norm());
  }
  // a spline's positions and length converge with the fourth power of its pieces
  EXPECT_LT(errors[1], 1e-5);
  EXPECT_NEAR(order(errors[0], errors[1]), 4, 0.5) << errors[0] << " and " << errors[1];
}

TEST(Guides, ClosedCurveActsAsAPendulumsCircle) {
  PointOnCurve ring{{"bead", {0, 0, 0}}, {"world"}, {}, true};
  for (int i = 0; i < 100; ++i)
    ring.through.push_back({std::sin(2 * M_PI * i / 100), 0, -std::cos(2 * M_PI * i / 100)});
  Scene scene;
  scene.solids = {bead({1, 0, 0}, {0, 0, 0})};
  scene.constraints = {{"ring", ring}};
  // back at rest after 4 K(sin 45 degrees) / sqrt g (as IFToMM's A01)
  const double period = 4 * std::comp_ellint_1(std::sqrt(0.5)) / std::sqrt(g);
  const Trajectory t = run(scene, settings("dop853", period, 0.01, 1e-10));
  EXPECT_TRUE(t.certificate.trusted) << t.certificate.reason;
  // the ring is off by (2 pi / 100)^4 / 384 of its radius, 4e-8
  EXPECT_LT((last(t.q) - Vector3d(1, 0, 0)).norm(), 1e-6);
  EXPECT_LT(last(t.v).norm(), 1e-5);
}

TEST(Guides, AngleConstraintGivesMotionOnACone) {
  // a point mass on a ball joint whose rod keeps an angle to the vertical: w^2 = g / (l cos) round and round
  const double angle = 0.6, w = std::sqrt(g / std::cos(angle));
  Scene scene;
  Solid bob = solid("bob", "world",
                    {hinge("round", Vector3d::UnitZ(), 0, w), hinge("tilt", Vector3d::UnitY(), -angle)},
                    {inertial(1, {0, 0, -1}, {0, 0, 0})});
  scene.solids = {bob};
  scene.constraints = {{"cone", AngleConstraint{{"bob"}, {0, 0, 1}, {"world"}, {0, 0, 1}, constant(angle)}}};
  const Trajectory t = run(scene, settings("rk4", 2, 0.01));
  EXPECT_TRUE(t.certificate.trusted) << t.certificate.reason;
  EXPECT_NEAR(last(t.q)[0], 2 * w, 1e-12);
  // at that speed the constraint bears no load
  EXPECT_NEAR(t.multipliers(0, 0), 0, 1e-12);
}

TEST(Guides, AngleFollowsItsFunction) {
  Scene scene;
  scene.gravity.setZero();
  scene.solids = {solid("door", "world", {hinge("hinge", Vector3d::UnitZ(), 0.5)}, {link()})};
  scene.constraints = {
      {"closer", AngleConstraint{{"door"}, {1, 0, 0}, {"world"}, {1, 0, 0}, linear(0.5, 0.3)}}};
  const Trajectory t = run(scene, settings("rk4", 2, 0.1));
  EXPECT_TRUE(t.certificate.trusted) << t.certificate.reason;
  EXPECT_NEAR(last(t.q)[0], 1.1, 1e-12);
}

TEST(Guides, ParallelDirectionsAndRepeatedPointsAreRefused) {
  const auto complaint = [](const ConstraintKind& kind) {
    Scene scene = chain(2, false);
    scene.constraints = {{"it", kind}};
    const auto system = compile(scene);
    return system ? "" : system.error().what;
  };
  EXPECT_EQ(complaint(AngleConstraint{{"l0"}, {0, 0, 1}, {"l1"}, {0, 0, 1}, constant(0)}),
            "its angle must lie between 0 and pi, both excluded");
  EXPECT_EQ(complaint(PointOnCurve{{"l0", {}}, {"world"}, {{0, 0, 0}}, false}),
            "its curve has too few points; it needs at least two");
  EXPECT_EQ(complaint(PointOnCurve{{"l0", {}}, {"world"}, {{0, 0, 0}, {1, 0, 0}, {0, 0, 0}}, true}),
            "two successive points of its curve coincide");
  EXPECT_EQ(complaint(CoordinateFunction{{"h0"}, {"h0"}, linear(0, 1)}),
            "makes a coordinate a function of itself");
}

// ---- coupled switches ----

Scene geared(const TimeFunction& function) {
  Scene scene;
  scene.gravity.setZero();
  Switch driven_gear = hinge("pinion", Vector3d::UnitZ());
  driven_gear.q.clear();
  driven_gear.v.clear();
  driven_gear.motion = Coupled{"wheel", function};
  scene.solids = {solid("pinion", "world", {driven_gear}, {inertial(1, {0, 0, 0}, {0.1, 0.1, 0.02})}),
                  solid("wheel", "world", {hinge("wheel", Vector3d::UnitZ(), 0.2, 1)},
                        {inertial(1, {0, 0, 0}, {1, 1, 0.5})})};
  scene.efforts = {{"motor", Torque{{"wheel"}, {0, 0, 2}, Axes::world, constant(1), {}}}};
  return scene;
}

TEST(Coupled, GearTransmitsTorque) {
  // (0.5 + 9 * 0.02) a = 2, pinion = 0.4 - 3 wheel
  const Trajectory t = run(geared(linear(0.4, -3)), settings("rk4", 1.5, 0.1));
  EXPECT_TRUE(t.certificate.trusted) << t.certificate.reason;
  const double a = 2 / (0.5 + 9 * 0.02), wheel = 0.2 + 1.5 + a * 1.5 * 1.5 / 2;
  EXPECT_NEAR(last(t.q)[1], wheel, 1e-12);
  EXPECT_NEAR(last(t.q)[0], 0.4 - 3 * wheel, 1e-12);
  EXPECT_EQ(t.multiplier_names, std::vector<std::string>{"coupling of 'pinion'"});
  // no assembly was needed: it starts where its function says
  EXPECT_LT(t.certificate.assembly_position, 1e-15);
}

TEST(Coupled, KneeSlideFollowsItsSpline) {
  // one coordinate x with the slide f(x): (J + m f'^2) x'' + m f' f'' x'^2 = -m g f'
  const Table spline({-0.5, 0, 0.6, 1.2, 2}, {0.02, 0, -0.03, -0.05, -0.04});
  Scene scene;
  Switch slides = slide("slide", Vector3d::UnitZ());
  slides.q.clear();
  slides.v.clear();
  slides.motion = Coupled{"flexion", spline};
  scene.solids = {solid("shank", "world", {slides, hinge("flexion", Vector3d::UnitY(), 0.8, 3)},
                        {inertial(3, {0, 0, 0}, {0.05, 0.04, 0.01})})};
  const System system = compiled(scene);
  const Evaluation now = need(evaluate(system, system.initial));
  const TimeValue f = spline(0.8);
  const double x = -3 * (f.rate * f.acceleration * 9 + g * f.rate) / (0.04 + 3 * f.rate * f.rate);
  EXPECT_NEAR(now.acceleration[1], x, 1e-12);
  EXPECT_NEAR(now.acceleration[0], f.rate * x + f.acceleration * 9, 1e-12);
  const Trajectory t = run(system, settings("dop853", 1, 1e-3, 1e-10));
  EXPECT_TRUE(t.certificate.trusted) << t.certificate.reason;
  EXPECT_LT(t.certificate.residuals[0].position, 1e-12);
  EXPECT_NEAR(last(t.q)[0], spline(last(t.q)[1]).value, 1e-12);
}

TEST(Coupled, ChainStartsAtItsFunctionValues) {
  Scene scene = geared(linear(0.4, -3));
  Switch third = slide("rack", Vector3d::UnitX());
  third.q.clear();
  third.v.clear();
  third.motion = Coupled{"pinion", Polynomial{{0, 0.1, 0.5}}};
  scene.solids.push_back(solid("rack", "world", {third}, {inertial(1, {0, 0, 0}, {0, 0, 0})}));
  const System system = compiled(scene);
  const double pinion = 0.4 - 3 * 0.2, rate = -3;
  EXPECT_NEAR(system.initial.q[2], 0.1 * pinion + 0.5 * pinion * pinion, 1e-15);
  EXPECT_NEAR(system.initial.v[2], (0.1 + pinion) * rate, 1e-15);
}

TEST(Coupled, InvalidCouplingsAreRefused) {
  const auto complaint = [](const std::string& joint) {
    const auto scene = parse_scene(
        fmt::format("[[solid]]\nname = \"a\"\njoint = [{{rotation = \"x\", name = \"q\"}}, {}]\nmass = 1\n"
                    "tensor = [1, 1, 1]\n",
                    joint),
        "s.toml");
    if (!scene) return scene.error().message();
    const auto system = compile(*scene);
    return system ? std::string() : system.error().message();
  };
  const auto one = [](const std::string& more) {
    return "{translation = \"y\", name = \"p\", coupled = {to = " + more + "}}";
  };
  EXPECT_EQ(complaint(one("\"q\", function = [0, 2]")), "");
  EXPECT_EQ(complaint(one("\"nowhere\", function = [0, 2]")),
            "s.toml:3: there is no coordinate named 'nowhere', expected one of: p, q");
  EXPECT_EQ(complaint(one("\"p\", function = [0, 2]")),
            "s.toml:1: solid 'a', coordinate 'p': is coupled to 'p', which is coupled back to it");
  EXPECT_EQ(complaint("{ball = true, name = \"p\", coupled = {to = \"q\", function = 1}}"),
            "s.toml:3: solid 'a', switch 2 of its joint: has three velocities and cannot be coupled; "
            "expected a switch with one");
  EXPECT_EQ(complaint("{translation = \"y\", name = \"p\", value = 1, coupled = {to = \"q\", function = 1}}"),
            "s.toml:3: solid 'a', switch 2 of its joint: has a value, but a coupled coordinate takes the "
            "value of its function");
}

// ---- short forms ----

TEST(ShortForms, EqualTheirSwitches) {
  const std::string text = R"(
[[solid]]
name = "a"
joint = [{universal = ["x", "-z"], name = "u", value = [0.1, 0.2]}, {planar = "y"}]
mass = 1
tensor = [1, 1, 1]

[[solid]]
name = "b"
joint = {cylindrical = "x", velocity = [1, 2]}
mass = 1
tensor = [1, 1, 1]

[[solid]]
name = "c"
joint = {free = true, name = "c", value = [1, 2, 3, 1, 0, 0, 0], velocity = [1, 2, 3, 4, 5, 6]}
mass = 1
tensor = [1, 1, 1]
)";
  const Scene scene = need(parse_scene(text, "short.toml"));
  const System system = compiled(scene);
  std::vector<std::string> names;
  for (const CoordinateInfo& info : system.coordinates) names.push_back(info.name);
  EXPECT_EQ(names, (std::vector<std::string>{"u.1", "u.2", "a.3", "a.4", "a.5", "b.1", "b.2", "c.1", "c.2",
                                             "c.3", "c.4"}));
  const auto& u = scene.solids[0].switches;
  EXPECT_EQ(std::get<Rotation>(u[1].kind).axis, -Vector3d::UnitZ());
  EXPECT_EQ(u[1].q, std::vector<double>{0.2});
  EXPECT_EQ(std::get<Translation>(u[2].kind).axis, Vector3d::UnitZ());
  EXPECT_EQ(std::get<Translation>(u[3].kind).axis, Vector3d::UnitX());
  EXPECT_EQ(std::get<Rotation>(u[4].kind).axis, Vector3d::UnitY());
  EXPECT_EQ(scene.solids[1].switches[1].v, std::vector<double>{2});
  EXPECT_EQ(scene.solids[2].switches[3].q, (std::vector<double>{1, 0, 0, 0}));
  EXPECT_EQ(scene.solids[2].switches[3].v, (std::vector<double>{4, 5, 6}));
  // written back as full switches
  const Scene back = need(parse_scene(need(write_scene(scene)), "short.toml"));
  EXPECT_EQ(back.solids[0].switches.size(), 5u);
  EXPECT_EQ(need(write_scene(back)), need(write_scene(scene)));
}

TEST(ShortForms, RefuseInvalidValues) {
  const auto complaint = [](const std::string& joint) {
    const auto scene = parse_scene("[[solid]]\nname = \"a\"\njoint = " + joint + "\n", "s.toml");
    return scene ? std::string() : scene.error().message();
  };
  EXPECT_EQ(complaint("{universal = [\"x\"]}"),
            "s.toml:3: solid 'a', switch 1 of its joint: universal is a list of 1, expected two axes");
  EXPECT_EQ(complaint("{free = false}"),
            "s.toml:3: solid 'a', switch 1 of its joint: free is false, expected true");
  EXPECT_EQ(complaint("{planar = \"z\", value = [1, 2]}"),
            "s.toml:3: solid 'a', switch 1 of its joint: value is a list of 2, expected a list of 3 numbers");
  EXPECT_NE(complaint("{planar = \"z\", locked = true}").find("unknown key 'locked'"), std::string::npos);
  EXPECT_NE(
      complaint("{spherical = true}")
          .find("expected one of fixed, translation, rotation, screw, ball, guided, ellipsoid, universal"),
      std::string::npos);
}

}  // namespace
}  // namespace borelli::test::guides_test
