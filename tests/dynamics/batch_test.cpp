// Each lane of a batch equals a single state.
#include "dynamics/equations/batch.hpp"

#include <Eigen/SVD>

#include "dynamics/equations/evaluate.hpp"
#include "each_width.hpp"
#include "random_scene.hpp"

namespace borelli::test {
namespace {

constexpr int count = Lanes::count;

Eigen::VectorXd lane_of(const Eigen::VectorX<Lanes>& x, int lane) {
  Eigen::VectorXd out(x.size());
  for (Eigen::Index i = 0; i < x.size(); ++i) out[i] = x[i][lane];
  return out;
}

double relative(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  if (b.size() == 0) return 0;
  return (a - b).cwiseAbs().maxCoeff() / std::max(1e-3, b.cwiseAbs().maxCoeff());
}

template <class L>
class LanesTest : public ::testing::Test {};
using AllLanes = ::testing::Types<LanesOf<8, 8>, LanesOf<8, 4>, LanesOf<8, 2>, LanesOf<4, 4>, LanesOf<4, 2>>;
TYPED_TEST_SUITE(LanesTest, AllLanes);

TYPED_TEST(LanesTest, FunctionsEqualScalarFunctions) {
  using L = TypeParam;
  Random random(1);
  for (int i = 0; i < 2000; ++i) {
    L x, y;
    for (int lane = 0; lane < L::count; ++lane) {
      x.set(lane, random.number(-1, 1) * std::pow(10, random.number(-5, 5)));
      y.set(lane, random.number(-1, 1));
    }
    const L s = sin(x), c = cos(x), root = sqrt(abs(x)), angle = atan2(y, x);
    const L greater = either(
        x > y, [&] { return x; }, [&] { return y; });
    for (int lane = 0; lane < L::count; ++lane) {  // allows one unit of rounding
      EXPECT_NEAR(s[lane], std::sin(x[lane]), 2.3e-16) << x[lane];
      EXPECT_NEAR(c[lane], std::cos(x[lane]), 2.3e-16) << x[lane];
      EXPECT_EQ(root[lane], std::sqrt(std::abs(x[lane])));
      EXPECT_EQ(angle[lane], std::atan2(y[lane], x[lane]));
      EXPECT_EQ(greater[lane], std::max(x[lane], y[lane]));
    }
  }
  L odd(0.5);
  odd.set(1, NAN);
  odd.set(2, INFINITY);
  odd.set(3, 1e300);
  EXPECT_TRUE(std::isnan(sin(odd)[1]) && std::isnan(cos(odd)[2]));
  EXPECT_EQ(sin(odd)[3], std::sin(1e300));
  EXPECT_EQ(sin(odd)[0], std::sin(0.5));
}

TYPED_TEST(LanesTest, MasksReduceOverAllOrAnyLanes) {
  using L = TypeParam;
  for (int hit = -1; hit < L::count; ++hit) {
    L x(1);
    if (hit >= 0) x.set(hit, 3);
    EXPECT_EQ((x > 2).any(), hit >= 0);
    EXPECT_EQ((x < 2).all(), hit < 0);
  }
  EXPECT_TRUE((L(3) > 2).all() && !(L(3) < 2).any());
}

/// Compares all results of eight random states in a batch and one by one; `bound` is relative to the largest
/// entry.
void compare(const System& system, unsigned seed, double bound, const std::string& which) {
  ASSERT_TRUE(check_batch(system)) << which;
  const Parameters& p = system.parameters;
  BatchState batch(system);
  BatchWorkspace w(system, true);
  Workspace one(system, Equations::recursive);
  std::vector<State> states;
  Eigen::VectorX<Lanes> given(system.nv), efforts(system.nv);
  batch.t = 0.3;
  for (int lane = 0; lane < count; ++lane) {
    State& state = states.emplace_back(Random(seed + lane).state(system));
    state.t = batch.t;
    batch.set(lane, state);
    EXPECT_EQ(batch.state(lane).q, state.q);
    for (int i = 0; i < system.nv; ++i) given[i].set(lane, std::cos(i + lane));
  }
  ASSERT_TRUE(accelerate(system, p, batch, w, given.data())) << which;
  const Eigen::VectorX<Lanes> a = w.a, drive_efforts = w.drive_efforts, power = w.group_power,
                              kinetic = w.terms.group_kinetic, potential = w.terms.group_potential;
  BatchWorkspace in_turn(system);  // energies only once accelerations are there
  ASSERT_TRUE(accelerate(system, p, batch, in_turn, given.data(), Wanted::accelerations)) << which;
  find_energies(system, p, batch, in_turn);
  for (int lane = 0; lane < count; ++lane) {
    if (w.articulation.first_swing == w.articulation.joints.size()) {
      EXPECT_EQ(lane_of(in_turn.a, lane), lane_of(a, lane)) << which;
    } else {  // by a pendulum's equation
      EXPECT_LT(relative(lane_of(in_turn.a, lane), lane_of(a, lane)), bound) << which;
    }
    EXPECT_EQ(lane_of(in_turn.terms.group_kinetic, lane), lane_of(kinetic, lane)) << which;
    EXPECT_EQ(lane_of(in_turn.terms.group_potential, lane), lane_of(potential, lane)) << which;
  }
  inverse_dynamics(system, p, batch, a, w, efforts);
  find_mass_matrix(system, p, batch, w);
  for (int lane = 0; lane < count; ++lane) {
    const State& s = states[lane];
    const Eigen::VectorXd applied = lane_of(given, lane);
    ASSERT_FALSE(accelerate(system, p, s.t, s.q.data(), s.v.data(), {}, one, applied.data())) << which;
    EXPECT_LT(relative(lane_of(a, lane), one.a), bound) << which;
    EXPECT_LT(relative(lane_of(drive_efforts, lane), one.drive_efforts), bound) << which;
    if (power.size() > 0) {  // sums over the drives, which may nearly cancel
      const double part = one.group_power.cwiseAbs().maxCoeff() +
                          (system.driven_nv > 0 ? one.drive_efforts.cwiseAbs().maxCoeff() *
                                                      one.kinematics.u.cwiseAbs().maxCoeff()
                                                : 0);
      EXPECT_LT((lane_of(power, lane) - one.group_power).cwiseAbs().maxCoeff(), bound * std::max(part, 1e-3))
          << which;
    }
    EXPECT_LT(relative(lane_of(kinetic, lane), one.terms.group_kinetic), 1e-12) << which;
    EXPECT_LT(relative(lane_of(potential, lane), one.terms.group_potential), 1e-12) << which;
    // inverse dynamics of the accelerations gives the given efforts
    ASSERT_FALSE(update_terms(system, p, s.t, s.q.data(), s.v.data(), one)) << which;
    Rows A(system.nv, system.nv);
    for (int i = 0; i < system.nv; ++i)
      for (int j = 0; j <= i; ++j) A(i, j) = A(j, i) = w.terms.A(i, j)[lane];
    const Rows lower = one.terms.A.topLeftCorner(system.nv, system.nv);
    EXPECT_LT(relative(A, lower.selfadjointView<Eigen::Lower>()), 1e-12) << which;
    const double part = A.cwiseAbs().maxCoeff() * lane_of(a, lane).cwiseAbs().maxCoeff() +
                        one.terms.B.cwiseAbs().maxCoeff() + one.terms.Q.cwiseAbs().maxCoeff();
    EXPECT_LT((lane_of(efforts, lane) - applied).cwiseAbs().maxCoeff(), 1e-12 * part) << which;
  }
}

/// The bound for compare(): 10 units of rounding times the largest condition of the free part of A in its
/// states.
double rounding(const System& system, unsigned seed) {
  Workspace w(system);
  double condition = 1;
  for (int lane = 0; lane < count; ++lane) {
    const State s = Random(seed + lane).state(system);
    if (update_terms(system, system.parameters, 0.3, s.q.data(), s.v.data(), w)) return INFINITY;
    const Rows A = Rows(w.terms.A.selfadjointView<Eigen::Lower>()).topLeftCorner(system.nv, system.nv);
    const Eigen::VectorXd values = A.jacobiSvd().singularValues();
    condition = std::max(condition, values[0] / values[values.size() - 1]);
  }
  return 10 * 2.3e-16 * condition;
}

class BatchInRegisters : public EachWidth {};
INSTANTIATE_TEST_SUITE_P(OfEachWidth, BatchInRegisters, ::testing::ValuesIn(all_widths()));

TEST_P(BatchInRegisters, LanesEqualSingleStatesOnRegularScenes) {
  compare(compiled(chain(7, true)), 1, 1e-12, "chain");
  compare(compiled(bars(9)), 2, 1e-12, "bars");
  compare(compiled(roundabout()), 3, 1e-12, "roundabout");
  for (unsigned seed = 0; seed < 8; ++seed)
    compare(compiled(random_tree(seed, {.balls = true, .drives = true})), seed, 1e-12,
            fmt::format("tree {}", seed));
  for (unsigned seed = 0; seed < 4; ++seed) {  // without drives coordinates are read where they lie
    Scene scene = random_tree(seed, {.balls = true});
    for (Solid& solid : scene.solids) solid.switches.back().armature = 0.1;
    compare(compiled(scene), seed, 1e-12, fmt::format("free tree {}", seed));
  }
}

TEST_P(BatchInRegisters, LanesEqualSingleStatesOnRandomScenes) {
  int compared = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    const auto system = compile(RandomScene(seed, 10, false).scene);
    if (!system || system->nv == 0) continue;
    const double bound = rounding(*system, seed);
    if (bound > 2.3e-7) continue;
    compare(*system, seed, bound + 1e-12, fmt::format("seed {}", seed));
    ++compared;
  }
  EXPECT_GT(compared, 15);
}

/// Eight states, each with inertials of its own and given efforts.
struct OwnInertials {
  OwnInertials(const System& of, unsigned seed) : system(of), batch(of), w(of), each(count), given(of.nv) {
    Random random(seed);
    for (int lane = 0; lane < count; ++lane) {
      batch.set(lane, Random(seed + lane).state(system));
      for (int i = 0; i < system.nv; ++i) given[i].set(lane, random.number(-1, 1));
      each[lane].resize(system.bodies.size());
      for (std::size_t b = 1; b < system.bodies.size(); ++b)
        if (system.bodies[b].massive) set(lane, int(b), random.inertia().inertial());
    }
  }
  void set(int lane, int body, const Inertial& inertial) {
    each[lane][body] = inertial;
    w.set_inertial(lane, body, inertial);
  }

  /// Compares `a` from accelerate() with `p`, with the given efforts (`acted`) or without, with each single
  /// state.
  void expect_single(const Parameters& p, const Eigen::VectorX<Lanes>& a, bool acted = true) {
    for (int lane = 0; lane < count; ++lane) {
      Parameters own = p;
      own.inertials = each[lane];
      const State state = batch.state(lane);
      const Eigen::VectorXd applied = lane_of(given, lane);
      Workspace one(system, Equations::recursive);
      ASSERT_FALSE(accelerate(system, own, state.t, state.q.data(), state.v.data(), {}, one,
                              acted ? applied.data() : nullptr));
      EXPECT_LT(relative(lane_of(a, lane), one.a), 1e-12);
      EXPECT_NEAR(w.terms.kinetic[lane], one.terms.kinetic, 1e-12 * (1 + std::abs(one.terms.kinetic)));
      EXPECT_NEAR(w.terms.potential[lane], one.terms.potential, 1e-12 * (1 + std::abs(one.terms.potential)));
    }
  }

  const System& system;
  BatchState batch;
  BatchWorkspace w;
  std::vector<std::vector<Inertial>> each;  ///< [lane][body]
  Eigen::VectorX<Lanes> given;
};

TEST_P(BatchInRegisters, LanesUseTheirOwnInertials) {
  const System system = compiled(random_tree(3, {.balls = true}));
  OwnInertials own(system, 5);
  for (const bool acted : {true, false}) {
    ASSERT_TRUE(accelerate(system, system.parameters, own.batch, own.w, acted ? own.given.data() : nullptr));
    own.expect_single(system.parameters, own.w.a, acted);
  }
}

/// Bars that swing about oblique axes of the world, some with rotors; a chain; and a bar that carries
/// another.
Scene bars_and_chain() {
  Scene scene = chain(3, true);
  Random random(8);
  for (int i = 0; i < 6; ++i) {
    Switch turn = hinge(fmt::format("swing{}", i), random.direction());
    if (i % 2 == 0) turn.armature = 0.3;
    const Pose seat{rotation_matrix(random.turn()), random.vector(2)};
    scene.solids.push_back(solid(fmt::format("bar{}", i), "world", {fixed(seat.p, seat.R), turn},
                                 {random.inertia().inertial()}));
  }
  scene.solids.push_back(
      solid("below", "bar5", {hinge("last", Eigen::Vector3d::UnitX())}, {random.inertia().inertial()}));
  return scene;
}

// When only accelerations are wanted, independent bars use the pendulum's equation.
TEST_P(BatchInRegisters, IndependentBarsWithOwnInertialsEqualSingleStates) {
  const System system = compiled(bars_and_chain());
  compare(system, 20, 1e-12, "bars and a chain");
  OwnInertials own(system, 30);
  BatchWorkspace& w = own.w;
  EXPECT_EQ(w.articulation.joints.size() - w.articulation.first_swing, 5U);
  const auto expect_single = [&](const Parameters& p) {
    ASSERT_TRUE(accelerate(system, p, own.batch, w, own.given.data(), Wanted::accelerations));
    EXPECT_TRUE(w.articulation.swung);
    const Eigen::VectorX<Lanes> a = w.a;
    find_energies(system, p, own.batch, w);
    EXPECT_FALSE(w.articulation.swung);
    own.expect_single(p, a);
  };
  expect_single(system.parameters);
  Parameters moved = system.parameters;  // nothing cached from before is used
  moved.gravity = {1, 2, -3};
  for (double& armature : moved.armatures) armature *= 2;
  expect_single(moved);
}

/// Bodies on ball joints that carry nothing: a general one, one held at its gravity centre, an upright one,
/// one so thin that its ball is eliminated axis by axis, one on the world, and one at its parent's origin.
Scene pendants() {
  Random random(11);
  Scene scene;
  scene.solids = {solid("beam", "world", {hinge("turn", random.direction())}, {random.inertia().inertial()})};
  const Inertial any = random.inertia().inertial();
  Inertial centred = any, upright = any, thin = any;
  centred.centre.setZero();
  upright.centre = {0, 0, -0.3};
  upright.tensor = Eigen::Vector3d(0.2, 0.3, 0.1).asDiagonal();
  thin.centre = {0, 0, 0.5};
  thin.tensor = Eigen::Vector3d(1, 1, 5e-5).asDiagonal();
  for (const auto& [name, inertial] :
       {std::pair{"any", any}, {"centred", centred}, {"upright", upright}, {"thin", thin}})
    scene.solids.push_back(
        solid(name, "beam", {fixed(random.vector(1)), ball(std::string("ball_") + name)}, {inertial}));
  scene.solids.push_back(solid("free", "world", {ball("ball_free")}, {any}));
  scene.solids.push_back(solid("at", "beam", {ball("ball_at")}, {any}));
  return scene;
}

TEST_P(BatchInRegisters, PendantsWithOwnInertialsEqualSingleStates) {
  const System system = compiled(pendants());
  compare(system, 40, rounding(system, 40) + 1e-12, "pendants");
  Scene pulled = pendants();
  pulled.efforts = {{"pull", Force{{"any", {0.1, -0.2, 0.3}}, {2, 3, -1}}},
                    {"twist", Torque{{"centred"}, {1, -2, 3}}}};
  const System by_forces = compiled(pulled);
  compare(by_forces, 41, rounding(by_forces, 41) + 1e-12, "pendants that are pulled");
  OwnInertials own(system, 50);
  const auto expect_single = [&](bool acted, int hanging) {
    const Lanes* const given = acted ? own.given.data() : nullptr;
    ASSERT_TRUE(accelerate(system, system.parameters, own.batch, own.w, given));
    own.expect_single(system.parameters, own.w.a, acted);
    EXPECT_EQ(std::ranges::count_if(own.w.articulation.links, [](const auto& link) { return link.hangs; }),
              hanging);
  };
  for (const bool acted : {true, false}) expect_single(acted, 6);
  // a thin body in one lane sends all its lanes through the general elimination
  own.set(3, 2, {1, {0.4, 0, 0}, Eigen::Vector3d(5e-5, 1, 1).asDiagonal()});
  for (const bool acted : {true, false}) expect_single(acted, 5);
}

// An inertia that may be rounding goes to the single-state code: a needle's inertia about its own axis, tiny
// and zero.
TEST_P(BatchInRegisters, NearlySingularInertiaFallsBackToSingleStates) {
  const System system = compiled(bars(3));
  const Eigen::VectorX<Lanes> given = Eigen::VectorX<Lanes>::Constant(3, Lanes(1e-3));
  const Eigen::VectorXd applied = lane_of(given, 0);
  for (const double about : {1e-18, 0.0}) {
    BatchState batch(system);
    BatchWorkspace w(system);
    System own = system;
    Inertial& needle = own.parameters.inertials[2];
    needle.centre.setZero();
    needle.tensor = Eigen::Vector3d(1, about, 1).asDiagonal();  // about y, the axis
    w.set_inertial(3, 2, needle);
    const bool solved = accelerate(system, system.parameters, batch, w, given.data(), Wanted::accelerations);
    EXPECT_FALSE(w.together);
    EXPECT_FALSE(w.articulation.swung);
    EXPECT_EQ(solved, about > 0);
    for (int lane = 0; lane < count; ++lane) {
      const State state = batch.state(lane);
      Workspace one(system, Equations::recursive);
      const Parameters& p = (lane == 3 ? own : system).parameters;
      const Fault fault =
          accelerate(system, p, state.t, state.q.data(), state.v.data(), {}, one, applied.data());
      EXPECT_EQ(bool(w.faults[lane]), bool(fault));
      if (!fault) {
        EXPECT_LT(relative(lane_of(w.a, lane), one.a), 1e-12);
      }
    }
  }
}

TEST(Batch, NamesASingularLane) {
  const System system = compiled(aligning_turns());
  BatchState batch(system);
  BatchWorkspace w(system);
  for (int lane = 0; lane < count; ++lane) {
    State state = Random(lane).state(system);
    state.q[1] = lane == 3 ? 0 : 0.3 + lane;
    batch.set(lane, state);
  }
  EXPECT_FALSE(accelerate(system, system.parameters, batch, w));
  for (int lane = 0; lane < count; ++lane) {
    EXPECT_EQ(bool(w.faults[lane]), lane == 3);
    if (lane == 3) continue;
    const Eigen::VectorXd a = need(evaluate(system, batch.state(lane))).acceleration;
    EXPECT_LT(relative(lane_of(w.a, lane), a), 1e-12);
  }
  batch.v[0].set(5, NAN);
  EXPECT_FALSE(accelerate(system, system.parameters, batch, w));
  EXPECT_TRUE(w.faults[5].kind == Fault::Kind::not_finite);
}

struct Nothing {
  template <class T>
  void apply(EffortPass<T>&) const {}
};

TEST(Batch, RefusesScenesThatAreNotSmooth) {
  Scene scene = chain(3, false);
  scene.constraints = {{"tie", CoordinateCoupling{{{"h0"}, {"h1"}}, {1, -1}, constant(0)}}};
  const auto refused = check_batch(compiled(scene));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().where, "constraint 'tie'");
  scene = chain(3, false);
  scene.efforts = {{"mine", OwnEffort({{"l0"}}, {}, Nothing{})}};
  EXPECT_EQ(check_batch(compiled(scene)).error().where, "effort 'mine'");
}

}  // namespace
}  // namespace borelli::test
