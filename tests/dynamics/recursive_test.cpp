// The recursive equations against the paper's scan: the same scene by two programs' worth of different
// formulas, over random trees with all that a scene may hold.
#include "dynamics/recursive.hpp"

#include <Eigen/SVD>

#include "dynamics/equations.hpp"
#include "dynamics/evaluate.hpp"
#include "scenes.hpp"

namespace borelli::test {
namespace {

/// A random scene: one to three trees of solids, some welded, some without mass, with none to three switches
/// each (all kinds; free, driven, locked), springs, forces and (if asked) constraints.
class RandomScene {
 public:
  RandomScene(unsigned seed, int solids, bool constrained) : random_(seed) {
    for (int i = 0; i < solids; ++i) add_solid(i, solids);
    add_efforts(solids);
    if (constrained) add_constraints(solids);
  }
  Scene scene;

 private:
  TimeFunction function() {
    if (random_.integer(0, 1))
      return Polynomial{{random_.number(-1, 1), random_.number(-1, 1), random_.number(-1, 1)}};
    return Sine{random_.number(-1, 1), random_.number(0.5, 2), random_.number(-1, 1), random_.number(-1, 1)};
  }

  void add_solid(int i, int solids) {
    std::vector<Switch> switches;
    if (random_.integer(0, 3))
      switches.push_back(fixed(random_.vector(0.5), rotation_matrix(random_.turn())));
    // the last solid of each branch has mass, so that every coordinate moves some
    const bool massless = i % 4 == 1 && i + 1 < solids;
    const bool welded = i % 5 == 3;
    const int count = welded ? 0 : massless ? 1 : random_.integer(1, 3);
    bool turned = false, balled = false;
    for (int j = 0; j < count; ++j) {
      const std::string name = fmt::format("c{}{}", i, j);
      int kind = random_.integer(0, 2);
      if (balled || (kind == 2 && turned)) kind = 1;  // no two turns about one axis in one point
      Switch one = kind == 0   ? hinge(name, random_.direction())
                   : kind == 1 ? slide(name, random_.direction())
                               : ball(name);
      turned = turned || kind == 0;
      balled = balled || kind == 2;
      const int motion = random_.integer(0, 6);
      if (motion == 0) {
        one.q.clear();
        one.v.clear();
        one.motion = kind == 2 ? Driven{{function(), function(), function()}} : Driven{{function()}};
      } else if (motion == 1) {
        one.motion = Locked{};
      }
      if (motion > 1 && kind < 2) scalars_.push_back(name);
      switches.push_back(one);
      if (random_.integer(0, 2) == 0) switches.push_back(fixed(random_.vector(0.3)));
    }
    std::string parent = "world";
    if (i > 0 && i % 4 == 2)
      parent = fmt::format("s{}", i - 1);  // what the massless one carries
    else if (i > 0 && random_.integer(0, 5))
      parent = fmt::format("s{}", random_.integer(0, i - 1));
    std::vector<Inertial> inertials;
    if (!massless) inertials.push_back(random_.inertia().inertial());
    scene.solids.push_back(solid(fmt::format("s{}", i), parent, switches, inertials));
  }

  SolidPoint point(int solids) {
    return {random_.integer(0, 4) ? fmt::format("s{}", random_.integer(0, solids - 1)) : "world",
            random_.vector(1)};
  }

  void add_efforts(int solids) {
    scene.efforts = {
        {"push", Force{point(solids), random_.vector(3), Axes::solid, function(), point(solids)}},
        {"twist", Torque{{fmt::format("s{}", solids - 1)}, random_.vector(3), Axes::world, function(), {}}},
        {"spring", PointSpring{point(solids), point(solids), 20, 1, 0.3}},
        {"torsion", TorsionSpring{{fmt::format("s{}", solids - 1)}, {"s0"}, 3, 0.2, random_.vector(0.3)}}};
    if (!scalars_.empty())
      scene.efforts.push_back({"coordinate", CoordinateSpring{{scalars_[0]}, 5, 0.1, 0}});
  }

  void add_constraints(int solids) {
    const std::string last = fmt::format("s{}", solids - 1), middle = fmt::format("s{}", solids / 2);
    scene.constraints = {
        {"rod", Distance{{last, random_.vector(1)}, {"world", {2, 1, 0}}, Polynomial{{2, 0.3}}}},
        {"table", PointOnPlane{{middle, random_.vector(1)},
                               {"s0", random_.vector(1)},
                               random_.direction(),
                               Polynomial{{0.1, 0.2}}}}};
    if (scalars_.size() > 3)
      scene.constraints.push_back(
          {"gear", CoordinateCoupling{{{scalars_[0]}, {scalars_.back()}}, {1, -2}, Polynomial{{0, 1}}}});
    if (solids > 8)
      scene.constraints.push_back({"pin", PointOnPoint{{last, random_.vector(0.5)}, {middle, {}}}});
  }

  Random random_;
  std::vector<std::string> scalars_;
};

/// The largest difference beside the largest entry.
double relative(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  if (b.size() == 0) return 0;
  return (a - b).cwiseAbs().maxCoeff() / std::max(1e-3, b.cwiseAbs().maxCoeff());
}

double condition(const Eigen::MatrixXd& A) {
  const Eigen::VectorXd s = A.jacobiSvd().singularValues();
  return s[0] / s[s.size() - 1];
}

struct Pair {
  Workspace lagrange, recursive;
  explicit Pair(const System& system)
      : lagrange(system, Equations::lagrange), recursive(system, Equations::recursive) {}
};

void compare(const System& system, const State& state, const std::string& which) {
  const Parameters& p = system.parameters;
  Pair w(system);
  ASSERT_FALSE(update_terms(system, p, state.t, state.q.data(), state.v.data(), w.lagrange)) << which;
  ASSERT_FALSE(update_terms(system, p, state.t, state.q.data(), state.v.data(), w.recursive)) << which;
  const LagrangeTerms &l = w.lagrange.terms, &r = w.recursive.terms;
  // sums of some hundred terms: 1e-14 each of the largest
  const Rows A = l.A.selfadjointView<Eigen::Lower>();
  EXPECT_LT(relative(r.A.selfadjointView<Eigen::Lower>(), A), 1e-12) << which;
  EXPECT_LT(relative(r.B, l.B), 1e-12) << which;
  EXPECT_LT(relative(r.Q, l.Q), 1e-12) << which;
  EXPECT_NEAR(r.kinetic, l.kinetic, 1e-12 * l.kinetic) << which;
  EXPECT_NEAR(r.potential, l.potential, 1e-12 * (1 + std::abs(l.potential))) << which;
  EXPECT_LT(relative(r.group_kinetic, l.group_kinetic), 1e-12) << which;
  EXPECT_LT(relative(r.group_potential, l.group_potential), 1e-12) << which;
  EXPECT_LT(relative(w.recursive.rows.L, w.lagrange.rows.L), 1e-12) << which;
  EXPECT_LT(relative(w.recursive.rows.E, w.lagrange.rows.E), 1e-12) << which;
  for (std::size_t b = 1; b < system.bodies.size(); ++b) {
    if (!system.bodies[b].touched) continue;
    const BodyMotion &ml = w.lagrange.kinematics.bodies[b], &mr = w.recursive.kinematics.bodies[b];
    EXPECT_LT(relative(mr.v, ml.v) + relative(mr.vdot, ml.vdot) + relative(mr.wdot, ml.wdot), 3e-12) << which;
  }

  const Eigen::VectorXd given = Eigen::VectorXd::LinSpaced(system.nv, -1, 2);
  ASSERT_FALSE(accelerate(system, p, state.t, state.q.data(), state.v.data(), {}, w.lagrange, given.data()));
  ASSERT_FALSE(accelerate(system, p, state.t, state.q.data(), state.v.data(), {}, w.recursive, given.data()));
  // rounding of the terms (some 10 units), times what solving with A and with the rows makes of it
  const int n = system.nv;
  double amplified = condition(A.topLeftCorner(n, n));
  if (system.rows > 0) amplified *= condition(w.lagrange.rows.L.leftCols(n));
  const double bound = 10 * 2.3e-16 * amplified;
  EXPECT_LT(relative(w.recursive.a, w.lagrange.a), bound) << which;
  EXPECT_LT(relative(w.recursive.multipliers, w.lagrange.multipliers), bound) << which;
  EXPECT_LT(relative(w.recursive.drive_efforts, w.lagrange.drive_efforts), bound) << which;
  EXPECT_NEAR(w.recursive.power.total(), w.lagrange.power.total(),
              bound * (1 + std::abs(w.lagrange.power.total())))
      << which;
  // and by the equations themselves, whatever the condition of A: the residual beside its largest part
  const Eigen::VectorXd residual = A.topLeftCorner(n, n) * w.recursive.a + l.B.head(n) - l.Q.head(n) - given -
                                   w.lagrange.rows.L.leftCols(n).transpose() * w.recursive.multipliers;
  const double part =
      A.cwiseAbs().maxCoeff() * w.recursive.a.cwiseAbs().maxCoeff() + l.B.cwiseAbs().maxCoeff() +
      l.Q.cwiseAbs().maxCoeff() +
      (system.rows ? w.lagrange.rows.L.cwiseAbs().maxCoeff() * w.recursive.multipliers.cwiseAbs().maxCoeff()
                   : 0);
  EXPECT_LT(residual.cwiseAbs().maxCoeff(), 1e-12 * part) << which;
}

void compare_random(int solids, bool constrained) {
  int compared = 0;
  for (unsigned seed = 0; seed < 60; ++seed) {
    const auto system = compile(RandomScene(seed, solids, constrained).scene);
    if (!system || system->nv == 0) continue;  // a coordinate that moves no mass: the compiler's to refuse
    State state = Random(seed + 500).state(*system);
    state.t = 0.3;
    compare(*system, state, fmt::format("seed {}, {} solids", seed, solids));
    ++compared;
  }
  EXPECT_GT(compared, 30);
}

TEST(Recursive, EqualsLagrangeOnSmallRandomScenes) { compare_random(3, false); }
TEST(Recursive, EqualsLagrangeOnRandomScenes) { compare_random(12, false); }
TEST(Recursive, EqualsLagrangeOnConstrainedRandomScenes) { compare_random(12, true); }
TEST(Recursive, EqualsLagrangeOnLongChains) {
  const System system = compiled(chain(30, true));
  compare(system, Random(1).state(system), "chain");
}

// Mass ratios of a million, and all of it a kilometre from the world's origin: what rounding does then must
// not differ by more than the distance (in lengths of the scene, 1e3) times what it does near by.
TEST(Recursive, EqualsLagrangeFarFromTheOrigin) {
  Scene scene = chain(6, true);
  scene.solids[0].switches.insert(scene.solids[0].switches.begin(), fixed({1000, 500, -300}));
  scene.solids[2].inertials[0].mass = 1e6;
  const System system = compiled(scene);
  const State state = Random(2).state(system);
  Pair w(system);
  for (Workspace* one : {&w.lagrange, &w.recursive})
    ASSERT_FALSE(accelerate(system, system.parameters, 0, state.q.data(), state.v.data(), {}, *one));
  const double error = relative(w.recursive.a, w.lagrange.a);
  const Rows A = w.lagrange.terms.A.selfadjointView<Eigen::Lower>();
  EXPECT_LT(error, 1e3 * 10 * 2.3e-16 * std::sqrt(condition(A)));
}

TEST(Recursive, ACoordinateThatMeetsNoInertiaIsNamed) {
  // two hinges about one axis in one point: the first can always follow the second
  Scene scene;
  scene.solids = {solid("a", "world", {hinge("first", Vector3d::UnitY())}, {}),
                  solid("b", "a", {hinge("second", Vector3d::UnitY())}, {link()})};
  for (Equations equations : {Equations::lagrange, Equations::recursive}) {
    scene.simulation.equations = equations;
    const auto refused = evaluate(compiled(scene), compiled(scene).initial);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().where, "coordinate 'first'");
  }
}

// A bar's moment about its own axis may be as small as one likes beside the others: it is inertia, not
// rounding.
TEST(Recursive, AThinBarTurnsAboutItsAxis) {
  Scene scene;
  scene.gravity.setZero();
  scene.solids = {solid("bar", "world", {hinge("spin", Vector3d::UnitZ())},
                        {inertial(1, {0, 0, -0.5}, {1.0 / 12, 1.0 / 12, 1e-15})})};
  scene.efforts = {{"turn", Torque{{"bar"}, {0, 0, 1e-15}, Axes::world, constant(1), {}}}};
  for (Equations equations : {Equations::lagrange, Equations::recursive}) {
    scene.simulation.equations = equations;
    const System system = compiled(scene);
    EXPECT_NEAR(need(evaluate(system, system.initial)).acceleration[0], 1, 1e-12);
  }
}

TEST(Recursive, SimulationsCoincide) {
  for (bool constrained : {false, true}) {
    Scene scene = constrained ? chain(4, true) : roundabout();
    if (constrained) scene.constraints = {{"rod", Distance{{"l3", {0, 0, -1}}, {"world", {}}, constant(4)}}};
    scene.solids[0].switches.back().v = {1};
    SimulationSettings how = settings("rk4", 1, 1e-3);
    how.equations = Equations::lagrange;
    const Trajectory lagrange = run(scene, how);
    how.equations = Equations::recursive;
    const Trajectory recursive = run(scene, how);
    // a thousand steps of rounding, which the motion may magnify tenfold
    EXPECT_LT((last(recursive.q) - last(lagrange.q)).norm(), 1e-11);
    EXPECT_TRUE(recursive.certificate.trusted) << recursive.certificate.reason;
  }
}

}  // namespace
}  // namespace borelli::test
