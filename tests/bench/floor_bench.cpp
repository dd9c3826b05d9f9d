// The human dropped on the floor (human_floor.toml, then the same as MJCF, human_contact.xml, where that is
// here; or the scenes and models that are named; 5 s) by Moreau's time stepping at several steps, from twelve
// heights. Tables in Markdown: processor time and real-time factor; of all falls the mean of the steps, the
// deepest overlap, the largest error of the energy balance and most that putting apart moved; how far a
// frictionless floor lets the horizontal momentum stray, which it cannot change; and how many are trusted.
#include <fmt/core.h>

#include <algorithm>
#include <ctime>
#include <filesystem>
#include <vector>

#include "dynamics/model_file.hpp"
#include "dynamics/simulate.hpp"
#include "tests/paths.hpp"

namespace borelli {
namespace {

constexpr int starts = 12;  // each a millimetre above the one before: falls so alike end in unlike heaps

struct Falls {
  std::vector<double> times;                 // s
  double overlap = 0, moved = 0, drift = 0;  // m, J, and in parts of what is turned over: the worst of all
  long steps = 0, rejected = 0;
  int trusted = 0;
  std::string first_reason;
};

Falls fall(const ModelFile& model, const System& system, const SimulationSettings& settings) {
  Falls out;
  for (int i = 0; i < starts; ++i) {
    State start = system.initial;
    start.q[2] += 1e-3 * i;
    const std::clock_t begin = std::clock();
    auto motion = simulate(system, start, settings);
    out.times.push_back(double(std::clock() - begin) / CLOCKS_PER_SEC);
    std::string reason = motion ? "" : motion.error().what;
    if (motion) {
      judge_passing(model.without_contact, *motion);
      const Certificate& c = motion->certificate;
      for (const ConstraintResidual& residual : c.residuals)
        out.overlap = std::max(out.overlap, residual.position);
      out.moved = std::max(out.moved, c.work_projection_size);
      out.drift = std::max(out.drift, c.energy_drift / c.energy_turnover);
      out.steps += c.steps_accepted;
      out.rejected += c.steps_rejected;
      out.trusted += c.trusted;
      if (!c.trusted) reason = c.reason;
    }
    if (out.first_reason.empty()) out.first_reason = reason;
  }
  std::sort(out.times.begin(), out.times.end());
  return out;
}

/// The largest horizontal momentum without friction, kg m/s (the start has none), or when the run ended.
std::string stray_momentum(Scene scene, const SimulationSettings& settings) {
  for (Constraint& constraint : scene.constraints)
    std::visit(
        [](auto& kind) {
          if constexpr (requires { kind.surface; }) kind.surface.friction = 0;
        },
        constraint.kind);
  const auto system = compile(scene);
  const auto run = simulate(*system, system->initial, settings);
  if (!run) return run.error().what;
  return fmt::format("{:.2g} kg m/s", run->linear_momentum.leftCols<2>().rowwise().norm().maxCoeff());
}

int run(const std::string& path) {
  auto model = read_model(path);
  if (!model) return fmt::print(stderr, "{}\n", model.error().message()), 2;
  model->scene.simulation.end_time = 5;
  const auto system = compile(model->scene);
  if (!system) return fmt::print(stderr, "{}\n", system.error().message()), 2;
  fmt::print(
      "{}:\n\n"
      "| step | steps (tried in vain) | median (least, most) | real-time factor | overlap | energy off by | "
      "put apart | momentum strays by | trusted |\n"
      "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n",
      std::filesystem::path(path).filename().string());
  for (const double step : {1e-2, 5e-3, 2e-3, 1e-3}) {
    SimulationSettings settings = system->settings;
    settings.step = step;
    settings.output_interval = 0.02;
    const Falls falls = fall(*model, *system, settings);
    const double time = falls.times[starts / 2];
    fmt::print(
        "| {:g} ms | {} ({}) | {:.0f} ({:.0f}, {:.0f}) ms | {:.0f} | {:.3f} mm | {:.2f} % | {:.2f} J | {} | "
        "{} of {}{}{} |\n",
        1e3 * step, falls.steps / starts, falls.rejected / starts, 1e3 * time, 1e3 * falls.times.front(),
        1e3 * falls.times.back(), settings.end_time / time, 1e3 * falls.overlap, 100 * falls.drift,
        falls.moved, stray_momentum(model->scene, settings), falls.trusted, starts,
        falls.first_reason.empty() ? "" : ": ", falls.first_reason);
  }
  fmt::print("\n");
  return 0;
}

}  // namespace
}  // namespace borelli

int main(int argc, char** argv) {
  using namespace borelli;
  std::vector<std::string> files(argv + 1, argv + argc);
  if (files.empty()) {
    files = {test::source_folder() + "/tests/bench/human_floor.toml"};
    const std::string model = test::shared_folder() + "/models/bench/human_contact.xml";
    if (std::filesystem::exists(model)) files.push_back(model);
  }
  for (const std::string& file : files)
    if (const int failed = run(file)) return failed;
}
