// Measures the comparison that the paper makes in words. Lagrange's equations by direct and by symbolic
// treatment are set against the paper's (`lagrange`) and today's (`recursive`), and the paper's integrators
// against today's: time for an error, with and without the set-up. See README.md.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>

#include "dynamics/equations/evaluate.hpp"
#include "dynamics/formats/model_file.hpp"
#include "pipeline/charts/work_precision_page.hpp"
#include "pipeline/files/whole_file.hpp"
#include "symbolic_scenes.hpp"
#include "treatments.hpp"

#define BORELLI_DECLARE(name) \
  extern "C" void name(const double*, const double*, double*, double*, double*, double*, double*);
BORELLI_SYMBOLIC(BORELLI_DECLARE)

namespace borelli {
namespace {

struct Derived {
  std::string scene;  ///< the file's name
  SymbolicTerms terms;
};
#define BORELLI_LIST(name) {#name, ::name},
const std::vector<Derived> derived = {BORELLI_SYMBOLIC(BORELLI_LIST)};

const std::vector<std::string> methods = {"rk4", "rk4_adaptive", "dopri5", "dop853"};
const std::vector<std::string> treatments = {"direct", "symbolic", "lagrange", "recursive"};
constexpr double decades[] = {1e-2, 1e-4, 1e-6, 1e-8};

struct Options {
  std::vector<std::string> scenes;
  std::string folder = "paper";
  WorkPrecisionSettings settings;
  double end = 0;
};

std::string treatment_of(const Variant& v) {
  if (v.other) return v.method.substr(0, v.method.find(','));
  return v.equations == Equations::lagrange ? "lagrange" : "recursive";
}

std::string method_of(const Variant& v) {
  return v.other ? v.method.substr(v.method.find(", ") + 2) : v.method;
}

/// Time that sympy and the C compiler took, s, from symbolic.py's record.
Result<std::pair<double, double>> symbolic_setup(const std::string& name) {
  std::ifstream file(std::filesystem::path(BORELLI_SYMBOLIC_FOLDER) / (name + ".seconds"));
  std::pair<double, double> out;
  if (!(file >> out.first >> out.second)) return failure(name, "has no account of what symbolic.py took");
  return out;
}

/// Time to read and compile a scene, s.
double own_setup(const std::string& file) {
  std::vector<double> seconds;
  for (int i = 0; i < 9; ++i) {
    const double start = processor_time();
    const auto model = read_model(file, {});
    const auto system = model ? compile(model->scene) : tl::unexpected(model.error());
    if (system) seconds.push_back(processor_time() - start);
  }
  std::sort(seconds.begin(), seconds.end());
  return seconds[seconds.size() / 2];
}

/// The largest relative difference of a treatment's accelerations from the recursive ones, at the start's
/// positions with its own and with random velocities.
double disagreement(System system, Treatment& treatment) {
  system.settings.baumgarte_alpha = system.settings.baumgarte_beta = 0;  // `evaluate` has none
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  double worst = 0;
  for (int trial = 0; trial < 20; ++trial) {
    State state = system.initial;
    for (int i = 0; trial > 0 && i < system.nv; ++i) {
      state.v[i] += normal(random);
      if (system.rows == 0) state.q[i] += normal(random);
    }
    const auto ours = evaluate(system, state);
    if (!ours) return std::nan("");
    const Eigen::VectorXd theirs = accelerations(system, treatment, state.q, state.v);
    worst = std::max(worst, (theirs - ours->acceleration).norm() / (1 + ours->acceleration.norm()));
  }
  return worst;
}

/// ms of the fastest trusted run of a treatment (by one method, or any) with that error at most.
std::string time_for(const WorkPrecision& chart, const std::string& treatment, const std::string& method,
                     double error, double setup) {
  double best = std::numeric_limits<double>::infinity();
  for (const WorkPrecisionPoint& p : chart.points) {
    const Variant& v = chart.variants[p.variant];
    if (treatment_of(v) == treatment && (method.empty() || method_of(v) == method) && p.finished &&
        p.trusted && std::max(p.errors.position, p.errors.orientation) <= error)
      best = std::min(best, p.seconds);
  }
  return std::isfinite(best) ? fmt::format("{:.3g}", 1e3 * (setup + best)) : "-";
}

/// us, the median over runs.
double evaluation_time(const WorkPrecision& chart, const std::string& treatment) {
  std::vector<double> all;
  for (const WorkPrecisionPoint& p : chart.points)
    if (treatment_of(chart.variants[p.variant]) == treatment && p.finished && p.evaluations > 200)
      all.push_back(1e6 * p.seconds / double(p.evaluations));
  if (all.empty()) return std::nan("");
  std::nth_element(all.begin(), all.begin() + long(all.size() / 2), all.end());
  return all[all.size() / 2];
}

std::string treatments_table(const WorkPrecision& chart, const std::map<std::string, double>& setup) {
  std::string out =
      "| treatment | set-up (ms) | per evaluation (us) | 1e-2 | 1e-4 | 1e-6 | 1e-8 | 1e-8 with set-up |\n"
      "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n";
  for (const std::string& t : treatments) {
    if (!setup.contains(t)) continue;
    out += fmt::format("| {} | {:.3g} | {:.2f} |", t, 1e3 * setup.at(t), evaluation_time(chart, t));
    for (const double error : decades) out += ' ' + time_for(chart, t, "", error, 0) + " |";
    out += ' ' + time_for(chart, t, "", 1e-8, setup.at(t)) + " |\n";
  }
  return out;
}

std::string methods_table(const WorkPrecision& chart) {
  std::string out =
      "| equations | method | 1e-2 | 1e-4 | 1e-6 | 1e-8 |\n| --- | --- | ---: | ---: | ---: | ---: |\n";
  for (const char* t : {"lagrange", "recursive"})
    for (const std::string& method : methods) {
      out += fmt::format("| {} | {} |", t, method);
      for (const double error : decades) out += ' ' + time_for(chart, t, method, error, 0) + " |";
      out += '\n';
    }
  return out;
}

Result<std::string> chart_of(const std::string& file, const Options& o) {
  auto model = read_model(file, {});
  if (!model) return tl::unexpected(model.error());
  if (o.end > 0) model->scene.simulation.end_time = o.end;
  const auto system = compile(model->scene);
  if (!system) return tl::unexpected(system.error());
  const std::string name = std::filesystem::path(file).stem();
  std::string out = fmt::format("## {}\n\n", system->scene);
  std::vector<OtherMethod> others;
  std::map<std::string, double> setup{{"recursive", own_setup(file)}};
  setup["lagrange"] = setup["recursive"];
  const auto add = [&](const std::string& treatment, std::function<std::unique_ptr<Treatment>()> make,
                       double seconds, double allowed) -> Result<void> {
    const double off = disagreement(*system, *make());
    out += fmt::format("{}: accelerations at 20 states agree with ours to {:.1g}. ", treatment, off);
    if (!(off <= allowed)) return failure(treatment, fmt::format("differs from our equations by {}", off));
    setup[treatment] = seconds;
    for (const std::string& method : methods)
      others.push_back(treated_method(*system, treatment, method, make));
    return {};
  };
  if (auto direct = direct_treatment(*system); !direct)
    return tl::unexpected(direct.error());
  else if (auto done = add(
               "direct", [&] { return direct_treatment(*system).value(); }, setup["recursive"], 1e-6);
           !done)
    return tl::unexpected(done.error());
  for (const Derived& one : derived)
    if (one.scene == name) {
      const auto seconds = symbolic_setup(name);
      if (!seconds) return tl::unexpected(seconds.error());
      if (auto done = add(
              "symbolic", [&] { return symbolic_treatment(one.terms); }, seconds->first + seconds->second,
              1e-11);
          !done)
        return tl::unexpected(done.error());
      out += fmt::format("Its derivation took {:.2f} s, its compilation {:.2f} s.", seconds->first,
                         seconds->second);
    }
  auto chart = work_precision(model->scene, o.settings, {}, others);
  if (!chart) return tl::unexpected(chart.error());
  const std::filesystem::path folder = std::filesystem::path(o.folder) / name;
  if (auto done = write_work_precision(*chart, folder / "ready"); !done) return tl::unexpected(done.error());
  out += "\n\n" + chart->reference.words + "\n\n" + treatments_table(*chart, setup) + '\n' +
         methods_table(*chart) + '\n';
  for (WorkPrecisionPoint& p : chart->points) p.seconds += setup.at(treatment_of(chart->variants[p.variant]));
  if (auto done = write_work_precision(*chart, folder / "with_setup"); !done)
    return tl::unexpected(done.error());
  out += fmt::format(
      "Charts: [from equations that are ready]({0}/ready/chart.html), [with the set-up]({0}/"
      "with_setup/chart.html)\n",
      name);
  return out;
}

Result<void> work(const Options& o) {
  std::string page =
      "# Treatments of Lagrange's equations\n\nms of processor time for an error of position (over the "
      "scene's length) and orientation (rad) of at most so much, by the fastest of rk4, rk4_adaptive, dopri5 "
      "and dop853, or by the method named.\n\n";
  for (const std::string& scene : o.scenes) {
    const auto part = chart_of(scene, o);
    if (!part) return tl::unexpected(part.error());
    fmt::print("{}\n", *part);
    page += *part + '\n';
  }
  return write_whole(std::filesystem::path(o.folder) / "README.md", page);
}

}  // namespace
}  // namespace borelli

int main(int argc, char** argv) {
  using namespace borelli;
  Options o;
  o.settings.methods = methods;
  o.settings.constraints = {ConstraintTreatment::projection};
  CLI::App program("Direct and symbolic treatment beside ours");
  program.add_option("scenes", o.scenes, "Scenes: TOML")->required();
  program.add_option("-o,--out", o.folder, "Folder for charts and page")->capture_default_str();
  program.add_option("--end", o.end, "End time, s");
  program.add_option("--repeats", o.settings.repeats, "Runs that a time is the median of")
      ->capture_default_str();
  program.add_option("--budget", o.settings.budget, "Processor time of a run, s")->capture_default_str();
  CLI11_PARSE(program, argc, argv);
  const auto done = work(o);
  if (done) return 0;
  fmt::print(stderr, "paper: {}\n", done.error().message());
  return done.error().kind == Error::Kind::use ? 2 : 1;
}
