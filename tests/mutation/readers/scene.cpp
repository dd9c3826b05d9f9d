// Scenes in TOML.
#include "tests/mutation/model_trial.hpp"

namespace borelli::mutation {
namespace of_scene {

std::vector<TestCase> seeds() {
  std::vector<TestCase> out = sample_cases(
      {"pendulum.toml", "heavy_top.toml", "roundabout.toml", "turntable.toml", "rolling_disc.toml",
       "block_on_slope.toml", "bouncing_ball.toml", "cradle.toml", "four_bar_2.toml", "painleve_rod.toml",
       "shock.toml", "kapitza.toml", "chaplygin_sleigh.toml", "andrews.toml", "bars_3.toml"});
  // no contact force solves this scene
  for (TestCase& test : out) test.may_be_refused = test.name == "painleve_rod";
  return out;
}

}  // namespace of_scene

Reader scene_reader() { return {"scene", of_scene::seeds, try_model}; }

}  // namespace borelli::mutation
