// Nanoseconds for one solution of the equations of motion by the paper's scan (`lagrange`): kinematics, A, B,
// Q, factor, accelerations. Chains of n hinges (every solid depends on all hinges before it) and n
// independent bars.
#include <benchmark/benchmark.h>

#include "dynamics/equations.hpp"

namespace borelli {
namespace {

Scene links(int count, bool chained) {
  Scene scene;
  for (int i = 0; i < count; ++i) {
    Solid solid;
    solid.name = "s" + std::to_string(i);
    if (chained && i > 0) solid.parent = "s" + std::to_string(i - 1);
    Switch place, hinge;
    place.kind = Fixed{Pose{Eigen::Matrix3d::Identity(),
                            chained ? Eigen::Vector3d(0, 0, i ? -1 : 0) : Eigen::Vector3d(2.0 * i, 0, 0)}};
    hinge.kind = Rotation{Eigen::Vector3d::UnitY()};
    solid.switches = {place, hinge};
    Inertial bar;
    bar.mass = 1;
    bar.centre = {0, 0, -0.5};
    bar.tensor.diagonal() << 1.0 / 12, 1.0 / 12, 0.001;
    solid.inertials = {bar};
    scene.solids.push_back(solid);
  }
  return scene;
}

void accelerate(benchmark::State& bench, bool chained) {
  const auto system = compile(links(int(bench.range(0)), chained));
  Workspace workspace(*system);
  Eigen::VectorXd q = Eigen::VectorXd::LinSpaced(system->nq, -1, 1),
                  v = Eigen::VectorXd::LinSpaced(system->nv, 2, -2);
  for (auto _ : bench) {
    const Fault fault = accelerate(*system, system->parameters, 0, q.data(), v.data(), {}, workspace);
    if (fault) bench.SkipWithError("the equations could not be solved");
    benchmark::DoNotOptimize(workspace.a.data());
    q[0] += 1e-9;  // never the same state twice
  }
}

void chain(benchmark::State& bench) { accelerate(bench, true); }
void bars(benchmark::State& bench) { accelerate(bench, false); }

BENCHMARK(chain)->Arg(2)->Arg(7)->Arg(20);
BENCHMARK(bars)->Arg(7)->Arg(50);

}  // namespace
}  // namespace borelli

BENCHMARK_MAIN();
