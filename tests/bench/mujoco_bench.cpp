// Nanoseconds for forward dynamics, inverse dynamics and the mass matrix, by the recursive equations and by
// MuJoCo, on the same files in one program. MuJoCo calls only the functions that these results need. A batch
// of eight states, with registers of eight numbers and with narrower ones, is compared with eight calls to
// MuJoCo. The program ends with the ratios of the medians: run it with --benchmark_repetitions and
// --benchmark_enable_random_interleaving=true.
#include <filesystem>

#include "dynamics/equations/inverse_dynamics.hpp"
#include "dynamics/numbers/processor.hpp"
#include "tests/bench/mujoco_pair.hpp"
#include "tests/bench/peer_ratios.hpp"
#include "tests/paths.hpp"

namespace borelli {
namespace {

using Pair = MujocoPair;

/// MuJoCo's first stage, which velocities and inertias need.
void place(Pair& p) {
  mj_kinematics(p.model, p.data);
  mj_comPos(p.model, p.data);
}

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
  place(p);
  mj_crb(p.model, p.data);
  mj_factorM(p.model, p.data);
  mj_comVel(p.model, p.data);
  mj_rne(p.model, p.data, 0, p.data->qfrc_bias);
  for (int i = 0; i < p.model->nv; ++i) p.data->qfrc_smooth[i] = -p.data->qfrc_bias[i];
  mj_solveM(p.model, p.data, p.data->qacc_smooth, p.data->qfrc_smooth, 1);
  benchmark::DoNotOptimize(p.data->qacc_smooth);
}

template <Evaluate mujoco>
void eight_times(Pair& p) {
  for (int lane = 0; lane < Lanes::count; ++lane) mujoco(p);
}

void efforts(Pair& p) {
  Workspace& w = *p.workspace;
  const Parameters& parameters = p.system.parameters;
  inverse_dynamics<double>(p.system, parameters, parameters.inertials, 0, p.q.data(), p.v.data(), p.a.data(),
                           w.kinematics, w.efforts, w.articulation, p.needed.data());
  benchmark::DoNotOptimize(p.needed.data());
}
void efforts_of_eight(Pair& p) {
  inverse_dynamics(p.system, p.system.parameters, *p.eight, p.accelerations_of_eight, *p.batch,
                   p.efforts_of_eight);
  benchmark::DoNotOptimize(p.efforts_of_eight.data());
}
void mujoco_efforts(Pair& p) {
  place(p);
  mj_comVel(p.model, p.data);
  mj_rne(p.model, p.data, 1, p.data->qfrc_inverse);
  benchmark::DoNotOptimize(p.data->qfrc_inverse);
}

void mass_matrix(Pair& p) {
  Workspace& w = *p.workspace;
  const Parameters& parameters = p.system.parameters;
  update_kinematics<double>(p.system, parameters, parameters.inertials, 0, p.q.data(), nullptr, nullptr,
                            w.kinematics);
  find_mass_matrix(p.system, parameters, parameters.inertials, w.kinematics, *w.recursion, w.terms);
  benchmark::DoNotOptimize(w.terms.A.data());
}
void mass_matrices_of_eight(Pair& p) {
  find_mass_matrix(p.system, p.system.parameters, *p.eight, *p.batch);
  benchmark::DoNotOptimize(p.batch->terms.A.data());
}
void mujoco_mass_matrix(Pair& p) {
  place(p);
  mj_crb(p.model, p.data);
  benchmark::DoNotOptimize(p.data->qM);
}

/// Evaluates with registers of at most `width` numbers.
template <int width, Evaluate evaluate>
void by_registers(Pair& p) {
  const int widest = register_width;
  register_width = std::min(width, widest);
  evaluate(p);
  register_width = widest;
}

void run(benchmark::State& bench, Pair& pair, Evaluate evaluate) {
  for (auto _ : bench) {
    evaluate(pair);
    pair.v[0] += 1e-9;  // never the same state twice
    pair.eight->v[0] += 1e-9;
  }
}

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
    Pair& pair = *pairs.emplace_back(
        std::make_unique<Pair>(file, mjDSBL_CONSTRAINT | mjDSBL_CONTACT | mjDSBL_ACTUATION));
    pair.set_random(1);
    const auto add = [&](const std::string& what, Evaluate ours, Evaluate theirs) {
      const std::string title = std::string(name) + "/" + what;
      benchmark::RegisterBenchmark(title.c_str(), run, std::ref(pair), ours);
      if (pair.model) benchmark::RegisterBenchmark((title + "/mujoco").c_str(), run, std::ref(pair), theirs);
    };
    const auto add_eight = [&]<Evaluate ours, Evaluate theirs>(const std::string& what) {
      add(what, ours, eight_times<theirs>);
      const std::string title = std::string(name) + "/" + what;
      const std::pair<int, Evaluate> lesser[] = {{4, by_registers<4, ours>}, {2, by_registers<2, ours>}};
      for (const auto& [width, evaluate] : lesser)
        if (width < register_width)
          benchmark::RegisterBenchmark((title + "_by_" + std::to_string(width)).c_str(), run, std::ref(pair),
                                       evaluate);
    };
    add("accelerations", accelerations, mujoco_accelerations);
    add_eight.operator()<accelerations_of_eight, mujoco_accelerations>("accelerations_of_eight");
    add("efforts", efforts, mujoco_efforts);
    add_eight.operator()<efforts_of_eight, mujoco_efforts>("efforts_of_eight");
    add("mass_matrix", mass_matrix, mujoco_mass_matrix);
    if (pair.mass_matrices)
      add_eight.operator()<mass_matrices_of_eight, mujoco_mass_matrix>("mass_matrix_of_eight");
  }
  PeerRatios ratios("mujoco");
  benchmark::RunSpecifiedBenchmarks(&ratios);
}
