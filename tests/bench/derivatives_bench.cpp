// The cost of derivatives relative to the function that they differentiate. Three ratios: dtau/d(q, v) and A
// to inverse dynamics; da/d(q, v) and the accelerations to the accelerations alone; evaluate(), with a given
// Workspace and with a new one, to the accelerations. Processor time of one thread, least of the rounds.
// Writes a table.
#include <fmt/format.h>
#include <time.h>

#include <filesystem>
#include <functional>

#include "dynamics/equations/evaluate.hpp"
#include "dynamics/equations/inverse_dynamics.hpp"
#include "dynamics/equations/state_derivatives.hpp"
#include "dynamics/formats/model_file.hpp"
#include "tests/paths.hpp"

namespace borelli {
namespace {

double processor_time() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

/// A function to be timed, and its least time per call, s.
struct Timed {
  std::function<void()> call;
  double least = 1e9;

  void round() {
    constexpr int calls = 50;
    const double start = processor_time();
    for (int i = 0; i < calls; ++i) call();
    least = std::min(least, (processor_time() - start) / calls);
  }
};

void need(bool solved) {
  if (!solved) throw std::runtime_error("the equations could not be solved");
}

void compare(const std::string& name, const System& system) {
  const Parameters& p = system.parameters;
  State state = system.initial;
  for (const CoordinateInfo& c : system.coordinates)
    if (c.q_size == 1) state.q[c.q_index] = 2.0 * (c.q_index + 1) / system.nq - 1;
  state.v.setLinSpaced(2, -2);
  const Eigen::VectorXd a = Eigen::VectorXd::LinSpaced(system.nv, -1, 1), none(0);
  Eigen::VectorXd needed(system.nv);
  Workspace w(system);
  StateDerivatives d(system);
  const auto move = [&] { state.v[0] += 1e-9; };  // never the same state twice
  const auto solve = [&] {
    move();
    need(!accelerate(system, p, 0, state.q.data(), state.v.data(), {}, w, nullptr, Wanted::accelerations));
  };
  Timed timed[] = {
      {[&] {
        move();
        inverse_dynamics<double>(system, p, p.inertials, 0, state.q.data(), state.v.data(), a.data(),
                                 w.kinematics, w.efforts, w.articulation, needed.data());
      }},
      {[&] {
        move();
        find_residual_derivatives(system, p, 0, state.q.data(), state.v.data(), a.data(), none, d);
      }},
      {solve},
      {[&] {
        solve();
        need(!find_acceleration_derivatives(system, p, 0, state.q.data(), state.v.data(), w, d));
      }},
      {[&] {
        move();
        need(evaluate(system, state, none, w).has_value());
      }},
      {[&] {
        move();
        need(evaluate(system, state).has_value());
      }}};
  for (int round = 0; round < 40; ++round)
    for (Timed& each : timed) each.round();
  const auto ratio = [&](int i, int over) { return timed[i].least / timed[over].least; };
  fmt::print("| {} | {} | {:.2f} | {:.2f} | {:.1f} | {:.2f} | {:.2f} | {:.1f} | {:.1f} | {:.1f} |\n", name,
             system.nv, 1e6 * timed[0].least, 1e6 * timed[1].least, ratio(1, 0), 1e6 * timed[2].least,
             1e6 * timed[3].least, ratio(3, 2), ratio(4, 2), ratio(5, 2));
}

}  // namespace
}  // namespace borelli

int main() {
  using namespace borelli;
  fmt::print(
      "| scene | nv | inverse dynamics, us | with derivatives, us | ratio | accelerations, us | with "
      "derivatives, us | ratio | evaluate, workspace kept, ratio | evaluate, ratio |\n"
      "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n");
  for (const char* name : {"human", "chain7", "chain20", "chain100", "bars50"}) {
    const std::string file = test::shared_folder() + "/models/bench/" + name + ".xml";
    if (!std::filesystem::exists(file)) {
      fmt::print(stderr, "{} is not here: left out\n", file);
      continue;
    }
    auto read = read_model(file);
    if (!read) throw std::runtime_error(read.error().what);
    read->scene.simulation.equations = Equations::recursive;
    const auto system = compile(read->scene);
    if (!system) throw std::runtime_error(system.error().what);
    compare(name, *system);
  }
}
