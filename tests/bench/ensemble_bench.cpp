// A Monte Carlo of a human: a second of free motion from each of a thousand random starts. simulate_ensemble
// runs them on one core and on all; MuJoCo runs the first of them one by one on one core. Reports motions per
// second of wall time. The labels give the largest error of a final coordinate (m, rad, or a quaternion
// component) of the first starts, against dop853 at 1e-12, and how many runs are trusted.
#include <benchmark/benchmark.h>
#include <fmt/core.h>

#include <filesystem>
#include <limits>

#include "dynamics/run/ensemble.hpp"
#include "tests/bench/mujoco_pair.hpp"
#include "tests/paths.hpp"

namespace borelli {
namespace {

constexpr int starts = 1000, judged = 24;  // `judged`: starts that MuJoCo runs and whose errors count

struct Falls {
  MujocoPair pair;
  std::vector<Member> members;
  std::vector<Eigen::VectorXd> ends;  ///< final q of the first starts

  explicit Falls(const std::string& file)
      : pair(file, mjDSBL_CONSTRAINT | mjDSBL_CONTACT | mjDSBL_ACTUATION) {
    const Eigen::VectorXd rest = pair.q;
    for (unsigned seed = 0; seed < starts; ++seed) {
      pair.q = rest;
      pair.set_random(seed);
      members.push_back({{0, pair.q, pair.v}, {}});
    }
    for (const Ending& ending : run({members.begin(), members.begin() + judged}, "dop853", 1e-12, 1)) {
      if (!ending.trusted) throw std::runtime_error("a reference is not trusted: " + ending.reason);
      ends.push_back(ending.state.q);
    }
  }

  std::vector<Ending> run(const std::vector<Member>& some, const std::string& method, double tolerance,
                          int threads) const {
    SimulationSettings settings = pair.system.settings;
    settings.method = method;
    settings.tolerance = tolerance;
    settings.end_time = 1;
    auto made = simulate_ensemble(pair.system, some, settings, threads);
    if (!made) throw std::runtime_error(made.error().message());
    return *made;
  }
};

/// Updates the largest error with a motion's end; infinite if the run failed or q is not finite.
void judge(const Eigen::Ref<const Eigen::VectorXd>& end, const Eigen::VectorXd& reference, double& largest) {
  const bool whole = end.size() == reference.size() && end.allFinite();
  const double error =
      whole ? (end - reference).cwiseAbs().maxCoeff() : std::numeric_limits<double>::infinity();
  largest = std::max(largest, error);
}

void ours(benchmark::State& bench, Falls& falls, const std::string& method, double tolerance, int threads) {
  std::vector<Ending> endings;
  for (auto _ : bench) endings = falls.run(falls.members, method, tolerance, threads);
  double error = 0;
  for (std::size_t i = 0; i < judged; ++i) judge(endings[i].state.q, falls.ends[i], error);
  const auto trusted =
      std::count_if(endings.begin(), endings.end(), [](const Ending& e) { return e.trusted; });
  bench.SetItemsProcessed(bench.iterations() * starts);
  bench.SetLabel(fmt::format("{:.1e}, {} of {} trusted", error, trusted, starts));
}

void mujocos(benchmark::State& bench, Falls& falls, int steps) {
  mjModel* const model = falls.pair.model;
  mjData* const data = falls.pair.data;
  model->opt.integrator = mjINT_RK4;
  model->opt.timestep = 1. / steps;
  double error = 0;
  for (auto _ : bench)
    for (int i = 0; i < judged; ++i) {
      const State& start = falls.members[std::size_t(i)].start;
      mj_resetData(model, data);
      std::copy(start.q.begin(), start.q.end(), data->qpos);
      std::copy(start.v.begin(), start.v.end(), data->qvel);
      for (int n = 0; n < steps; ++n) mj_step(model, data);
      judge(Eigen::Map<const Eigen::VectorXd>(data->qpos, model->nq), falls.ends[std::size_t(i)], error);
    }
  bench.SetItemsProcessed(bench.iterations() * judged);
  bench.SetLabel(fmt::format("{:.1e}", error));
}

}  // namespace
}  // namespace borelli

int main(int argc, char** argv) {
  using namespace borelli;
  benchmark::Initialize(&argc, argv);
  const std::string file = test::shared_folder() + "/models/bench/human.xml";
  if (!std::filesystem::exists(file)) {
    fmt::print(stderr, "{} is not here: nothing to time\n", file);
    return 0;
  }
  Falls falls(file);
  for (const char* method : {"dop853", "gbs", "gauss16"})
    for (const double tolerance : {1e-3, 1e-6, 1e-9})
      for (const int threads : {1, 0})
        benchmark::RegisterBenchmark(
            fmt::format("{}/{:.0e}/{}", method, tolerance, threads == 1 ? "one_core" : "all_cores").c_str(),
            ours, std::ref(falls), method, tolerance, threads)
            ->UseRealTime()
            ->Unit(benchmark::kMillisecond);
  if (falls.pair.model)
    for (const int steps : {100, 500, 2000})
      benchmark::RegisterBenchmark(fmt::format("mujoco_rk4/{}_ms/one_core", 1000. / steps).c_str(), mujocos,
                                   std::ref(falls), steps)
          ->UseRealTime()
          ->Unit(benchmark::kMillisecond);
  benchmark::RunSpecifiedBenchmarks();
}
