// Derivatives of the dynamics against finite differences, against dual numbers through the whole engine and
// through the articulated-body recursion, and against MuJoCo's accelerations.
#include "dynamics/equations/derivatives.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

#include "dual_residuals.hpp"
#include "dynamics/constraints/local_coordinates.hpp"
#include "dynamics/equations/batch.hpp"
#include "dynamics/equations/inverse_dynamics.hpp"
#include "dynamics/equations/state_derivatives.hpp"
#include "each_width.hpp"
#include "random_scene.hpp"

#ifdef BORELLI_MUJOCO
#include "mujoco_twin.hpp"
#endif

namespace borelli::test::derivatives_test {
namespace {

// Five-point central differences with step h: h^4 / 30 times fifth derivatives (up to 1e4 for these scenes)
// and rounding (1e-13 after the solution, of accelerations) over h.
constexpr double h = 1e-3, tolerance = 1e-7;

template <class Function>
Eigen::VectorXd difference(const Function& f) {
  const Eigen::VectorXd a = f(-2 * h), b = f(-h), c = f(h), d = f(2 * h);
  return (a - 8 * b + 8 * c - d) / (12 * h);
}

double relative(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  if (b.size() == 0) return 0;
  return (a - b).cwiseAbs().maxCoeff() / std::max(1.0, b.cwiseAbs().maxCoeff());
}

State moved(const System& system, State state, const Eigen::VectorXd& x) {
  const Eigen::VectorXd q = state.q;
  from_local_coordinates(system, q.data(), x.data(), state.q.data());
  return state;
}

/// The system with one of a body's ten inertial numbers changed by s.
System changed(System system, int body, int number, double s) {
  Inertial& it = system.parameters.inertials[body];
  constexpr int row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2};
  if (number == 0) it.mass += s;
  if (number >= 1 && number <= 3) it.centre[number - 1] += s;
  if (number >= 4) {
    it.tensor(row[number - 4], column[number - 4]) += s;
    if (number >= 7) it.tensor(column[number - 4], row[number - 4]) += s;
  }
  return system;
}

std::vector<int> massive(const System& system) {
  std::vector<int> out;
  for (int b = 1; b < int(system.bodies.size()); ++b)
    if (system.bodies[b].massive) out.push_back(b);
  return out;
}

/// The accelerations, then the multipliers.
Eigen::VectorXd solution(const System& system, const State& state, const Eigen::VectorXd& efforts) {
  const Evaluation e = need(evaluate(system, state, efforts));
  Eigen::VectorXd out(e.acceleration.size() + e.multipliers.size());
  out << e.acceleration, e.multipliers;
  return out;
}

Eigen::MatrixXd stacked(const Rows& a, const Rows& lambda) {
  Eigen::MatrixXd out(a.rows() + lambda.rows(), a.cols());
  out << a, lambda;
  return out;
}

void compare_forward(const System& system, const State& state, const std::string& which) {
  const int n = system.nv;
  const Eigen::VectorXd efforts = Eigen::VectorXd::LinSpaced(n, -1, 2);
  const ForwardDerivatives exact = need(forward_derivatives(system, state, efforts));
  Eigen::MatrixXd by_q(n + system.rows, n), by_v = by_q, by_efforts = by_q;
  for (int i = 0; i < n; ++i) {
    const Eigen::VectorXd unit = Eigen::VectorXd::Unit(n, i);
    by_q.col(i) =
        difference([&](double s) { return solution(system, moved(system, state, s * unit), efforts); });
    by_v.col(i) = difference([&](double s) {
      State other = state;
      other.v += s * unit;
      return solution(system, other, efforts);
    });
    by_efforts.col(i) = difference([&](double s) { return solution(system, state, efforts + s * unit); });
  }
  EXPECT_LT(relative(stacked(exact.acceleration_by_q, exact.multipliers_by_q), by_q), tolerance) << which;
  EXPECT_LT(relative(stacked(exact.acceleration_by_v, exact.multipliers_by_v), by_v), tolerance) << which;
  EXPECT_LT(relative(stacked(exact.acceleration_by_efforts, exact.multipliers_by_efforts), by_efforts),
            tolerance)
      << which;
  const std::vector<int> bodies = massive(system);
  ASSERT_EQ(exact.inertials.size(), bodies.size());
  Eigen::MatrixXd by_inertia(n + system.rows, 10 * bodies.size());
  for (int i = 0; i < int(bodies.size()); ++i)
    for (int k = 0; k < 10; ++k)
      by_inertia.col(10 * i + k) =  // by a smaller step: moments are as small as 1e-3 here
          difference(
              [&](double s) { return solution(changed(system, bodies[i], k, 0.03 * s), state, efforts); }) /
          0.03;
  EXPECT_LT(relative(stacked(exact.acceleration_by_inertia, exact.multipliers_by_inertia), by_inertia),
            tolerance)
      << which;
}

bool well_conditioned(const System& system, const State& state) {
  const auto e = evaluate(system, state);
  if (!e) return false;
  const Eigen::VectorXd s = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(e->mass_matrix).eigenvalues();
  return s[0] > 1e-3;  // kg or kg m^2
}

void compare_random(bool constrained) {
  int compared = 0;
  for (unsigned seed = 0; seed < 30; ++seed) {
    const auto system = compile(RandomScene(seed, 6, constrained).scene);
    if (!system || system->nv == 0) continue;
    State state = Random(seed + 900).state(*system);
    state.t = 0.3;
    if (!well_conditioned(*system, state)) continue;
    if (constrained) {
      const Evaluation e = need(evaluate(*system, state));
      const Eigen::VectorXd s = e.constraint_jacobian.jacobiSvd().singularValues();
      if (s[s.size() - 1] < 0.03) continue;  // differences fail near a singular position
    }
    compare_forward(*system, state, fmt::format("seed {}", seed));
    ++compared;
  }
  EXPECT_GT(compared, 8);
}

TEST(Derivatives, OfForwardDynamicsMatchDifferences) { compare_random(false); }
TEST(Derivatives, OfConstrainedForwardDynamicsMatchDifferences) { compare_random(true); }

TEST(Derivatives, OfInverseDynamicsMatchDifferences) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    const auto system = compile(RandomScene(seed, 6, false).scene);
    if (!system || system->nv == 0) continue;
    State state = Random(seed + 900).state(*system);
    state.t = 0.3;
    const int n = system->nv;
    const Eigen::VectorXd a = Eigen::VectorXd::LinSpaced(n, -3, 2);
    const auto efforts = [&](const System& of, const State& at, const Eigen::VectorXd& acceleration) {
      return need(inverse_dynamics(of, at, acceleration)).efforts;
    };
    const InverseDynamics exact = need(inverse_dynamics(*system, state, a));
    Eigen::MatrixXd by_q(n, n), by_v(n, n), by_a(n, n);
    for (int i = 0; i < n; ++i) {
      const Eigen::VectorXd unit = Eigen::VectorXd::Unit(n, i);
      by_q.col(i) =
          difference([&](double s) { return efforts(*system, moved(*system, state, s * unit), a); });
      by_v.col(i) = difference([&](double s) {
        State other = state;
        other.v += s * unit;
        return efforts(*system, other, a);
      });
      by_a.col(i) = difference([&](double s) { return efforts(*system, state, a + s * unit); });
    }
    EXPECT_LT(relative(exact.efforts_by_q, by_q), tolerance) << seed;
    EXPECT_LT(relative(exact.efforts_by_v, by_v), tolerance) << seed;
    EXPECT_LT(relative(exact.efforts_by_a, by_a), tolerance) << seed;
    const std::vector<int> bodies = massive(*system);
    for (int i = 0; i < int(bodies.size()); ++i)
      for (int k = 0; k < 10; ++k) {
        const Eigen::VectorXd one =
            difference([&](double s) { return efforts(changed(*system, bodies[i], k, s), state, a); });
        EXPECT_LT(relative(exact.efforts_by_inertia.col(10 * i + k), one), tolerance) << seed << ", " << k;
      }
    // forward dynamics inverts it: tau gives a
    const auto back = evaluate(*system, state, exact.efforts);
    if (!back || !well_conditioned(*system, state)) continue;
    EXPECT_LT(relative(back->acceleration, a), 1e-10) << seed;
  }
}

// A user's function; its third derivatives come from differences along the motion.
TEST(Derivatives, IncludeAUsersFunction) {
  Scene scene = chain(4, true, 0.4);
  FunctionConstraint function;
  function.coordinates = {{"h0"}, {"h2"}};
  function.points = {{"l3", {0, 0, -1}}};
  // h = sin(q0) q2^2 + z^3 + t x - 0.3
  function.function = [](double t, const Eigen::VectorXd& x, FunctionDerivatives& d) {
    d.value = std::sin(x[0]) * x[1] * x[1] + std::pow(x[4], 3) + t * x[2] - 0.3;
    d.gradient << std::cos(x[0]) * x[1] * x[1], 2 * std::sin(x[0]) * x[1], t, 0, 3 * x[4] * x[4];
    d.hessian(0, 0) = -std::sin(x[0]) * x[1] * x[1];
    d.hessian(0, 1) = d.hessian(1, 0) = 2 * std::cos(x[0]) * x[1];
    d.hessian(1, 1) = 2 * std::sin(x[0]);
    d.hessian(4, 4) = 6 * x[4];
    d.rate = x[2];
    d.gradient_rate[2] = 1;
  };
  scene.constraints = {{"own", function}};
  const System system = compiled(scene);
  State state = Random(4).state(system);
  state.t = 0.7;
  compare_forward(system, state, "a function");
}

/// A user's law: a spring in the square of the distance of two points, with a coordinate's rate as a damper.
struct OwnSpring {
  template <class T>
  void apply(EffortPass<T>& pass) const {
    const auto a = pass.point(0, {0.1, 0.2, 0.3}), b = pass.point(1, {0, 0.2, 0});
    const Eigen::Vector3<T> r = b.p - a.p;
    const Eigen::Vector3<T> f = r.squaredNorm() * r;
    pass.force(0, a.p, f);
    pass.force(1, b.p, -f);
    pass.coordinate(0, -pass.rate(0) * abs(pass.rate(0)));
  }
  static double abs(double x) { return std::abs(x); }
  static DualNumber abs(const DualNumber& x) { return borelli::abs(x); }
};

Scene scene_of_every_effort() {
  Scene scene = random_tree(4, {.balls = true});
  scene.efforts = {{"stop", LimitSpring{{"c20"}, 30, 0.3, {{-0.01, 0.01}}}},
                   {"stops", LimitSpring{{"c51"}, 20, 0.3, {{-0.1, 0.1}, {-0.1, 0.2}, {-0.05, 0.05}}}},
                   {"scalar", PdController{{"c40"}, 30, 2, {Sine{}}}},
                   {"ball", PdController{{"c11"}, 10, 2, {Sine{}, constant(0.1), Polynomial{{0.1, 0.5}}}}},
                   {"air", Drag{{"s3", {0.1, 0, 0.2}}, 0.3, 0.4}},
                   {"oil", AngularDrag{{"s4"}, 0.3, 0.4}},
                   {"own", OwnEffort({{"s2"}, {"s5"}}, {{"c01"}}, OwnSpring{})}};
  return scene;
}

TEST(Derivatives, IncludeEveryEffort) {
  const System system = compiled(scene_of_every_effort());
  State state = Random(4).state(system);
  state.t = 0.7;
  ASSERT_TRUE(well_conditioned(system, state));
  compare_forward(system, state, "efforts");
}

// Rounding of sums of about a hundred terms, relative to the largest entry.
constexpr double rounding = 1e-12;

/// Compares at accelerations and multipliers that do not solve the equations, so that every term counts.
void compare_with_duals(const System& system, const State& state, StateDerivatives& derivatives,
                        const std::string& which) {
  const Eigen::VectorXd a = Eigen::VectorXd::LinSpaced(system.nv, -3, 2);
  const Eigen::VectorXd lambda = Eigen::VectorXd::LinSpaced(system.rows, 2, -1);
  find_residual_derivatives(system, system.parameters, state.t, state.q.data(), state.v.data(), a.data(),
                            lambda, derivatives);
  DualResiduals duals(system, state, a, lambda);
  Eigen::MatrixXd dr, dc;
  duals.differentiate(true, dr, dc);
  EXPECT_LT(relative(derivatives.by_q(), dr), rounding) << which;
  EXPECT_LT(relative(derivatives.c_by_q(), dc), rounding) << which;
  duals.differentiate(false, dr, dc);
  EXPECT_LT(relative(derivatives.by_v(), dr), rounding) << which;
  EXPECT_LT(relative(derivatives.c_by_v(), dc), rounding) << which;
}

TEST(Derivatives, EqualDualNumbersInRandomScenes) {
  int compared = 0;
  for (const bool constrained : {false, true})
    for (unsigned seed = 0; seed < 30; ++seed) {
      const auto system = compile(RandomScene(seed, 9, constrained).scene);
      if (!system || system->nv == 0) continue;
      StateDerivatives derivatives(*system);
      for (unsigned other : {900, 400}) {  // nothing cached from the first state is used
        State state = Random(seed + other).state(*system);
        state.t = 0.3;
        compare_with_duals(*system, state, derivatives, fmt::format("seed {} of {}", seed, constrained));
      }
      ++compared;
    }
  EXPECT_GT(compared, 30);
}

/// Trees of every switch, some driven; far from the origin if asked.
Scene tree_of_every_switch(unsigned seed, double far) {
  Random random(seed);
  Scene scene;
  const auto guide = [&] {
    Guided out;
    out.parts = {{GuidedPart::Kind::rotation, random.direction(), Polynomial{{0.1, 1, 0.3, 0.2}}},
                 {GuidedPart::Kind::translation, random.direction(), Sine{0.5, 1.3, 0.2, 0.1}},
                 {GuidedPart::Kind::rotation, random.direction(), Polynomial{{0.3, 0.5, -0.3, 0.1}}}};
    return out;
  };
  for (int i = 0; i < 7; ++i) {
    Vector3d place = random.vector(0.5);
    if (i == 0) place[0] += far;
    std::vector<Switch> switches{fixed(place, rotation_matrix(random.turn()))};
    for (int j = 0; j < 2; ++j) {
      Switch one = hinge(fmt::format("c{}{}", i, j), random.direction());
      const int kind = (2 * i + j + int(seed)) % 6;
      if (kind == 0) one.kind = Screw{random.direction(), 0.2};
      if (kind == 1) one.kind = guide();
      if (kind == 2) one = slide(one.coordinate, random.direction());
      if (kind == 3 && j == 1) one = ball(one.coordinate);
      if (kind == 5) {
        one = ball(one.coordinate);
        one.kind = OnEllipsoid{Vector3d(0.4, 0.7, 0.5)};
      }
      if ((i == 2 || i == 5) && j == 1 && kind != 3 && kind != 5) one = driven(one, Sine{0.3, 1.1, 0.2, 0.1});
      switches.push_back(one);
    }
    scene.solids.push_back(solid(fmt::format("s{}", i),
                                 i ? fmt::format("s{}", random.integer(0, i - 1)) : "world", switches,
                                 {random.inertia().inertial()}));
    scene.solids.back().switches[1].armature = 0.1 * i;
  }
  return scene;
}

TEST(Derivatives, EqualDualNumbersForEverySwitch) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    const System system = compiled(tree_of_every_switch(seed, 0));
    StateDerivatives derivatives(system);
    State state = Random(seed + 50).state(system);
    state.t = 0.4;
    compare_with_duals(system, state, derivatives, fmt::format("seed {}", seed));
  }
}

TEST(Derivatives, EqualDualNumbersForEveryEffort) {
  const System system = compiled(scene_of_every_effort());
  StateDerivatives derivatives(system);
  for (unsigned seed = 0; seed < 5; ++seed) {
    State state = Random(seed).state(system);
    state.t = 0.7;
    compare_with_duals(system, state, derivatives, fmt::format("seed {}", seed));
  }
}

class DerivativesOfBatches : public EachWidth {};
INSTANTIATE_TEST_SUITE_P(Widths, DerivativesOfBatches, ::testing::ValuesIn(all_widths()));

TEST_P(DerivativesOfBatches, EqualThoseOfEachState) {
  for (unsigned seed = 0; seed < 5; ++seed) {
    const System system = compiled(tree_of_every_switch(seed, 0));
    BatchState batch(system);
    BatchWorkspace workspace(system);
    InverseDerivativesOf<Lanes> of_batch(system);
    StateDerivatives derivatives(system);
    Eigen::VectorX<Lanes> a(system.nv);
    std::vector<State> states;
    for (int lane = 0; lane < Lanes::count; ++lane) {
      states.push_back(Random(10 * seed + unsigned(lane)).state(system));
      batch.set(lane, states.back());
      for (int i = 0; i < system.nv; ++i) a[i].set(lane, std::cos(i + lane));
    }
    find_inverse_derivatives(system, system.parameters, batch, a, workspace, of_batch);
    for (int lane = 0; lane < Lanes::count; ++lane) {
      const State& state = states[std::size_t(lane)];
      const auto of_lane = [&](const auto& entries) {
        Rows out(entries.rows(), entries.cols());
        for (Eigen::Index i = 0; i < out.rows(); ++i)
          for (Eigen::Index j = 0; j < out.cols(); ++j) out(i, j) = entries(i, j)[lane];
        return out;
      };
      find_residual_derivatives(system, system.parameters, state.t, state.q.data(), state.v.data(),
                                of_lane(a).data(), Eigen::VectorXd(), derivatives);
      EXPECT_LT(relative(of_lane(of_batch.by_state), derivatives.inverse.by_state), rounding) << seed;
      EXPECT_LT(relative(of_lane(of_batch.A), derivatives.inverse.A), rounding) << seed;
      EXPECT_LT(relative(of_lane(of_batch.needed), derivatives.inverse.needed), rounding) << seed;
    }
  }
}

// The same scene a million metres away: only the rounding of positions, 1e-10 m, may show.
TEST(Derivatives, LoseNoDigitsFarFromTheOrigin) {
  const System near = compiled(tree_of_every_switch(3, 0)), far = compiled(tree_of_every_switch(3, 1e6));
  const State state = Random(53).state(near);
  const Eigen::VectorXd a = Eigen::VectorXd::LinSpaced(near.nv, -3, 2);
  const InverseDynamics here = need(inverse_dynamics(near, state, a)),
                        there = need(inverse_dynamics(far, state, a));
  EXPECT_LT(relative(there.efforts_by_q, here.efforts_by_q), 1e-9);
  EXPECT_LT(relative(there.efforts_by_v, here.efforts_by_v), 1e-9);
}

// A da - L^T dlambda = -dr and L da = -dc, with dr and dc from dual numbers.
TEST(Derivatives, OfAccelerationsSolveTheImplicitEquations) {
  int compared = 0;
  for (unsigned seed = 0; seed < 30; ++seed) {
    const auto system = compile(RandomScene(seed, 8, seed % 2 == 1).scene);
    if (!system || system->nv == 0) continue;
    State state = Random(seed + 900).state(*system);
    state.t = 0.3;
    if (!well_conditioned(*system, state)) continue;
    const Evaluation e = need(evaluate(*system, state));
    if (system->rows > 0) {
      const Eigen::VectorXd s = e.constraint_jacobian.jacobiSvd().singularValues();
      if (s[s.size() - 1] < 0.03) continue;  // dependent rows have no unique multipliers
    }
    const ForwardDerivatives d = need(forward_derivatives(*system, state));
    DualResiduals duals(*system, state, e.acceleration, e.multipliers);
    const auto compare = [&](bool by_q, const Rows& da, const Rows& dlambda) {
      Eigen::MatrixXd dr, dc;
      duals.differentiate(by_q, dr, dc);
      EXPECT_LT(relative(e.constraint_jacobian.transpose() * dlambda - e.mass_matrix * da, dr), 1e-10)
          << seed;
      EXPECT_LT(relative(-e.constraint_jacobian * da, dc), 1e-10) << seed;
    };
    compare(true, d.acceleration_by_q, d.multipliers_by_q);
    compare(false, d.acceleration_by_v, d.multipliers_by_v);
    ++compared;
  }
  EXPECT_GT(compared, 10);
}

// The implicit-function formula against dual numbers through the articulated-body recursion.
TEST(Derivatives, MatchTheArticulatedBodyMethod) {
  const System system = compiled(random_tree(2, {.balls = true, .drives = true}));
  State state = Random(8).state(system);
  state.t = 0.2;
  const ForwardDerivatives exact = need(forward_derivatives(system, state));
  KinematicsOf<DualNumber> k(system, Equations::recursive);
  EffortSumsOf<DualNumber> efforts(system);
  ArticulationOf<DualNumber> articulation(system);
  InertialsOf<DualNumber> inertials;
  for (const Inertial& one : system.parameters.inertials)
    inertials.push_back({one.mass, one.centre.cast<DualNumber>(), one.tensor.cast<DualNumber>()});
  const Eigen::VectorX<DualNumber> q = state.q.cast<DualNumber>();
  for (int i = 0; i < system.nv; ++i) {
    Eigen::VectorX<DualNumber> v = state.v.cast<DualNumber>(), a(system.nv), drives(system.driven_nv);
    v[i].d[0] = 1;
    move_links<DualNumber>(system, system.parameters, inertials, state.t, q.data(), v.data(), nullptr, k,
                           articulation);
    find_bodies<DualNumber>(system, system.parameters, inertials, k, articulation);
    ASSERT_TRUE(find_accelerations<DualNumber>(system, system.parameters, inertials, k, &efforts, nullptr,
                                               articulation, a.data(), drives.data()));
    for (int j = 0; j < system.nv; ++j)  // rounding, times A's condition of about 1e3
      EXPECT_NEAR(a[j].d[0], exact.acceleration_by_v(j, i),
                  1e-11 * (1 + exact.acceleration_by_v.cwiseAbs().maxCoeff()));
  }
}

TEST(Derivatives, RefuseVectorsOfTheWrongSize) {
  const System system = compiled(chain(2, false));
  EXPECT_FALSE(inverse_dynamics(system, system.initial, Eigen::VectorXd::Zero(3)));
  State wrong = system.initial;
  wrong.q[0] = NAN;
  const auto refused = forward_derivatives(system, wrong);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().where, "coordinate 'h0'");
}

#ifdef BORELLI_MUJOCO
// Against differences of MuJoCo's accelerations along its tangent coordinates, which equal ours.
TEST(Derivatives, MatchMuJoCo) {
  for (Joints joints : {Joints::hinges, Joints::balls, Joints::mixed, Joints::free}) {
    const Twin twin = TwinMaker(3, joints, 6).make();
    const System system = compiled(twin.scene);
    const Mujoco mujoco = Mujoco::of(twin.xml);
    const State state = Random(12).state(system);
    const ForwardDerivatives exact = need(forward_derivatives(system, state));
    const int n = system.nv;
    const auto acceleration = [&](const Eigen::VectorXd& x, const Eigen::VectorXd& v) {
      std::copy(state.q.begin(), state.q.end(), mujoco.data->qpos);
      mj_integratePos(mujoco.model, mujoco.data->qpos, x.data(), 1);
      for (int i = 0; i < n; ++i) mujoco.data->qvel[i] = state.v[i] + v[i];
      mj_forward(mujoco.model, mujoco.data);
      return Eigen::VectorXd(Eigen::Map<Eigen::VectorXd>(mujoco.data->qacc, n));
    };
    const Eigen::VectorXd zero = Eigen::VectorXd::Zero(n);
    Eigen::MatrixXd by_q(n, n), by_v(n, n);
    for (int i = 0; i < n; ++i) {
      const Eigen::VectorXd unit = Eigen::VectorXd::Unit(n, i);
      by_q.col(i) = difference([&](double s) { return acceleration(s * unit, zero); });
      by_v.col(i) = difference([&](double s) { return acceleration(zero, s * unit); });
    }
    EXPECT_LT(relative(exact.acceleration_by_q, by_q), tolerance);
    EXPECT_LT(relative(exact.acceleration_by_v, by_v), tolerance);
  }
}
#endif

}  // namespace
}  // namespace borelli::test::derivatives_test
