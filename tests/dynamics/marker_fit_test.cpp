// Inverse kinematics against the poses that the markers were made from, and optimality of the fit by
// differences.
#include "dynamics/inverse/marker_fit.hpp"

#include "dynamics/constraints/assembly.hpp"
#include "dynamics/constraints/local_coordinates.hpp"
#include "dynamics/equations/evaluate.hpp"
#include "random_scene.hpp"

namespace borelli::test::marker_fit_test {
namespace {

constexpr double gap = std::numeric_limits<double>::quiet_NaN();

/// Four markers on every solid.
std::vector<FollowedMarker> markers_on(const System& system, Random& random) {
  std::vector<FollowedMarker> markers;
  for (const std::string& solid : system.solids)
    for (int i = 0; i < 4; ++i)
      markers.push_back({fmt::format("{}.{}", solid, i), {solid, random.vector(0.3)}, random.number(0.5, 3)});
  return markers;
}

Eigen::Matrix3Xd places(const System& system, const State& state,
                        const std::vector<FollowedMarker>& markers) {
  Eigen::Matrix3Xd out(3, markers.size());
  for (std::size_t m = 0; m < markers.size(); ++m)
    out.col(Eigen::Index(m)) = need(point_motion(system, state, markers[m].at)).position;
  return out;
}

Eigen::VectorXd disturbed(const System& system, const Eigen::VectorXd& q, Random& random, double size) {
  const Eigen::VectorXd x =
      Eigen::VectorXd::NullaryExpr(system.nv, [&] { return random.number(-size, size); });
  Eigen::VectorXd out = q;
  from_local_coordinates(system, q.data(), x.data(), out.data());
  return out;
}

/// The goal of marker_fit.hpp by its definition.
double goal(const System& system, State state, const Eigen::VectorXd& q,
            const std::vector<FollowedMarker>& markers, const Eigen::Matrix3Xd& measured) {
  state.q = q;
  const Eigen::Matrix3Xd x = places(system, state, markers);
  double sum = 0, weights = 0;
  for (std::size_t m = 0; m < markers.size(); ++m) {
    const auto k = Eigen::Index(m);
    if (!measured.col(k).allFinite()) continue;
    sum += markers[m].weight * (x.col(k) - measured.col(k)).squaredNorm();
    weights += markers[m].weight;
  }
  return sum / (2 * weights);
}

TEST(MarkerFit, FindsThePoseThatMarkersWereMadeFrom) {
  for (unsigned seed = 0; seed < 12; ++seed) {
    const System system = compiled(random_tree(seed, {.balls = true, .drives = seed % 2 == 1}));
    Random random(seed + 10);
    State state = random.state(system);
    state.t = 0.3;
    const std::vector<FollowedMarker> markers = markers_on(system, random);
    Eigen::Matrix3Xd measured = places(system, state, markers);
    measured(1, 2) = gap;  // a marker that was not seen
    MarkerFit fit = need(MarkerFit::create(system, markers, {}, {}));
    Eigen::VectorXd q = disturbed(system, state.q, random, 0.2);
    const MarkerFrame frame = need(fit.fit(state.t, measured, Eigen::VectorXd(), q));
    EXPECT_TRUE(frame.converged) << seed;
    EXPECT_LT(frame.rms, 1e-8) << seed;
    EXPECT_TRUE(std::isnan(frame.errors[2]));
    EXPECT_EQ(frame.seen, int(markers.size()) - 1);
    state.q = q;
    EXPECT_LT((places(system, state, markers) - frame.model).norm(), 1e-12);
  }
}

TEST(MarkerFit, ReachesAMinimumWhenMarkersDisagree) {
  for (unsigned seed = 0; seed < 12; ++seed) {
    const System system = compiled(random_tree(seed, {.balls = true, .drives = seed % 2 == 1}));
    Random random(seed + 10);
    State state = random.state(system);
    state.t = 0.3;
    const std::vector<FollowedMarker> markers = markers_on(system, random);
    Eigen::Matrix3Xd measured = places(system, state, markers);
    for (Eigen::Index m = 0; m < measured.cols(); ++m) measured.col(m) += random.vector(0.03);
    MarkerFit fit = need(MarkerFit::create(system, markers, {}, {}));
    Eigen::VectorXd q = disturbed(system, state.q, random, 0.1);
    const MarkerFrame frame = need(fit.fit(state.t, measured, Eigen::VectorXd(), q));
    EXPECT_TRUE(frame.converged) << seed;
    EXPECT_LE(frame.iterations, 12) << seed;  // Newton's method ends quadratically
    const double h = 1e-4;
    for (int u = 0; u < system.nv; ++u) {
      const Eigen::VectorXd x = h * Eigen::VectorXd::Unit(system.nv, u);
      Eigen::VectorXd ahead = q, behind = q;
      const Eigen::VectorXd back = -x;
      from_local_coordinates(system, q.data(), x.data(), ahead.data());
      from_local_coordinates(system, q.data(), back.data(), behind.data());
      const double slope =
          (goal(system, state, ahead, markers, measured) - goal(system, state, behind, markers, measured)) /
          (2 * h);
      EXPECT_NEAR(slope, 0, 1e-8) << seed << " " << u;  // h^2 times third derivatives
    }
  }
}

/// A planar four-bar: crank, coupler and rocker closed by a point on a point.
Scene four_bar() {
  Scene scene;
  scene.name = "four-bar";
  const Inertial rod = inertial(1, Vector3d(0.5, 0, 0), Vector3d(0.1, 0.1, 0.1));
  scene.solids.push_back(solid("crank", "world", {hinge("crank", Vector3d::UnitZ(), 1.2)}, {rod}));
  scene.solids.push_back(
      solid("coupler", "crank", {fixed(Vector3d(1, 0, 0)), hinge("coupler", Vector3d::UnitZ(), -1)}, {rod}));
  scene.solids.push_back(
      solid("rocker", "world", {fixed(Vector3d(2, 0, 0)), hinge("rocker", Vector3d::UnitZ(), 1.5)}, {rod}));
  scene.constraints.push_back(
      {"pin", PointOnPoint{{"coupler", Vector3d(2, 0, 0)}, {"rocker", Vector3d(1.5, 0, 0)}}});
  return scene;
}

TEST(MarkerFit, HoldsTheConstraintsOfALoop) {
  const System system = compiled(four_bar());
  State state = system.initial;
  ASSERT_TRUE(assemble(system, state));
  const std::vector<FollowedMarker> markers{{"c", {"coupler", Vector3d(1, 0.2, 0)}, 1},
                                            {"r", {"rocker", Vector3d(1, 0, 0)}, 2}};
  const Eigen::Matrix3Xd exact = places(system, state, markers);
  MarkerFit fit = need(MarkerFit::create(system, markers, {}, {}));
  Eigen::VectorXd q = system.initial.q;
  q[0] += 0.2;
  MarkerFrame frame = need(fit.fit(0, exact, Eigen::VectorXd(), q));
  EXPECT_TRUE(frame.converged);
  EXPECT_LT((q - state.q).norm(), 1e-7);
  Eigen::Matrix3Xd off = exact;
  off.col(0) += Vector3d(0.05, -0.02, 0.01);
  frame = need(fit.fit(0, off, Eigen::VectorXd(), q));
  EXPECT_TRUE(frame.converged);
  state.q = q;
  const Vector3d a = need(point_motion(system, state, {"coupler", Vector3d(2, 0, 0)})).position,
                 b = need(point_motion(system, state, {"rocker", Vector3d(1.5, 0, 0)})).position;
  EXPECT_LT((a - b).norm(), 1e-9);
  // the loop has one freedom: the goal is least among neighbouring poses of the loop
  const auto nearby = [&](double crank) {
    State other = state;
    other.q[0] += crank;
    other.v.setZero();
    Scene held = four_bar();
    held.solids[0].switches[0].motion = Locked{};
    held.solids[0].switches[0].q = {other.q[0]};
    held.solids[1].switches[1].q = {other.q[1]};
    held.solids[2].switches[1].q = {other.q[2]};
    const System locked = compiled(held);
    State there = locked.initial;
    EXPECT_TRUE(assemble(locked, there));
    return goal(locked, there, there.q, markers, off);
  };
  EXPECT_GT(nearby(0.01), nearby(0));
  EXPECT_GT(nearby(-0.01), nearby(0));
}

TEST(MarkerFit, KeepsCoordinatesWithinTheirRanges) {
  Scene scene;
  scene.name = "hinge";
  Switch one = hinge("bend", Vector3d::UnitZ(), 0.1);
  one.ranges = {{-0.5, 0.5}};
  scene.solids.push_back(
      solid("arm", "world", {one}, {inertial(1, Vector3d(0.5, 0, 0), Vector3d(0.1, 0.1, 0.1))}));
  const System system = compiled(scene);
  Eigen::Matrix3Xd measured(3, 1);
  measured << std::cos(0.9), std::sin(0.9), 0;
  const std::vector<FollowedMarker> tip{{"tip", {"arm", Vector3d(1, 0, 0)}, 1}};
  Eigen::VectorXd q = system.initial.q;
  MarkerFit bounded = need(MarkerFit::create(system, tip, {}, {}));
  const MarkerFrame frame = need(bounded.fit(0, measured, Eigen::VectorXd(), q));
  EXPECT_TRUE(frame.converged);
  EXPECT_NEAR(q[0], 0.5, 1e-12);
  EXPECT_EQ(frame.at_range, std::vector<int>{0});
  EXPECT_NEAR(frame.rms, 2 * std::sin(0.2), 1e-12);
  MarkerFit free = need(MarkerFit::create(system, tip, {}, {.within_ranges = false}));
  need(free.fit(0, measured, Eigen::VectorXd(), q));
  EXPECT_NEAR(q[0], 0.9, 1e-9);
}

TEST(MarkerFit, DrawsCoordinatesToTheirValues) {
  // a slide with a marker at 1 and a prior value of 0: (x - 1)^2 + 3 x^2 is least at 1/4
  Scene scene;
  scene.name = "slide";
  scene.solids.push_back(solid("cart", "world", {slide("x", Vector3d::UnitX())},
                               {inertial(1, Vector3d::Zero(), Vector3d(1, 1, 1))}));
  const System system = compiled(scene);
  MarkerFit fit = need(MarkerFit::create(system, {{"m", {"cart", Vector3d::Zero()}, 7}}, {{"x", 3}}, {}));
  Eigen::VectorXd q = system.initial.q;
  need(fit.fit(0, Vector3d::UnitX(), Eigen::VectorXd::Zero(1), q));
  EXPECT_NEAR(q[0], 0.25, 1e-12);
}

TEST(MarkerFit, NamesWhatNoMarkerDetermines) {
  Scene scene;
  scene.name = "arm";
  scene.solids.push_back(solid("upper", "world", {hinge("shoulder", Vector3d::UnitZ())},
                               {inertial(1, Vector3d(0.5, 0, 0), Vector3d(1, 1, 1))}));
  scene.solids.push_back(solid("hand", "upper", {fixed(Vector3d(1, 0, 0)), hinge("wrist", Vector3d::UnitZ())},
                               {inertial(1, Vector3d(0.1, 0, 0), Vector3d(1, 1, 1))}));
  const System system = compiled(scene);
  MarkerFit fit = need(MarkerFit::create(system, {{"elbow", {"upper", Vector3d(1, 0, 0)}, 1}}, {}, {}));
  Eigen::VectorXd q = Eigen::Vector2d(0, 0.4);
  need(fit.fit(0, Vector3d(std::cos(0.3), std::sin(0.3), 0), Eigen::VectorXd(), q));
  EXPECT_NEAR(q[0], 0.3, 1e-9);
  EXPECT_EQ(q[1], 0.4);
  EXPECT_EQ(fit.undetermined(), std::vector<std::string>{"wrist"});
}

TEST(MarkerFit, RefusesWhatTheModelDoesNotHave) {
  const System system = compiled(four_bar());
  EXPECT_FALSE(MarkerFit::create(system, {{"m", {"nobody", Vector3d::Zero()}, 1}}, {}, {}));
  EXPECT_FALSE(MarkerFit::create(system, {{"m", {"crank", Vector3d::Zero()}, -1}}, {}, {}));
  EXPECT_FALSE(MarkerFit::create(system, {{"m", {"crank", Vector3d::Zero()}, 0}}, {}, {}));
  EXPECT_FALSE(MarkerFit::create(system, {}, {{"nothing", 1}}, {}));
}

}  // namespace
}  // namespace borelli::test::marker_fit_test
