// evaluate(): its arrays satisfy A a + B = Q + L^T lambda; its refusals.
#include "dynamics/equations/evaluate.hpp"

#include "scenes.hpp"

namespace borelli::test {
namespace {

Scene held() {
  Scene scene = random_tree(4, {.balls = true});
  scene.constraints = {{"rod", Distance{{"s3", {0.1, 0.2, 0.3}}, {"world", {1, 3, 0}}, constant(1)}}};
  return scene;
}

TEST(Evaluate, ArraysSatisfyTheEquationsOfMotion) {
  const System system = compiled(held());
  const State state = Random(2).state(system);
  const Eigen::VectorXd efforts = Eigen::VectorXd::LinSpaced(system.nv, -1, 1);
  const Evaluation e = need(evaluate(system, state, efforts)), without = need(evaluate(system, state));
  const Eigen::VectorXd left = e.mass_matrix * e.acceleration + e.bias;
  const Eigen::VectorXd right = e.generalized_efforts + e.constraint_jacobian.transpose() * e.multipliers;
  EXPECT_LT((left - right).norm(), 1e-12 * left.norm());
  EXPECT_LT((e.constraint_jacobian * e.acceleration + e.constraint_bias).norm(),
            1e-11 * e.acceleration.norm());
  EXPECT_LT((e.generalized_efforts - without.generalized_efforts - efforts).norm(), 1e-13);
  EXPECT_EQ(e.mass_matrix, Rows(e.mass_matrix.transpose()));
  EXPECT_EQ(e.coordinates.size(), std::size_t(system.nv));
  EXPECT_EQ(e.rows, std::vector<std::string>{"rod"});
}

TEST(Evaluate, NamesABallsVelocitiesByAxis) {
  Scene scene;
  scene.solids = {solid("s", "world", {ball("turn")}, {link()})};
  const System system = compiled(scene);
  EXPECT_EQ(need(evaluate(system, system.initial)).coordinates,
            (std::vector<std::string>{"turn.x", "turn.y", "turn.z"}));
}

TEST(Evaluate, RefusesStatesThatDoNotFit) {
  const System system = compiled(held());
  State state = system.initial;
  state.q.conservativeResize(2);
  EXPECT_NE(evaluate(system, state).error().message().find("has 2 positions"), std::string::npos);
  state = system.initial;
  state.v[1] = NAN;
  EXPECT_NE(evaluate(system, state).error().message().find("not a finite number"), std::string::npos);
  state = system.initial;
  for (const CoordinateInfo& info : system.coordinates)
    if (info.q_size == 4) state.q[info.q_index] = 3;
  EXPECT_NE(evaluate(system, state).error().message().find("quaternion has length 3"), std::string::npos);
  EXPECT_NE(evaluate(system, system.initial, Eigen::VectorXd::Zero(1))
                .error()
                .message()
                .find("have 1 entries; the scene has"),
            std::string::npos);
}

}  // namespace
}  // namespace borelli::test
