// Disturbed states: of the requested size, and consistent with constraints and closed contacts.
#include "dynamics/run/disturbance.hpp"

#include "dynamics/equations/equations.hpp"
#include "scenes.hpp"

namespace borelli::test {
namespace {

TEST(Disturbance, HasTheRequestedSizeInFreeScenes) {
  const System system = compiled(chain(3, true, 1.5));
  const State off = disturbed(system, system.initial, 1e-3);
  EXPECT_EQ(off.q, system.initial.q);
  for (int i = 0; i < system.nv; ++i)
    EXPECT_NEAR(std::abs(off.v[i] - system.initial.v[i]), 1e-3 * system.velocity_scale[i], 1e-15) << i;
}

TEST(Disturbance, KeepsConstraints) {
  const System system = compiled(sample("four_bar_2.toml"));
  Workspace w(system);
  const State off = disturbed(system, system.initial, 1e-3);
  ASSERT_FALSE(update_terms(system, system.parameters, 0, off.q.data(),
                            Eigen::VectorXd(off.v - system.initial.v).data(), w));
  EXPECT_GT((off.v - system.initial.v).norm(), 1e-4);
  EXPECT_LT((w.rows.L.leftCols(system.nv) * (off.v - system.initial.v)).norm(), 1e-15);
}

TEST(Disturbance, KeepsClosedContactsClosedAndMovesOpenOnes) {
  const Scene resting = sample("block_on_slope.toml");
  const System closed = compiled(resting);
  const State lies = disturbed(closed, closed.initial, 1e-3);
  EXPECT_LT((lies.v - closed.initial.v).norm(), 1e-15);  // friction holds the rest
  const System open = compiled(sample("bouncing_ball.toml"));
  EXPECT_NEAR(std::abs(disturbed(open, open.initial, 1e-3).v[0]), 1e-3 * open.velocity_scale[0], 1e-15);
}

}  // namespace
}  // namespace borelli::test
