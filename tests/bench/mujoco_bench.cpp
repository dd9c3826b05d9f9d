// Nanoseconds from positions and velocities to accelerations, from these and accelerations to efforts, and to
// the mass matrix: the recursive equations and MuJoCo's on the same files in one run, MuJoCo with the least
// of its functions that give the same; and of eight states in a batch, which stand beside eight times
// MuJoCo's one. In the end the ratios of the medians; so run with
// --benchmark_repetitions and --benchmark_enable_random_interleaving=true.
#include <benchmark/benchmark.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <random>

#include "dynamics/batch.hpp"
#include "dynamics/inverse_dynamics.hpp"
#include "dynamics/model_file.hpp"
#include "tests/paths.hpp"

namespace borelli {
namespace {

/// One file in both engines, at one state.
struct Pair {
  System system;
  std::unique_ptr<Workspace> workspace;
  std::unique_ptr<BatchState> eight;
  std::unique_ptr<BatchWorkspace> batch;
  mjModel* model = nullptr;
  mjData* data = nullptr;
  Eigen::VectorXd q, v, a, needed;

  explicit Pair(const std::string& file) {
    auto read = read_model(file);
    if (!read) throw std::runtime_error(read.error().what);
    read->scene.simulation.equations = Equations::recursive;
    auto compiled = compile(read->scene);
    if (!compiled) throw std::runtime_error(compiled.error().what);
    system = std::move(*compiled);
    workspace = std::make_unique<Workspace>(system);
    std::mt19937 random(1);
    std::uniform_real_distribution<double> number(-1, 1);
    q = system.initial.q;
    v = a = needed = Eigen::VectorXd(system.nv);
    for (const CoordinateInfo& c : system.coordinates) {
      for (int i = 0; i < c.q_size; ++i) q[c.q_index + i] = number(random);
      if (c.q_size == 4) q.segment<4>(c.q_index).normalize();
    }
    for (double& x : v) x = number(random);
    for (double& x : a) x = number(random);
    eight = std::make_unique<BatchState>(system);
    batch = std::make_unique<BatchWorkspace>(system);
    for (int lane = 0; lane < Lanes::count; ++lane) eight->set(lane, {0, q, v});
    char error[1000] = "";
    model = mj_loadXML(file.c_str(), nullptr, error, sizeof error);
    if (!model) {
      std::fprintf(stderr, "MuJoCo cannot read %s: %s\n", file.c_str(), error);
      return;
    }
    model->opt.disableflags |= mjDSBL_CONSTRAINT | mjDSBL_CONTACT | mjDSBL_ACTUATION;
    data = mj_makeData(model);
    std::copy(q.begin(), q.end(), data->qpos);
    std::copy(v.begin(), v.end(), data->qvel);
    std::copy(a.begin(), a.end(), data->qacc);
  }
  ~Pair() {
    mj_deleteData(data);
    mj_deleteModel(model);
  }
  Pair(const Pair&) = delete;
  Pair& operator=(const Pair&) = delete;

  void place() {
    mj_kinematics(model, data);
    mj_comPos(model, data);
  }
};

using Evaluate = void (*)(Pair&);

void accelerations(Pair& p) {
  if (accelerate(p.system, p.system.parameters, 0, p.q.data(), p.v.data(), {}, *p.workspace, nullptr,
                 Wanted::accelerations))
    throw std::runtime_error("the equations could not be solved");
  benchmark::DoNotOptimize(p.workspace->a.data());
}
void accelerations_of_eight(Pair& p) {
  if (!accelerate(p.system, p.system.parameters, *p.eight, *p.batch, nullptr, Wanted::accelerations))
    throw std::runtime_error("the equations could not be solved");
  benchmark::DoNotOptimize(p.batch->a.data());
}
void mujoco_accelerations(Pair& p) {
  p.place();
  mj_crb(p.model, p.data);
  mj_factorM(p.model, p.data);
  mj_comVel(p.model, p.data);
  mj_rne(p.model, p.data, 0, p.data->qfrc_bias);
  for (int i = 0; i < p.model->nv; ++i) p.data->qfrc_smooth[i] = -p.data->qfrc_bias[i];
  mj_solveM(p.model, p.data, p.data->qacc_smooth, p.data->qfrc_smooth, 1);
  benchmark::DoNotOptimize(p.data->qacc_smooth);
}

void mujoco_accelerations_of_eight(Pair& p) {
  for (int lane = 0; lane < Lanes::count; ++lane) mujoco_accelerations(p);
}

void efforts(Pair& p) {
  Workspace& w = *p.workspace;
  const Parameters& parameters = p.system.parameters;
  inverse_dynamics<double>(p.system, parameters, parameters.inertials, 0, p.q.data(), p.v.data(), p.a.data(),
                           w.kinematics, w.efforts, w.articulation, p.needed.data());
  benchmark::DoNotOptimize(p.needed.data());
}
void mujoco_efforts(Pair& p) {
  p.place();
  mj_comVel(p.model, p.data);
  mj_rne(p.model, p.data, 1, p.data->qfrc_inverse);
  benchmark::DoNotOptimize(p.data->qfrc_inverse);
}

void mass_matrix(Pair& p) {
  Workspace& w = *p.workspace;
  const Parameters& parameters = p.system.parameters;
  update_kinematics<double>(p.system, parameters, parameters.inertials, 0, p.q.data(), nullptr, nullptr,
                            w.kinematics);
  find_mass_matrix(p.system, parameters, parameters.inertials, w.kinematics, w.recursion, w.terms);
  benchmark::DoNotOptimize(w.terms.A.data());
}
void mujoco_mass_matrix(Pair& p) {
  p.place();
  mj_crb(p.model, p.data);
  benchmark::DoNotOptimize(p.data->qM);
}

void run(benchmark::State& bench, Pair& pair, Evaluate evaluate) {
  for (auto _ : bench) {
    evaluate(pair);
    pair.v[0] += 1e-9;  // never the same state twice
    pair.eight->v[0] += 1e-9;
  }
}

/// Prints after the runs what MuJoCo takes over what we take.
class Ratios : public benchmark::ConsoleReporter {
 public:
  void ReportRuns(const std::vector<Run>& runs) override {
    ConsoleReporter::ReportRuns(runs);
    for (const Run& run : runs)
      if (!run.error_occurred && run.run_type == Run::RT_Iteration)
        times_[run.run_name.function_name].push_back(run.GetAdjustedCPUTime());
  }
  void Finalize() override {
    ConsoleReporter::Finalize();
    std::printf("%-32s %12s %12s %8s   (medians, ns)\n", "", "borelli", "mujoco", "ratio");
    for (const auto& [name, times] : times_) {
      if (name.ends_with("/mujoco")) continue;
      const double ours = median(times);
      std::printf("%-32s %12.1f", name.c_str(), ours);
      if (const auto other = times_.find(name + "/mujoco"); other != times_.end())
        std::printf(" %12.1f %8.2f", median(other->second), median(other->second) / ours);
      std::puts("");
    }
  }

 private:
  static double median(std::vector<double> times) {
    std::nth_element(times.begin(), times.begin() + times.size() / 2, times.end());
    return times[times.size() / 2];
  }
  std::map<std::string, std::vector<double>> times_;
};

}  // namespace
}  // namespace borelli

int main(int argc, char** argv) {
  using namespace borelli;
  benchmark::Initialize(&argc, argv);
  std::vector<std::unique_ptr<Pair>> pairs;
  for (const char* name : {"human", "chain7", "chain20", "chain100", "chain1000", "bars50"}) {
    const std::string file = test::shared_folder() + "/models/bench/" + name + ".xml";
    if (!std::filesystem::exists(file)) {
      std::fprintf(stderr, "%s is not here: left out\n", file.c_str());
      continue;
    }
    Pair& pair = *pairs.emplace_back(std::make_unique<Pair>(file));
    const auto add = [&](const std::string& what, Evaluate ours, Evaluate theirs) {
      const std::string title = std::string(name) + "/" + what;
      benchmark::RegisterBenchmark(title.c_str(), run, std::ref(pair), ours);
      if (pair.model) benchmark::RegisterBenchmark((title + "/mujoco").c_str(), run, std::ref(pair), theirs);
    };
    add("accelerations", accelerations, mujoco_accelerations);
    add("accelerations_of_eight", accelerations_of_eight, mujoco_accelerations_of_eight);
    add("efforts", efforts, mujoco_efforts);
    add("mass_matrix", mass_matrix, mujoco_mass_matrix);
  }
  Ratios ratios;
  benchmark::RunSpecifiedBenchmarks(&ratios);
}
