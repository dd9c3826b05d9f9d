// The built-in scenes equal those of samples/, so the files show what the figures run.
#include "pipeline/paper/paper_scenes.hpp"
#include "tests/paths.hpp"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include "dynamics/equations/evaluate.hpp"
#include "dynamics/formats/scene_file.hpp"

namespace borelli {
namespace {

// Their texts are equal except name and description, with every number equal bit for bit.
void expect_same(Scene scene, const std::string& file) {
  auto sample = read_scene(test::source_folder() + "/samples/" + file);
  ASSERT_TRUE(sample) << sample.error().message();
  EXPECT_EQ(*write_scene(scene), *write_scene(*sample)) << file;
}

TEST(PaperScenes, EqualTheSampleFiles) {
  expect_same(roundabout(), "roundabout.toml");
  expect_same(shock(), "shock.toml");
  for (int n = 3; n <= 7; ++n) {
    expect_same(bars(n), fmt::format("bars_{}.toml", n));
    expect_same(pendulum(n), fmt::format("pendulum_{}.toml", n));
  }
}

TEST(PaperScenes, BarsAreIndependentAndPendulumsCoupled) {
  const auto independent = compile(bars(4)), chain = compile(pendulum(4));
  ASSERT_TRUE(independent && chain);
  const auto a = evaluate(*independent, independent->initial), b = evaluate(*chain, chain->initial);
  ASSERT_TRUE(a && b);
  for (int i = 0; i < 4; ++i) {
    // a level uniform bar falls with 3 g / (2 l), here towards smaller angles
    EXPECT_NEAR(a->acceleration[i], -1.5 * 9.81, 1e-12);
    EXPECT_NEAR(a->mass_matrix(i, i), 1. / 3, 1e-15);
    for (int j = 0; j < i; ++j) {
      EXPECT_EQ(a->mass_matrix(i, j), 0);
      EXPECT_GT(b->mass_matrix(i, j), 0.1);
    }
  }
}

}  // namespace
}  // namespace borelli
