// Nanoseconds for the accelerations of up to 10000 bodies, by `lagrange` (the paper's scan, then a factor of
// A) and by `recursive` (articulated bodies). Models: chains of n hinges, independent bars, binary trees of
// hinges, a body of ball joints, and a chain with a fixed end. The program ends with the cost of lagrange
// over that of recursive.
#include <benchmark/benchmark.h>

#include <cstdio>
#include <map>

#include "dynamics/equations/equations.hpp"

namespace borelli {
namespace {

/// n solids, the i-th on parent(i) (-1: the world), each on one switch.
template <class Parent>
Scene solids(int n, const SwitchKind& kind, const Parent& parent) {
  Scene scene;
  for (int i = 0; i < n; ++i) {
    Solid solid;
    solid.name = "s" + std::to_string(i);
    if (parent(i) >= 0) solid.parent = "s" + std::to_string(parent(i));
    Switch place, joint;
    place.kind = Fixed{Pose{Eigen::Matrix3d::Identity(), {parent(i) < 0 ? 2.0 * i : 0.0, 0, -1}}};
    joint.kind = kind;
    solid.switches = {place, joint};
    Inertial bar;
    bar.mass = 1;
    bar.centre = {0, 0, -0.5};
    bar.tensor.diagonal() << 1.0 / 12, 1.0 / 12, 0.001;
    solid.inertials = {bar};
    scene.solids.push_back(solid);
  }
  return scene;
}

const Rotation hinge{Eigen::Vector3d::UnitY()};
Scene chain(int n) {
  return solids(n, hinge, [](int i) { return i - 1; });
}
Scene bars(int n) {
  return solids(n, hinge, [](int) { return -1; });
}
Scene binary_tree(int n) {
  return solids(n, hinge, [](int i) { return i == 0 ? -1 : (i - 1) / 2; });
}
Scene balls(int n) {
  return solids(n, Ball{}, [](int i) { return i == 0 ? -1 : (i - 1) / 3; });
}
Scene held_chain(int n) {
  Scene scene = chain(n);
  scene.constraints = {
      {"rod",
       Distance{{"s" + std::to_string(n - 1), {0, 0, -1}}, {"world", {0.5, 0, 0}}, constant(0.5 * n)}}};
  return scene;
}

void accelerations(benchmark::State& bench, Scene (*make)(int), Equations equations) {
  const auto system = compile(make(int(bench.range(0))));
  Workspace workspace(*system, equations);
  Eigen::VectorXd q = system->initial.q, v = Eigen::VectorXd::LinSpaced(system->nv, 2, -2);
  for (const CoordinateInfo& c : system->coordinates)
    if (c.q_size == 1) q[c.q_index] = 2.0 * (c.q_index + 1) / system->nq - 1;
  for (auto _ : bench) {
    const Fault fault = accelerate(*system, system->parameters, 0, q.data(), v.data(), {}, workspace, nullptr,
                                   Wanted::accelerations);
    if (fault) bench.SkipWithError("the equations could not be solved");
    benchmark::DoNotOptimize(workspace.a.data());
    v[0] += 1e-9;  // never the same state twice
  }
}

/// Prints the ratios after the runs.
class Ratios : public benchmark::ConsoleReporter {
 public:
  void ReportRuns(const std::vector<Run>& runs) override {
    ConsoleReporter::ReportRuns(runs);
    for (const Run& run : runs) {
      if (run.error_occurred || (run.run_type == Run::RT_Aggregate && run.aggregate_name != "median"))
        continue;
      double& least = seconds_.try_emplace(run.run_name.str(), 1e9).first->second;
      least = std::min(least, run.GetAdjustedCPUTime());
    }
  }
  void Finalize() override {
    ConsoleReporter::Finalize();
    std::puts("cost of lagrange over recursive (least of the repetitions):");
    for (const auto& [name, time] : seconds_) {
      const auto at = name.find("/lagrange/");
      if (at == std::string::npos) continue;
      std::string other = name;
      other.replace(at, 10, "/recursive/");
      if (const auto found = seconds_.find(other); found != seconds_.end())
        std::printf("  %-28s %6.2f\n", (name.substr(0, at) + name.substr(at + 9)).c_str(),
                    time / found->second);
    }
  }

 private:
  std::map<std::string, double> seconds_;
};

void register_all() {
  const struct {
    const char* name;
    Scene (*make)(int);
    std::vector<int> sizes;
  } scenes[] = {{"chain", chain, {1, 2, 3, 5, 7, 10, 20, 50, 100, 300, 1000, 3000, 10000}},
                {"bars", bars, {7, 50, 100, 300, 1000, 3000, 10000}},
                {"binary_tree", binary_tree, {7, 15, 31, 63, 127, 511, 2047, 8191}},
                {"balls", balls, {1, 4, 13, 40, 121, 364, 1093, 3280, 9841}},
                {"held_chain", held_chain, {3, 7, 20}}};
  for (const auto& scene : scenes)
    for (int n : scene.sizes)
      for (Equations equations : {Equations::lagrange, Equations::recursive}) {
        constexpr int most_by_scan = 400;  // A grows as n^2, its factor's cost as n^3
        if (equations == Equations::lagrange && n > most_by_scan) continue;
        benchmark::RegisterBenchmark(
            (std::string(scene.name) + (equations == Equations::lagrange ? "/lagrange" : "/recursive"))
                .c_str(),
            accelerations, scene.make, equations)
            ->Arg(n);
      }
}

}  // namespace
}  // namespace borelli

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  borelli::register_all();
  borelli::Ratios ratios;
  benchmark::RunSpecifiedBenchmarks(&ratios);
}
