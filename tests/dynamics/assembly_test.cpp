// Assembly of inconsistent starts, redundant and contradictory rows by name, and projection.
#include "dynamics/constraints/assembly.hpp"

#include "scenes.hpp"

namespace borelli::test {
namespace {

/// A planar four-bar: crank, coupler and rocker of 1, 2 and 1.5 m; the rocker's foot 2 m beside the crank's.
Scene four_bar() {
  Scene scene;
  const auto bar = [](double length) {
    return inertial(length, {0, 0, -length / 2},
                    length * Vector3d(length * length / 12, length * length / 12, 1e-3));
  };
  scene.solids = {
      solid("crank", "world", {hinge("a", Vector3d::UnitY(), 2.0, 1)}, {bar(1)}),
      solid("coupler", "crank", {fixed({0, 0, -1}), hinge("b", Vector3d::UnitY(), -1)}, {bar(2)}),
      solid("rocker", "world", {fixed({-2, 0, 0}), hinge("c", Vector3d::UnitY(), 2.3)}, {bar(1.5)})};
  scene.constraints = {{"joint", PointOnPoint{{"coupler", {0, 0, -2}}, {"rocker", {0, 0, -1.5}}}}};
  return scene;
}

TEST(Assembly, MovesAnInconsistentStartOntoItsConstraints) {
  const System system = compiled(four_bar());
  State state = system.initial;
  const Assembly assembly = need(assemble(system, state));
  Workspace w(system);
  ASSERT_FALSE(update_terms(system, system.parameters, 0, state.q.data(), state.v.data(), w));
  EXPECT_LT(w.rows.h.norm(), 1e-12);
  EXPECT_LT(w.rows.rate.norm(), 1e-12);
  // a planar loop in space: the row across the plane depends on nothing and is satisfied
  EXPECT_EQ(assembly.rank, 2);
  EXPECT_EQ(assembly.redundant, std::vector<std::string>{"joint[1]"});
}

TEST(Assembly, LeavesAConsistentStateAlone) {
  const System system = compiled(four_bar());
  State state = system.initial;
  need(assemble(system, state));
  const State before = state;
  need(assemble(system, state));
  EXPECT_LT((state.q - before.q).norm(), 1e-13);
  EXPECT_LT((state.v - before.v).norm(), 1e-13);
}

TEST(Assembly, CorrectsBallOrientations) {
  Scene scene;
  scene.solids = {solid("s", "world", {ball("turn")}, {link()})};
  scene.constraints = {{"pin", PointOnPoint{{"s", {0, 0, -1}}, {"world", Vector3d(1, 2, 2) / 3}}}};
  const System system = compiled(scene);
  State state = system.initial;
  // the third row is dependent: a point of the sphere stays on it
  EXPECT_EQ(need(assemble(system, state)).rank, 2);
  EXPECT_LT((rotation_matrix(state.q) * Vector3d(0, 0, -1) - Vector3d(1, 2, 2) / 3).norm(), 1e-9);
}

TEST(Assembly, NamesRedundantRowsAndContinues) {
  Scene scene = four_bar();
  scene.constraints.push_back(
      {"again", PointOnPlane{{"coupler", {0, 0, -2}}, {{"rocker", {0, 0, -1.5}}, {1, 0, 0}}, constant(0)}});
  const System system = compiled(scene);
  State state = system.initial;
  const Assembly assembly = need(assemble(system, state));
  EXPECT_EQ(assembly.rank, 2);
  EXPECT_EQ(assembly.redundant.size(), 2u);
  const Trajectory trajectory = run(system, settings("rk4", 1, 0.01));
  EXPECT_TRUE(trajectory.certificate.trusted) << trajectory.certificate.reason;
  EXPECT_EQ(trajectory.certificate.constraint_rank, 2);
  EXPECT_EQ(trajectory.certificate.redundant.size(), 2u);
}

void expect_failure(const Scene& scene, const std::string& where, const std::string& what) {
  const System system = compiled(scene);
  State state = system.initial;
  const Result<Assembly> assembly = assemble(system, state);
  ASSERT_FALSE(assembly);
  EXPECT_EQ(assembly.error().where, where);
  EXPECT_NE(assembly.error().what.find(what), std::string::npos) << assembly.error().what;
}

TEST(Assembly, NamesContradictoryRows) {
  Scene scene = chain(2, false, 0.4);
  scene.constraints = {{"near", Distance{{"l1", {0, 0, -1}}, {"world", {0, 0, 0}}, constant(1.2)}},
                       {"far", Distance{{"l1", {0, 0, -1}}, {"world", {0, 0, 0}}, constant(1.4)}}};
  expect_failure(scene, "constraint 'far'", "it contradicts 'near'");
}

TEST(Assembly, NamesContradictoryRates) {
  Scene scene = chain(2, false, 0.4);  // equal at the start, but one grows
  scene.constraints = {{"still", Distance{{"l1", {0, 0, -1}}, {"world", {0, 0, 0}}, constant(1.2)}},
                       {"grows", Distance{{"l1", {0, 0, -1}}, {"world", {0, 0, 0}}, linear(1.2, 0.5)}}};
  expect_failure(scene, "constraint 'grows'", "rate cannot be zero at the start");
}

TEST(Assembly, NamesConstraintsOutOfReach) {
  Scene scene = chain(2, false, 0.4);
  scene.constraints = {
      {"star", PointOnPlane{{"l1", {0, 0, -1}}, {{"world", {0, 0, 5}}, {0, 0, 1}}, constant(0)}}};
  expect_failure(scene, "constraint 'star'", "a residual of -3");
  scene.constraints = {
      {"aside", PointOnPlane{{"l1", {0, 0, -1}}, {{"world", {0, 1, 0}}, {0, 1, 0}}, constant(0)}}};
  expect_failure(scene, "constraint 'aside'", "no free coordinate moves it");
}

TEST(Projection, AppliesTheLeastCorrection) {
  const System system = compiled(four_bar());
  State state = system.initial;
  need(assemble(system, state));
  Workspace w(system);
  State off = state;
  off.q += Vector3d(1e-4, -2e-4, 1e-4);
  off.v += Vector3d(1e-3, 1e-3, 0);
  Projection projection;
  project(system, system.parameters, off, w, projection);
  ASSERT_FALSE(projection.fault);
  EXPECT_EQ(projection.unreached, -1);
  ASSERT_FALSE(update_terms(system, system.parameters, 0, off.q.data(), off.v.data(), w));
  EXPECT_LT(w.rows.h.norm(), 1e-12);
  EXPECT_LT(w.rows.rate.norm(), 1e-12);
  // the correction is orthogonal, in the mass matrix, to the one free mode of motion
  const Rows A = w.terms.A.selfadjointView<Eigen::Lower>();
  const Eigen::VectorXd move = off.q - (state.q + Vector3d(1e-4, -2e-4, 1e-4));
  const Eigen::VectorXd mode = Eigen::MatrixXd(w.rows.L).fullPivLu().kernel().col(0);
  EXPECT_LT(std::abs(mode.dot(A * move)),
            1e-3 * mode.norm() * (A * move).norm());  // up to the curvature over 1e-4
}

TEST(Assembly, NamesAllConstraintsOfAContradiction) {
  // a four-bar has one freedom: crank and rocker cannot both be fixed freely
  Scene scene = four_bar();
  scene.constraints.push_back({"hold crank", CoordinateCoupling{{{"a"}}, {1}, constant(2.0)}});
  scene.constraints.push_back({"hold rocker", CoordinateCoupling{{{"c"}}, {1}, constant(1.5)}});
  const System system = compiled(scene);
  State state = system.initial;
  const auto answer = assemble(system, state);
  ASSERT_FALSE(answer);
  for (const char* name : {"'hold crank'", "'hold rocker'", "'joint"})
    EXPECT_NE(answer.error().message().find(name), std::string::npos) << answer.error().message();
}

}  // namespace
}  // namespace borelli::test
