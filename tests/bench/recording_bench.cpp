// The cost of recording every step of a motion. Runs of each scene alternate between recording every step and
// recording the end alone. The counters are the median times of both (s) and the median ratio of pairs; the
// label gives the number of steps. A run that fails or is not trusted is an error.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <filesystem>

#include "dynamics/formats/scene_file.hpp"
#include "dynamics/run/simulate.hpp"
#include "tests/paths.hpp"

namespace borelli {
namespace {

double median(std::vector<double> numbers) {
  const auto middle = numbers.begin() + std::ptrdiff_t(numbers.size() / 2);
  std::nth_element(numbers.begin(), middle, numbers.end());
  return *middle;
}

void record(benchmark::State& bench, const std::string& file) {
  const auto scene = read_scene(file);
  if (!scene) return bench.SkipWithError(scene.error().message().c_str());
  const auto system = compile(*scene);
  if (!system) return bench.SkipWithError(system.error().message().c_str());
  std::vector<double> end, every_step, ratios;
  long steps = 0;
  std::string failed;
  const auto simulated = [&](double interval) {
    SimulationSettings settings = system->settings;
    settings.output_interval = interval;
    const auto begin = std::chrono::steady_clock::now();
    const auto motion = simulate(*system, system->initial, settings);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    if (!motion)
      failed = motion.error().message();
    else if (!motion->certificate.trusted)
      failed = motion->certificate.reason;
    else
      steps = motion->certificate.steps_accepted;
    return took.count();
  };
  for (auto _ : bench) {
    end.push_back(simulated(system->settings.end_time));
    every_step.push_back(simulated(0));
    ratios.push_back(every_step.back() / end.back());
    if (!failed.empty()) return bench.SkipWithError(failed.c_str());
  }
  bench.counters["end"] = median(end);
  bench.counters["every_step"] = median(every_step);
  bench.counters["ratio"] = median(ratios);
  bench.SetLabel(std::to_string(steps));
}

}  // namespace
}  // namespace borelli

int main(int argc, char** argv) {
  using namespace borelli;
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  for (const char* file :
       {"samples/double_pendulum.toml", "samples/roundabout.toml", "tests/bench/peers/scenes/chain_7.toml",
        "tests/bench/peers/scenes/human_flight.toml"})
    benchmark::RegisterBenchmark(std::filesystem::path(file).stem().c_str(), record,
                                 test::source_folder() + "/" + file)
        ->Unit(benchmark::kMillisecond);
  benchmark::RunSpecifiedBenchmarks();
}
