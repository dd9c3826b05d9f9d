// How well --accuracy chooses: auto_bench [SCENE | SEED ...]. Runs each scene by every method and by the
// program's own choice (without the verifying run). Prints two ratios per scene and requested accuracy: the
// error over the accuracy, and the evaluations over those of the cheapest method at that error. Without
// arguments it runs the samples and random trees. The choice was tuned on every other family of samples
// (pendulum and pendulum_3 to pendulum_7 are one family) and 40 trees; the other families and 40 other trees
// judge it. A number is the seed of a tree. Chaotic scenes count up to where their reference ends.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "dynamics/formats/model_file.hpp"
#include "pipeline/charts/work_precision.hpp"
#include "tests/dynamics/random_scene.hpp"

namespace borelli {
namespace {

constexpr double loose = 1e-2, tight = 1e-9;  // accuracies judged

double error_of(const WorkPrecisionPoint& p) { return std::max(p.errors.position, p.errors.orientation); }

// evaluations that the cheapest method needs for that error, interpolated between its runs in logarithms
struct Cheapest {
  double evaluations = std::numeric_limits<double>::infinity();
  std::string method = "none";
};
Cheapest cheapest(const WorkPrecision& chart, double error) {
  Cheapest out;
  for (std::size_t v = 0; v < chart.variants.size(); ++v) {
    if (chart.variants[v].method == automatic) continue;
    double best = std::numeric_limits<double>::infinity();
    const WorkPrecisionPoint* coarser = nullptr;
    for (const WorkPrecisionPoint& p : chart.points) {
      if (p.variant != v || !p.finished || !p.trusted) continue;
      if (error_of(p) <= error) {
        const auto cost = double(p.evaluations);
        best = std::min(best, cost);
        if (coarser && error_of(p) > 0 && coarser->evaluations < p.evaluations) {
          const double part = std::log(error / error_of(p)) / std::log(error_of(*coarser) / error_of(p));
          best = std::min(best, cost * std::pow(double(coarser->evaluations) / cost, part));
        }
        break;
      }
      coarser = &p;
    }
    if (best < out.evaluations) out = {best, chart.variants[v].method};
  }
  return out;
}

struct Judged {
  int runs = 0, within = 0, cheap = 0, failed = 0;
  std::vector<double> costs;

  void print(const char* name) {
    if (runs == 0) return;
    std::sort(costs.begin(), costs.end());
    fmt::print(
        "{:24} {:4} runs: {:5.1f} % within 10 times what was asked, {:5.1f} % at most twice the cheapest "
        "(median {:.2f}), {} failed or untrusted\n",
        name, runs, 100. * within / runs, 100. * cheap / runs, costs.empty() ? 0 : costs[costs.size() / 2],
        failed);
  }
};

void judge(Scene scene, Judged& all) {
  WorkPrecisionSettings settings;
  settings.equations = {Equations::recursive};
  settings.constraints = {ConstraintTreatment::projection};
  settings.repeats = 1;
  settings.budget = 0.1;
  auto chart = work_precision(scene, settings);
  // a choice is judged over the whole motion
  if (chart && chart->reference.found && chart->reference.horizon < scene.simulation.end_time * (1 - 1e-9)) {
    scene.simulation.end_time = chart->reference.horizon;
    chart = work_precision(scene, settings);
  }
  if (!chart) {
    fmt::print("{}: {}\n", scene.name, chart.error().message());
    return;
  }
  if (!chart->reference.found) {
    fmt::print("{}: no reference\n", scene.name);
    return;
  }
  const double known = 10 * std::max(chart->reference.position, chart->reference.orientation);
  for (const WorkPrecisionPoint& p : chart->points) {
    if (chart->variants[p.variant].method != automatic || p.setting > loose * 1.01 || p.setting < tight * .99)
      continue;
    if (p.setting < known) continue;
    ++all.runs;
    if (!p.finished || !p.trusted) {
      ++all.failed;
      fmt::print("{:24} {:6.0e}  {}\n", scene.name, p.setting, p.reason);
      continue;
    }
    const double error = error_of(p);
    const Cheapest best = cheapest(*chart, std::max(error, known));
    const double cost = double(p.evaluations) / best.evaluations;
    const bool within = error <= 10 * p.setting, cheap = cost <= 2;
    all.within += within;
    all.cheap += cheap;
    all.costs.push_back(cost);
    fmt::print("{:24} {:6.0e}  off by {:8.2e} of it{}, cost {:6.2f} of {:.0f} by {}{}\n", scene.name,
               p.setting, error / p.setting, within ? " " : "!", cost, best.evaluations, best.method,
               cheap ? "" : " !");
  }
}

std::string family_of(const std::filesystem::path& file) {
  const std::string name = file.stem().string();
  return name.substr(0, name.find_last_not_of("_0123456789") + 1);
}

Scene random_tree(unsigned seed) {
  Scene scene = test::RandomScene(seed, 2 + int(seed % 5), false).scene;
  scene.name = fmt::format("random {}", seed);
  scene.simulation.end_time = 3;
  return scene;
}

}  // namespace
}  // namespace borelli

int main(int argc, char** argv) {
  using namespace borelli;
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  const auto of_file = [](const std::filesystem::path& file, Judged& all) {
    if (const auto model = read_model(file.string(), {}))
      judge(model->scene, all);
    else
      fmt::print("{}\n", model.error().message());
  };
  if (argc > 1) {
    Judged asked;
    for (int i = 1; i < argc; ++i) {
      const std::string what = argv[i];
      if (what.find_first_not_of("0123456789") == std::string::npos)
        judge(random_tree(unsigned(std::stoul(what))), asked);
      else
        of_file(what, asked);
    }
    asked.print("asked for");
    return 0;
  }
  std::vector<std::filesystem::path> samples;
  for (const auto& entry : std::filesystem::directory_iterator(test::source_folder() + "/samples"))
    if (entry.path().extension() == ".toml") samples.push_back(entry.path());
  std::sort(samples.begin(), samples.end());
  Judged tuned, held_out, tuned_random, random;
  std::map<std::string, std::size_t> families;  // by name without its number, in order
  for (const auto& file : samples) families.try_emplace(family_of(file), 0);
  std::size_t place = 0;
  for (auto& [name, number] : families) number = place++;
  for (const auto& file : samples) of_file(file, families[family_of(file)] % 2 ? held_out : tuned);
  for (unsigned seed = 1; seed <= 80; ++seed) judge(random_tree(seed), seed <= 40 ? tuned_random : random);
  tuned.print("samples tuned on");
  held_out.print("samples held out");
  tuned_random.print("random trees tuned on");
  random.print("random trees held out");
}
