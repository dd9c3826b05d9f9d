// What it costs to record every step of a motion: whole runs of scenes as their files say, recorded at every
// step, and in their ends alone. Labels: the steps taken. Runs that do not come to their end, or are not
// trusted, are errors.
#include <benchmark/benchmark.h>

#include <filesystem>

#include "dynamics/scene_file.hpp"
#include "dynamics/simulate.hpp"
#include "tests/paths.hpp"

namespace borelli {
namespace {

void simulate_recorded(benchmark::State& bench, const std::string& file, bool every_step) {
  const auto scene = read_scene(file);
  if (!scene) return bench.SkipWithError(scene.error().message().c_str());
  const auto system = compile(*scene);
  if (!system) return bench.SkipWithError(system.error().message().c_str());
  SimulationSettings settings = system->settings;
  settings.output_interval = every_step ? 0 : settings.end_time;
  long steps = 0;
  for (auto _ : bench) {
    const auto motion = simulate(*system, system->initial, settings);
    if (!motion) return bench.SkipWithError(motion.error().message().c_str());
    if (!motion->certificate.trusted) return bench.SkipWithError(motion->certificate.reason.c_str());
    steps = motion->certificate.steps_accepted;
  }
  bench.SetLabel(std::to_string(steps));
}

}  // namespace
}  // namespace borelli

int main(int argc, char** argv) {
  using namespace borelli;
  benchmark::Initialize(&argc, argv);
  for (const char* file :
       {"samples/double_pendulum.toml", "samples/roundabout.toml", "tests/bench/peers/scenes/chain_7.toml",
        "tests/bench/peers/scenes/human_flight.toml"})
    for (const bool every_step : {false, true}) {
      const std::string name = std::filesystem::path(file).stem();
      benchmark::RegisterBenchmark((name + (every_step ? "/every_step" : "/end")).c_str(), simulate_recorded,
                                   test::source_folder() + "/" + file, every_step)
          ->Unit(benchmark::kMillisecond);
    }
  benchmark::RunSpecifiedBenchmarks();
}
