// Pairs marked as far stay apart for the promised time, as scans of all gaps show.
#include "dynamics/contacts/far_pairs.hpp"

#include "scenes.hpp"

namespace borelli::test {
namespace {

// Free solids with off-centre spheres and capsules that may touch each other and a fixed one.
Scene loose_things(Random& random) {
  Scene scene;
  scene.gravity.setZero();
  struct Form {
    SolidPoint at;
    Vector3d axis;
    double length, radius;
  };
  std::vector<Form> forms{{{"world", {0.3, 0, 0}}, {1, 2, 3}, 0.4, 0.1}};
  for (int i = 0; i < 6; ++i) {
    Solid solid;
    solid.name = fmt::format("s{}", i);
    solid.switches = free_switches(solid.name);
    solid.inertials = {inertial(1, {0.1, 0, 0}, {1, 1, 1})};
    scene.solids.push_back(solid);
    forms.push_back({{solid.name, random.vector(0.5)}, random.vector(1), i % 2 * random.number(0.1, 1), 0.1});
  }
  for (std::size_t i = 0; i < forms.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const Form &a = forms[i], &b = forms[j];
      ConstraintKind kind =
          CapsuleOverCapsule{a.at, b.at, a.axis, b.axis, a.length, b.length, {a.radius, b.radius}, {}};
      if (a.length == 0 && b.length == 0) kind = SphereOverSphere{a.at, b.at, {a.radius, b.radius}, {}};
      scene.constraints.push_back({fmt::format("{} {}", i, j), kind});
    }
  return scene;
}

TEST(FarPairs, DistantPairsStayApartForThePromisedTime) {
  Random random(4);
  int far = 0, near = 0;
  for (int trial = 0; trial < 40; ++trial) {
    const System system = compiled(loose_things(random));
    FarPairs pairs(system);
    State state = random.state(system);
    for (const CoordinateInfo& info : system.coordinates)
      if (info.q_size == 1) state.q[info.q_index] *= 2;
    const auto gaps = [&](const State& at, bool marked, double time, double distance) {
      Workspace w(system);
      EXPECT_FALSE(update_terms(system, system.parameters, 0, at.q.data(), at.v.data(), w));
      ConstraintRows out(system);
      out.detail = ConstraintRows::Detail::rates;
      if (marked) {
        out.far.resize(system.constraints.size());
        pairs.mark(w.kinematics, time, distance, out);
      }
      scan_constraints(system, system.parameters, w.kinematics, out);
      return out;
    };
    const double time = random.number(0, 0.2), distance = random.number(0, 0.1);
    const ConstraintRows all = gaps(state, false, 0, 0), some = gaps(state, true, time, distance);
    for (std::size_t c = 0; c < system.constraints.size(); ++c) {
      const int row = system.constraints[c].first_row;
      if (!some.far[c]) {
        EXPECT_EQ(some.h[row], all.h[row]);
        EXPECT_EQ(some.rate[row], all.rate[row]);
        ++near;
        continue;
      }
      ++far;
      EXPECT_LE(some.h[row], all.h[row] + 1e-12);
      EXPECT_GT(some.h[row], distance);
      // the true gap keeps the distance at the speed bound
      EXPECT_GE(all.h[row], distance + time * all.speed[row] - 1e-12);
      EXPECT_EQ(some.rate[row], 0);
    }
  }
  EXPECT_GT(far, 100);
  EXPECT_GT(near, 20);
}

}  // namespace
}  // namespace borelli::test
