// The guided switch against differences of its poses and against the same scene of slides and hinges tied by
// constraints; both algorithms, batches and derivatives.
#include "dynamics/scene/switch_guided.hpp"

#include "dynamics/constraints/assembly.hpp"
#include "dynamics/equations/batch.hpp"
#include "dynamics/equations/derivatives.hpp"
#include "dynamics/equations/evaluate.hpp"
#include "scenes.hpp"

namespace borelli::test::guided_test {
namespace {

using PartKind = GuidedPart::Kind;

std::vector<GuidedPart> knee_parts() {
  return {{PartKind::translation, Vector3d::UnitX(), Polynomial{{-0.01, 0.03, -0.02, 0.01}}},
          {PartKind::translation, Vector3d::UnitY(),
           Table({-2, -1, -0.4, 0.3, 1, 2}, {-0.4, -0.41, -0.40, -0.38, -0.37, -0.39}, SplineEnds::forsythe)},
          {PartKind::rotation, Vector3d::UnitZ(), linear(0.1, 1)},
          {PartKind::rotation, Vector3d(1, 2, 0.5).normalized(), Sine{0.2, 1.3, 0.4, 0.1}},
          {PartKind::translation, Vector3d(0.3, -1, 2).normalized(), Polynomial{{0, 0.05, 0.04}}}};
}

Switch guided(const std::string& name, std::vector<GuidedPart> parts, double q = 0, double v = 0) {
  Switch out = hinge(name, Vector3d::UnitZ(), q, v);
  out.kind = Guided{std::move(parts)};
  return out;
}

/// A thigh on a ball, a shank on a knee and a foot on a hinge. The knee is guided, or its parts are tied to
/// the flexion by constraints.
Scene leg(bool tied) {
  Scene scene;
  const Inertial mass = inertial(3, {0.02, -0.2, 0.01}, {0.05, 0.01, 0.06});
  std::vector<Switch> knee{fixed({0, 0.02, 0.01}, rotation_about(Vector3d::UnitX(), 0.2))};
  if (!tied) {
    knee.push_back(guided("knee", knee_parts(), 0.6, -1.5));
  } else {
    int i = 0;
    for (const GuidedPart& part : knee_parts()) {
      const std::string name = i == 2 ? "knee" : fmt::format("part{}", i);
      if (i == 2) knee.push_back(fixed({0, 0, 0}, rotation_about(part.axis, 0.1)));
      Switch one = part.kind == PartKind::rotation ? hinge(name, part.axis) : slide(name, part.axis);
      one.q.clear(), one.v.clear();
      if (i == 2)
        one.q = {0.6}, one.v = {-1.5};
      else
        one.motion = Coupled{"knee", part.by};
      knee.push_back(one);
      ++i;
    }
  }
  knee.push_back(fixed({0.01, 0, 0}, rotation_about(Vector3d::UnitY(), -0.3)));
  scene.solids = {solid("thigh", "world", free_switches("hip"), {mass}),
                  solid("shank", "thigh", knee, {mass}),
                  solid("foot", "shank", {fixed({0, -0.4, 0}), hinge("ankle", Vector3d::UnitZ(), 0.3, 2)},
                        {inertial(1, {0.05, 0, 0}, {0.002, 0.003, 0.003})})};
  scene.solids[0].switches[3].v = {0.4, -1, 0.7};
  return scene;
}

TEST(Guided, TwistAndItsChangeAreTheDifferencesOfPoses) {
  const Guided knee{knee_parts()};
  const double h = 1e-4;
  for (const double q : {-2.5, -0.7, 0.0, 0.9, 2.4}) {
    Pose X[3];
    Vector3d w[3], v[3], w_bend, v_bend;
    for (int i = 0; i < 3; ++i) {
      const double at = q + (i - 1) * h;
      const double unit = 1;
      knee.advance(&at, &unit, X[i], &w[i], &v[i], w_bend, v_bend);
      if (i != 1) continue;
      const Vector3d bends[] = {w_bend, v_bend};
      Pose short_X;
      Vector3d short_w, short_v;
      knee.advance(&at, short_X, &short_w, &short_v);
      EXPECT_EQ(short_X.p, X[1].p);
      EXPECT_EQ(short_v, v[1]);
      // central differences of velocities; errors of h^2 times third derivatives, below 10
      Vector3d seen[2][2];
      for (int side = 0; side < 2; ++side) {
        const double beside = q + (2 * side - 1) * h;
        Pose X_side;
        Vector3d w_side, v_side;
        knee.advance(&beside, X_side, &w_side, &v_side);
        seen[side][0] = X_side.R.transpose() * w_side;
        seen[side][1] = X_side.R.transpose() * v_side;
      }
      for (int n = 0; n < 2; ++n)
        EXPECT_LT((X[1].R * (seen[1][n] - seen[0][n]) / (2 * h) - bends[n]).norm(), 1e-6) << q;
    }
    EXPECT_LT((v[1] - (X[2].p - X[0].p) / (2 * h)).norm(), 1e-7) << q;
    const Matrix3d W = (X[2].R - X[0].R) / (2 * h) * X[1].R.transpose();
    EXPECT_LT((w[1] - Vector3d(W(2, 1), W(0, 2), W(1, 0))).norm(), 1e-7) << q;
  }
}

/// Accelerations by name at the scene's start.
std::map<std::string, double> accelerations(const Scene& scene, Equations equations) {
  System system = compiled(scene);
  system.settings.equations = equations;
  State state = system.initial;
  if (system.rows > 0) need(assemble(system, state));
  const Evaluation now = need(evaluate(system, state));
  std::map<std::string, double> out;
  const auto names = system.velocity_names();
  for (std::size_t i = 0; i < names.size(); ++i) out[names[i]] = now.acceleration[i];
  return out;
}

TEST(Guided, AcceleratesAsSlidesAndHingesTied) {
  const auto tied = accelerations(leg(true), Equations::recursive);
  for (const Equations equations : {Equations::recursive, Equations::lagrange}) {
    const auto own = accelerations(leg(false), equations);
    EXPECT_EQ(own.size(), 8u);
    // rounding, times the condition of the ties
    for (const auto& [name, a] : own) EXPECT_NEAR(a, tied.at(name), 1e-9 * (1 + std::abs(a))) << name;
  }
}

TEST(Guided, KeepsTheEnergyOfAMotion) {
  for (const Equations equations : {Equations::recursive, Equations::lagrange}) {
    SimulationSettings how = settings("dop853", 1, 1e-3, 1e-10);
    how.equations = equations;
    const Trajectory t = run(leg(false), how);
    EXPECT_TRUE(t.certificate.trusted) << t.certificate.reason;
  }
}

TEST(Guided, DriveEffortEqualsThatOfTheFreeSwitchInTheSameMotion) {
  Scene scene = leg(false);
  Switch& knee = scene.solids[1].switches[1];
  knee = driven(knee, Polynomial{{0.6, -1.5, 2}});
  const System held = compiled(scene);
  const Evaluation now = need(evaluate(held, held.initial));
  // the same accelerations in the free scene need the drive's effort only
  const System free = compiled(leg(false));
  Eigen::VectorXd a(free.nv);
  const auto names = free.velocity_names(), others = held.velocity_names();
  for (int i = 0; i < free.nv; ++i) {
    const auto at = std::find(others.begin(), others.end(), names[i]);
    a[i] = at == others.end() ? 4 : now.acceleration[at - others.begin()];
  }
  const InverseDynamics needed = need(inverse_dynamics(free, free.initial, a));
  for (int i = 0; i < free.nv; ++i)
    EXPECT_NEAR(needed.efforts[i], names[i] == "knee" ? now.drive_efforts[0] : 0, 1e-10) << names[i];
}

TEST(Guided, LanesEqualSingleStates) {
  const System system = compiled(leg(false));
  BatchState states(system);
  BatchWorkspace work(system);
  Random random(3);
  std::vector<State> singles;
  for (int lane = 0; lane < Lanes::count; ++lane) {
    singles.push_back(random.state(system));
    states.set(lane, singles.back());
  }
  ASSERT_TRUE(accelerate<Lanes>(system, system.parameters, states, work));
  for (int lane = 0; lane < Lanes::count; ++lane) {
    singles[lane].t = states.t;
    const Evaluation one = need(evaluate(system, singles[lane]));
    for (int i = 0; i < system.nv; ++i)
      EXPECT_NEAR(work.a[i][lane], one.acceleration[i], 1e-11 * (1 + one.acceleration.norm()));
  }
}

TEST(Guided, DerivativesAreTheDifferencesOfAccelerations) {
  const System system = compiled(leg(false));
  const ForwardDerivatives exact = need(forward_derivatives(system, system.initial));
  const auto& knee = *std::find_if(system.coordinates.begin(), system.coordinates.end(),
                                   [](const CoordinateInfo& info) { return info.name == "knee"; });
  const double h = 1e-5;
  const auto differ = [&](auto member, int index) {
    State ahead = system.initial, behind = ahead;
    (ahead.*member)[index] += h, (behind.*member)[index] -= h;
    return Eigen::VectorXd(
        (need(evaluate(system, ahead)).acceleration - need(evaluate(system, behind)).acceleration) / (2 * h));
  };
  const double size = exact.acceleration_by_q.norm();
  EXPECT_LT((exact.acceleration_by_q.col(knee.v_index) - differ(&State::q, knee.q_index)).norm(),
            1e-7 * size);
  EXPECT_LT((exact.acceleration_by_v.col(knee.v_index) - differ(&State::v, knee.v_index)).norm(),
            1e-7 * size);
}

TEST(Guided, IsReadAndWritten) {
  const Scene scene = leg(false);
  const Scene back = need(parse_scene(need(write_scene(scene)), "leg.toml"));
  const auto& parts = std::get<Guided>(back.solids[1].switches[1].kind).parts;
  ASSERT_EQ(parts.size(), knee_parts().size());
  for (std::size_t i = 0; i < parts.size(); ++i) {
    EXPECT_EQ(parts[i].kind, knee_parts()[i].kind);
    EXPECT_EQ(parts[i].axis, knee_parts()[i].axis);
    EXPECT_EQ(at(parts[i].by, 0.77).value, at(knee_parts()[i].by, 0.77).value);
  }
}

TEST(Guided, BadPartsAreRefused) {
  const auto complaint = [](const std::string& joint) {
    const auto scene = parse_scene(
        "[[solid]]\nname = \"a\"\nmass = 1\ntensor = [1, 1, 1]\njoint = {" + joint + "}\n", "a.toml");
    return scene ? std::string() : scene.error().message();
  };
  EXPECT_NE(complaint("guided = []").find("at least one part"), std::string::npos);
  EXPECT_NE(complaint("guided = [{rotation = \"z\"}]").find("by"), std::string::npos);
  EXPECT_NE(complaint("guided = [{rotation = [0, 0, 2], by = [0, 1]}]").find("unit"), std::string::npos);
  EXPECT_EQ(complaint("guided = [{rotation = \"z\", by = [0, 1]}]"), "");
  Scene scene = leg(false);
  std::get<Guided>(scene.solids[1].switches[1].kind).parts[0].axis.setZero();
  EXPECT_FALSE(compile(scene));
}

}  // namespace
}  // namespace borelli::test::guided_test
