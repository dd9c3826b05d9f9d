// The rows of every kind of contact, on random trees (free and driven), against central differences.
#include "dynamics/scene/surface_contact.hpp"

#include "dynamics/constraints/local_coordinates.hpp"
#include "dynamics/equations/equations.hpp"
#include "scenes.hpp"

namespace borelli::test::surface_contact_test {
namespace {

// of central differences with step h: h^2 times third derivatives (about 100), and rounding / h
constexpr double h = 1e-5, tolerance = 2e-7;

std::vector<ConstraintKind> kinds() {
  const Vector3d n = Vector3d(1, 2, -1).normalized(), u = Vector3d(1, -1, 2).normalized();
  return {Limit{{"c20"}, -1, 2}, Rope{{"s3", {0.1, 0.2, 0.3}}, {"s5", {1, 0, 0}}, 0.7},
          SphereOverPlane{{"s3", {0.1, 0.2, 0.3}}, 0.4, {{"s5", {1, 0, 0}}, n}},
          SphereOverPlane{{"s4", {0.1, 0.2, 0.3}}, 0.4, {{"world", {1, 0, 0}}, n}},
          CapsuleOverPlane{{"s3", {0.1, 0.2, 0.3}}, u, 0.8, 0.1, {{"s5", {1, 0, 0}}, n}},
          BoxOverPlane{{"s3", {0.1, 0.2, 0.3}}, {1, 2, 3}, {{"s5", {1, 0, 0}}, n}},
          SphereOverSphere{{"s3", {0.1, 0.2, 0.3}}, {"s5", {1, 0, 0}}, 0.1, 0.2},
          // nearest points: inside both capsules, inside one, at the ends
          CapsuleOverCapsule{{"s3", {0.1, 0.2, 0.3}}, {"s5", {1, 0, 0}}, u, n, 50, 50, 0.1, 0.2},
          CapsuleOverCapsule{{"s3", {0.1, 0.2, 0.3}}, {"s5", {1, 0, 0}}, u, n, 50, 0.01, 0.1, 0.2},
          CapsuleOverCapsule{{"s3", {0.1, 0.2, 0.3}}, {"s5", {1, 0, 0}}, u, n, 0.01, 50, 0.1, 0.2},
          CapsuleOverCapsule{{"s3", {0.1, 0.2, 0.3}}, {"world", {1, 0, 0}}, u, n, 0.01, 0.01, 0.1, 0.2}};
}

class ContactKinds : public testing::TestWithParam<std::tuple<int, bool>> {
 protected:
  ContactKinds() : system(compiled(scene())), state(Random(21).state(system)) { state.t = 0.3; }

  static Scene scene() {
    Scene out = random_tree(4, {.balls = true, .drives = std::get<1>(GetParam())});
    out.constraints = {{"contact", kinds()[std::get<0>(GetParam())]}};
    return out;
  }
  ConstraintRows at(const Eigen::VectorXd& x, double s) const {
    Eigen::VectorXd q = state.q;
    from_local_coordinates(system, state.q.data(), x.data(), q.data());
    Kinematics kinematics(system);
    update_kinematics(system, system.parameters, state.t + s, q.data(), state.v.data(), kinematics);
    ConstraintRows rows(system);
    rows.every_row = true;
    scan_constraints(system, system.parameters, kinematics, rows);
    return rows;
  }

  System system;
  State state;
};

TEST_P(ContactKinds, NormalRowsAreTheGradientOfTheGap) {
  const ConstraintRows now = at(Eigen::VectorXd::Zero(system.nv), 0);
  ASSERT_FALSE(system.contacts.empty());
  for (int i = 0; i < system.nv; ++i) {
    const Eigen::VectorXd x = h * Eigen::VectorXd::Unit(system.nv, i);
    const Eigen::VectorXd slope = (at(x, 0).h - at(-x, 0).h) / (2 * h);
    for (const Contact& c : system.contacts) EXPECT_NEAR(now.L(c.row, i), slope[c.row], tolerance) << i;
  }
}

TEST_P(ContactKinds, RatesAndBiasesAreTheTimeDerivatives) {
  const Eigen::VectorXd x = h * state.v;
  const ConstraintRows behind = at(-x, -h), now = at(0 * x, 0), ahead = at(x, h);
  const Eigen::VectorXd rate = (ahead.h - behind.h) / (2 * h), bias = (ahead.rate - behind.rate) / (2 * h);
  const bool on_plane = std::get<0>(GetParam()) < 6;  // else the tangents are chosen anew at each position
  for (const Contact& c : system.contacts) {
    EXPECT_NEAR(now.rate[c.row], rate[c.row], tolerance);
    // with no free acceleration, the second derivative is E alone
    for (int r = c.row; r < c.row + (c.tangents && on_plane ? 3 : 1); ++r)
      EXPECT_NEAR(now.E[r], bias[r], 10 * tolerance) << r;
  }
}

INSTANTIATE_TEST_SUITE_P(All, ContactKinds, testing::Combine(testing::Range(0, 11), testing::Bool()));

TEST(Contacts, OpenOnesDoNotAffectTheMotion) {
  Scene with = random_tree(4, {.balls = true}), without = with;
  with.constraints = {{"contact", kinds()[5]}};
  const System a = compiled(with), b = compiled(without);
  const State state = Random(5).state(a);
  Workspace wa(a), wb(b);
  ASSERT_FALSE(accelerate(a, a.parameters, 0, state.q.data(), state.v.data(), {}, wa));
  ASSERT_FALSE(accelerate(b, b.parameters, 0, state.q.data(), state.v.data(), {}, wb));
  EXPECT_LT((wa.a - wb.a).norm(), 1e-10 * wb.a.norm());  // rounding of two ways to solve
  EXPECT_EQ(wa.solver.rank(), 0);
}

}  // namespace
}  // namespace borelli::test::surface_contact_test
