// Nanoseconds from positions and velocities to accelerations with closed loops. Borelli and MuJoCo run the
// same models in one program: N windows of bars (the IFToMM benchmark's "N-four-bar", A02), and a human whose
// feet are both fixed to the ground.
//
// `accelerations` is one evaluation within a step; `accelerations_and_rank` adds the search for dependent
// rows, done once per step. MuJoCo's rows are soft, so it has no dependent rows; its warm-started Newton
// solver finds the forces. The program ends with the ratios of the medians: run it with
// --benchmark_repetitions and --benchmark_enable_random_interleaving=true.
#include <fmt/core.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "tests/bench/mujoco_pair.hpp"
#include "tests/bench/peer_ratios.hpp"
#include "tests/paths.hpp"

namespace borelli {
namespace {

/// N windows of bars of 1 m and 1 kg, upright.
std::string windows(int n) {
  const auto bar = [](const std::string& name, const std::string& place, const char* centre,
                      const char* inertia, const std::string& inside) {
    return fmt::format(
        "<body name='{}' pos='{}'><joint type='hinge' axis='0 -1 0'/>"
        "<inertial pos='{}' mass='1' diaginertia='{}'/>{}</body>\n",
        name, place, centre, inertia, inside);
  };
  std::string bodies, loops;
  for (int i = 0; i <= n; ++i) {
    std::string coupler;
    if (i < n) {
      coupler = bar(fmt::format("coupler{}", i), "0 0 1", "0.5 0 0", "0.001 0.08333333333 0.08333333333", "");
      loops += fmt::format("<connect body1='coupler{}' body2='crank{}' anchor='1 0 0'/>\n", i, i + 1);
    }
    bodies += bar(fmt::format("crank{}", i), fmt::format("{} 0 0", i), "0 0 0.5",
                  "0.08333333333 0.08333333333 0.001", coupler);
  }
  return fmt::format(
      "<mujoco model='windows'><compiler angle='radian'/><size njmax='{}'/>\n"
      "<worldbody>\n{}</worldbody>\n<equality>\n{}</equality></mujoco>\n",
      100 + 10 * n, bodies, loops);
}

/// The MJCF human with both feet held; empty if the file is missing.
std::string standing_human() {
  std::ifstream file(test::shared_folder() + "/models/bench/human.xml");
  std::stringstream text;
  text << file.rdbuf();
  std::string out = text.str();
  const auto end = out.rfind("</mujoco>");
  if (end == std::string::npos) return "";
  return out.insert(end, "<equality><weld body1='footL'/><weld body1='footR'/></equality>\n");
}

/// A pair from a model's text, which must not name other files.
std::unique_ptr<MujocoPair> pair_of(const std::string& text) {
  const auto file = std::filesystem::temp_directory_path() /
                    fmt::format("constraints_bench_{}.xml", std::random_device()());
  std::ofstream(file) << text;
  auto pair = std::make_unique<MujocoPair>(file.string(), mjDSBL_CONTACT | mjDSBL_ACTUATION);
  std::filesystem::remove(file);
  return pair;
}

void accelerations(benchmark::State& bench, MujocoPair& p, bool decide_rank) {
  const auto solve = [&](bool rank) {
    if (accelerate(p.system, p.system.parameters, 0, p.q.data(), p.v.data(), {.decide_rank = rank},
                   *p.workspace, nullptr, Wanted::accelerations))
      throw std::runtime_error("the equations could not be solved");
  };
  solve(true);
  for (auto _ : bench) {
    solve(decide_rank);
    benchmark::DoNotOptimize(p.workspace->a.data());
    p.v[0] += 1e-12;  // never the same state twice
  }
}

void mujoco_accelerations(benchmark::State& bench, MujocoPair& p) {
  for (auto _ : bench) {
    mj_forward(p.model, p.data);
    benchmark::DoNotOptimize(p.data->qacc);
    std::copy_n(p.data->qacc, p.model->nv, p.data->qacc_warmstart);
    p.data->qvel[0] += 1e-12;
  }
}

void add(const std::string& name, MujocoPair& pair) {
  for (const bool rank : {false, true})
    benchmark::RegisterBenchmark((name + (rank ? "/accelerations_and_rank" : "/accelerations")).c_str(),
                                 accelerations, std::ref(pair), rank);
  if (pair.model)
    benchmark::RegisterBenchmark((name + "/accelerations/mujoco").c_str(), mujoco_accelerations,
                                 std::ref(pair));
}

}  // namespace
}  // namespace borelli

int main(int argc, char** argv) {
  using namespace borelli;
  benchmark::Initialize(&argc, argv);
  std::vector<std::unique_ptr<MujocoPair>> pairs;
  for (const int n : {1, 2, 5, 10, 20, 40, 80, 160, 320, 640}) {
    MujocoPair& pair = *pairs.emplace_back(pair_of(windows(n)));
    for (int i = 0; i < pair.system.nv; ++i) {  // all cranks lean, all couplers stay level
      const bool crank = pair.system.coordinates[std::size_t(i)].solid.starts_with("crank");
      pair.q[i] = crank ? -0.3 : 0.3;
      pair.v[i] = crank ? -1 : 1;
    }
    pair.set();
    add(fmt::format("windows{}", n), pair);
  }
  if (const std::string human = standing_human(); !human.empty())
    add("standing_human", *pairs.emplace_back(pair_of(human)));
  else
    fmt::print(stderr, "the data's human.xml is not here: left out\n");
  PeerRatios ratios("mujoco");
  benchmark::RunSpecifiedBenchmarks(&ratios);
}
