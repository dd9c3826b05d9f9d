// Scenes written as MJCF: MuJoCo and our reader make the same mechanics of them, and each loss is named.
#include <gtest/gtest.h>

#include <fmt/ranges.h>

#include "dynamics/formats/model_file.hpp"
#include "dynamics/formats/model_write.hpp"
#include "tests/dynamics/test_folder.hpp"
#include "tests/dynamics/writable_scene.hpp"
#ifdef BORELLI_MUJOCO
#include "tests/dynamics/mujoco_model.hpp"
#endif

namespace borelli::test::mjcf_write_test {
namespace {

constexpr int seeds = 200;

WritableScene random_scene(unsigned seed) {
  return {seed, 7, {.springs = true, .balls = true, .free_root = seed % 3 != 0}};
}

ModelFile read_back(const Scene& scene) {
  const Folder folder;
  return need(read_model(folder.write("written.xml", need(write_mjcf(scene)).text)));
}

// The state with each ball's quaternion counted from its zero, as MuJoCo does.
Eigen::VectorXd from_zeros(const System& system, Eigen::VectorXd q,
                           const std::map<std::string, Quaternion>& zeros) {
  for (const CoordinateInfo& info : system.coordinates) {
    const auto zero = zeros.find(info.name);
    if (info.q_size == 4 && zero != zeros.end() && info.name != "root.turn")
      q.segment<4>(info.q_index) = product(conjugate(zero->second), q.segment<4>(info.q_index));
  }
  return q;
}

TEST(MjcfWrite, ReadsBackWithTheSameMechanics) {
  for (unsigned seed = 0; seed < seeds; ++seed) {
    const WritableScene made = random_scene(seed);
    const ModelFile back = read_back(made.scene);
    const System before = compiled(made.scene), after = compiled(back.scene);
    ASSERT_EQ(before.nv, after.nv) << seed;
    const SameNames at(before, after);
    Random random(seed);
    for (int trial = 0; trial < 3; ++trial) {
      // the first trial compares the starts
      const State state = trial == 0 ? before.initial : random.state(before);
      State other{.t = 0, .q = Eigen::VectorXd(after.nq), .v = Eigen::VectorXd(after.nv)};
      other.q(at.q) = from_zeros(before, state.q, made.zeros);
      other.v(at.v) = state.v;
      if (trial == 0) {
        EXPECT_LT((other.q - after.initial.q).norm(), 1e-14) << seed;
        EXPECT_EQ(other.v, after.initial.v) << seed;
      }
      const Evaluation a = need(evaluate(before, state)), b = need(evaluate(after, other));
      // products of some ten poses round to some 1e-15 of the largest entry
      EXPECT_LT((b.mass_matrix(at.v, at.v) - a.mass_matrix).norm(), 1e-12 * a.mass_matrix.norm()) << seed;
      const Eigen::VectorXd drive = a.generalized_efforts - a.bias,
                            other_drive = (b.generalized_efforts - b.bias)(at.v);
      EXPECT_LT((other_drive - drive).norm(), 1e-12 * drive.norm()) << seed;
    }
  }
}

}  // namespace
}  // namespace borelli::test::mjcf_write_test
