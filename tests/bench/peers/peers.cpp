// Compares other programs with ours on the same scenes in one process: charts of error against cost, and per
// scene a table of the best runs of both. See README.md.
#include <dlfcn.h>
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>

#include "dynamics/formats/model_file.hpp"
#include "dynamics/run/simulate.hpp"
#include "peer.hpp"
#include "pipeline/charts/work_precision_page.hpp"
#include "pipeline/files/whole_file.hpp"

namespace borelli::peers {
namespace {

#ifdef BORELLI_SIMBODY
Result<std::unique_ptr<Peer>> load_simbody(const Tree& tree) {
  static void* const module = dlopen(BORELLI_SIMBODY, RTLD_NOW | RTLD_LOCAL | RTLD_DEEPBIND);
  if (!module) return failure("Simbody", dlerror());
  Result<std::unique_ptr<Peer>> out;
  reinterpret_cast<decltype(&make_simbody)>(dlsym(module, "make_simbody"))(tree, out);
  return out;
}
#endif

using Maker = Result<std::unique_ptr<Peer>> (*)(const Tree&);
const std::vector<std::pair<std::string, Maker>> programs = {
#ifdef BORELLI_MUJOCO
    {"MuJoCo", make_mujoco},
#endif
#ifdef BORELLI_SIMBODY
    {"Simbody", load_simbody},
#endif
#ifdef BORELLI_DART
    {"DART", make_dart},
#endif
#ifdef BORELLI_BULLET
    {"Bullet", make_bullet},
#endif
};

// Largest allowed difference of accelerations, relative to the largest one; beyond it the equations differ.
// It is wider for held points, since MuJoCo's are soft, and DART and Bullet iterate.
constexpr double same_equation = 1e-3, same_held = 2e-2;

/// The relative difference of a program's first change of velocity from ours; the larger one of linear and
/// angular velocities.
Result<double> disagreement(const Tree& tree, Peer& peer, double short_time) {
  const auto run = peer.run(0, short_time, 1e-8, {short_time}, [] { return true; });
  if (!run) return tl::unexpected(run.error());
  const Start start = start_of(tree);
  double linear = 0, linear_size = tree.gravity.norm(), angular = 0, angular_size = 1e-12;
  for (std::size_t i = 0; i < tree.links.size(); ++i) {
    const Moving &now = run->links[i], &then = start.links[i];
    linear = std::max(linear, ((now.centre - then.centre) / short_time - start.acceleration[i]).norm());
    angular = std::max(angular, ((now.omega - then.omega) / short_time - start.alpha[i]).norm());
    linear_size = std::max(linear_size, start.acceleration[i].norm());
    angular_size = std::max({angular_size, start.alpha[i].norm(), then.omega.squaredNorm()});
  }
  return std::max(linear_size > 0 ? linear / linear_size : linear, angular / angular_size);
}

// m/s: speed of a resting body that is noise of an iterative contact solver.
constexpr double tremor = 1e-4;

/// Times when balls hit the ground, s: the middle of the step in which a falling ball starts to rise.
std::vector<double> impacts(const Tree& tree, Peer& peer, std::size_t method, double end, double step) {
  std::vector<double> out, times;
  const long steps = steps_in(end, step);
  for (long i = 1; i <= steps; ++i) times.push_back(end * double(i) / double(steps));
  const auto run = peer.run(method, step, 0, times, [] { return true; });
  if (!run) return out;
  const Start start = start_of(tree);
  for (const Ground& g : tree.grounds) {
    if (!(g.radius > 0) || g.centre.point != tree.links[g.centre.link].centre) continue;
    double before = g.normal.dot(start.links[g.centre.link].centre);
    for (long i = 0; i < steps; ++i) {
      const double now = g.normal.dot(run->links[i * tree.links.size() + g.centre.link].centre);
      if (before < -tremor && now > 0) out.push_back(end * (double(i) + 0.5) / double(steps));
      before = now;
    }
  }
  std::sort(out.begin(), out.end());
  return out;
}

/// Energies of a fine run of ours, the reference for the others.
struct Energies {
  double interval = 0, turnover = 0;  ///< s between values; J
  std::vector<double> since_start;    ///< energy gained since the start, J
};

/// A program's method for the chart; `fixed` forces steps of one length.
OtherMethod other_method(const Tree& tree, const std::shared_ptr<Peer>& peer, std::size_t number, bool fixed,
                         const Energies& ours) {
  const Method method = peer->methods()[number];
  const bool adaptive = method.adaptive && !fixed;
  const auto run = [=](double setting, const std::vector<double>& times,
                       const std::function<bool()>& go_on) -> Result<OtherRun> {
    const double start = processor_time();
    const auto made = peer->run(number, adaptive ? 0 : setting, setting, times, go_on);
    if (!made) return tl::unexpected(made.error());
    OtherRun out;
    out.seconds = processor_time() - start;
    out.evaluations = made->evaluations;
    const std::size_t links = tree.links.size();
    const Start begin = start_of(tree);
    const double first = energy(tree, begin.links.data());
    for (std::size_t row = 0; row < times.size(); ++row) {
      const Moving* moving = made->links.data() + row * links;
      const auto at = static_cast<std::size_t>(std::lround(times[row] / ours.interval));
      if (at < ours.since_start.size())
        out.energy = std::max(out.energy,
                              std::abs(energy(tree, moving) - first - ours.since_start[at]) / ours.turnover);
      out.momenta.push_back(momentum(tree, moving));
      out.constraint = std::max({out.constraint, residual(tree, moving), penetration(tree, moving)});
      for (const Tree::Seat& seat : tree.seats) {
        const Pose own{seat.R, seat.p};
        out.poses.push_back(seat.link < 0 ? own : Pose{moving[seat.link].R, moving[seat.link].p} * own);
      }
    }
    if (!adaptive && !tree.grounds.empty()) out.impacts = impacts(tree, *peer, number, times.back(), setting);
    if (!std::isfinite(first) || !(ours.turnover > 0)) out.energy = std::nan("");
    for (const Pose& X : out.poses)
      if (!X.p.allFinite() || !X.R.allFinite()) return failure("", "numbers that are not finite");
    return out;
  };
  return {method.name, adaptive, run};
}

struct Entered {
  std::vector<OtherMethod> methods;
  std::vector<std::string> words;  ///< per program: its version, or why it is not on the chart
};

/// The scene without its ground. A contact at the start would make the first accelerations depend on the
/// contact law.
Result<Tree> without_ground(Scene scene) {
  std::erase_if(scene.constraints, [](const Constraint& c) {
    return std::holds_alternative<SphereOverPlane>(c.kind) || std::holds_alternative<BoxOverPlane>(c.kind);
  });
  const auto system = compile(scene);
  if (!system) return tl::unexpected(system.error());
  return tree_of(scene, *system);
}

Entered enter(const Scene& scene, const System& system, bool fixed, int outputs) {
  Entered out;
  const auto tree = tree_of(scene, system), free = without_ground(scene);
  if (!tree || !free) {
    out.words.push_back("No other program: " + (tree ? free : tree).error().message() + ".");
    return out;
  }
  SimulationSettings how = scene.simulation;
  how.accuracy = 0, how.method = "dop853", how.tolerance = 1e-12;
  how.output_interval = (how.end_time - system.initial.t) / outputs;
  Energies energies{.interval = how.output_interval};
  if (const auto ours = simulate(system, system.initial, how)) {
    energies.turnover = ours->certificate.energy_turnover;
    for (std::size_t i = 0; i < ours->times.size(); ++i)
      energies.since_start.push_back(ours->kinetic[i] + ours->potential[i] - ours->kinetic[0] -
                                     ours->potential[0]);
  }
  for (const auto& [name, make] : programs) {
    auto made = make(*tree), made_free = make(*free);
    if (!made || !made_free) {
      out.words.push_back(
          fmt::format("{} is not on the chart: {}.", name, (made ? made_free : made).error().what));
      continue;
    }
    const std::shared_ptr<Peer> peer = std::move(*made);
    const auto off = disagreement(*free, **made_free, 1e-8 * (how.end_time - system.initial.t));
    if (!off || !(*off < (tree->held.empty() && tree->in_planes.empty() ? same_equation : same_held))) {
      out.words.push_back(fmt::format(
          "{} is not on the chart: {}.", peer->version(),
          off ? fmt::format("its first accelerations differ by {:.1g}", *off) : off.error().message()));
      continue;
    }
    out.words.push_back(
        fmt::format("{}: first accelerations agree to {:.1g} of the largest.", peer->version(), *off));
    for (std::size_t i = 0; i < peer->methods().size(); ++i)
      out.methods.push_back(other_method(*tree, peer, i, fixed, energies));
  }
  return out;
}

struct Options {
  std::vector<std::string> scenes, equations = {"recursive", "lagrange"};
  std::string folder = "peers";
  double end = 0;
  bool orders = false;
  WorkPrecisionSettings settings;
};

/// The order of the orientation's error in the step, from a method's two finest runs above rounding.
std::string orders_table(const WorkPrecision& chart) {
  std::string out =
      "| method | order of orientation | from steps of (s) | error (rad) |\n| --- | ---: | --- | --- |\n";
  const double floor = std::max(1e-11, 30 * chart.reference.orientation);
  for (std::size_t v = 0; v < chart.variants.size(); ++v) {
    const WorkPrecisionPoint *coarse = nullptr, *fine = nullptr;
    for (const WorkPrecisionPoint& p : chart.points) {
      if (p.variant != v || !p.finished || !(p.errors.orientation > floor) || p.errors.orientation > 0.3)
        continue;
      coarse = fine, fine = &p;
    }
    if (!coarse || chart.variants[v].adaptive) continue;
    out += fmt::format("| {} | {:.2f} | {:.3g}, {:.3g} | {:.1e}, {:.1e} |\n", name_of(chart.variants[v]),
                       std::log(coarse->errors.orientation / fine->errors.orientation) /
                           std::log(coarse->setting / fine->setting),
                       coarse->setting, fine->setting, coarse->errors.orientation, fine->errors.orientation);
  }
  return out;
}

/// Per method the trusted run with the least judged error.
std::string contacts_table(const WorkPrecision& chart) {
  std::string out =
      "| method | ms | position | times of impacts (s) | sinks in by (m) | energy | momentum |\n"
      "| --- | ---: | --- | --- | --- | --- | --- |\n";
  const auto number = [](double x) { return std::isfinite(x) ? fmt::format("{:.1e}", x) : std::string("-"); };
  for (std::size_t v = 0; v < chart.variants.size(); ++v) {
    const WorkPrecisionPoint* best = nullptr;
    for (const WorkPrecisionPoint& p : chart.points)
      if (p.variant == v && p.finished && p.trusted &&
          (!best || judged_error(chart, p) < judged_error(chart, *best)))
        best = &p;
    if (best)
      out += fmt::format("| {} | {:.3g} | {} | {} | {} | {} | {} |\n", name_of(chart.variants[v]),
                         1e3 * best->seconds, number(best->errors.position), number(best->errors.impacts),
                         number(best->errors.constraint), number(best->errors.energy),
                         number(best->errors.momentum));
  }
  return out;
}

/// Time of the others' fastest run over ours, for errors of 10^-1 to 10^-10.
std::string summary_row(const WorkPrecision& chart) {
  std::string out = fmt::format("| {} |", chart.scene);
  for (const FrontRow& row : front_against_front(chart)) {
    const double ratio = row.ours && row.other ? row.other->seconds / row.ours->seconds : 0;
    const int places = ratio < 2 ? 2 : ratio < 10 ? 1 : 0;
    out += ratio > 0   ? fmt::format(" {0}{1:.{2}f}{0} |", ratio < 1 ? "**" : "", ratio, places)
           : row.ours  ? " alone |"
           : row.other ? " **never** |"
                       : " - |";
  }
  return out + '\n';
}

/// The parts of the page.
struct Page {
  std::string head, summary, scenes;
};

Result<void> add_scene(const std::string& file, const Options& o, Page& page) {
  auto model = read_model(file, {});
  if (!model) return tl::unexpected(model.error());
  Scene& scene = model->scene;
  if (o.end > 0) scene.simulation.end_time = o.end;
  const auto system = compile(scene);
  if (!system) return tl::unexpected(system.error());
  const Entered others = enter(scene, *system, o.orders, o.settings.outputs);
  WorkPrecisionObserver observer;
  observer.progress = [](const std::string& what, double share) {
    fmt::print(stderr, "\r{:3.0f} %  {:60}", 100 * share, what);
  };
  const auto chart = work_precision(scene, o.settings, observer, others.methods);
  fmt::print(stderr, "\n");
  if (!chart) return tl::unexpected(chart.error());
  const std::string name = std::filesystem::path(file).stem();
  const std::filesystem::path folder = o.folder;
  if (auto done = write_work_precision(*chart, folder / name); !done) return tl::unexpected(done.error());
  std::string out = fmt::format("## {}\n\n{}\n", scene.name, chart->reference.words);
  for (const std::string& words : others.words) out += words + '\n';
  out += '\n' + (o.orders ? orders_table(*chart) : front_table(*chart)) + '\n';
  if (chart->has_impacts) out += contacts_table(*chart) + '\n';
  for (const auto& [drawing, plot] : work_precision_plots(*chart))
    if (drawing.ends_with("_time")) out += fmt::format("![{}]({}/{}.svg)\n", plot.title, name, drawing);
  fmt::print("{}\n", out);
  page.summary += summary_row(*chart);
  page.scenes += out + '\n';
  return {};
}

Result<void> work(const Options& o) {
  Page page;
  page.head = fmt::format(
      "# What accuracy costs, here and in other programs\n\n"
      "Compiled by g++ {}. Times are processor time, medians of {} runs; a ladder ends with the first run "
      "above "
      "{:g} s.\n\n"
      "What the fastest run of the others takes over our fastest trusted one, for errors of position (over "
      "the "
      "scene's length) and orientation (rad) of at most so much. Bold: ours loses. Alone: no run of theirs "
      "comes to "
      "it in the time allowed. -: less than ten times the reference's own error.\n\n"
      "| scene | 1e-1 | 1e-2 | 1e-3 | 1e-4 | 1e-5 | 1e-6 | 1e-7 | 1e-8 | 1e-9 | 1e-10 |\n"
      "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
      __VERSION__, o.settings.repeats, o.settings.budget);
  for (const std::string& scene : o.scenes) {
    if (auto done = add_scene(scene, o, page); !done) return done;
    const std::string text = page.head + page.summary + '\n' + page.scenes;
    if (auto done = write_whole(std::filesystem::path(o.folder) / "README.md", text); !done) return done;
  }
  return {};
}

}  // namespace
}  // namespace borelli::peers

int main(int argc, char** argv) {
  using namespace borelli;
  peers::Options o;
  CLI::App program("Other programs beside ours on the same scenes");
  program.add_option("scenes", o.scenes, "Scenes: TOML, MJCF or URDF")->required();
  program.add_option("-o,--out", o.folder, "Folder for charts and page")->capture_default_str();
  program
      .add_option("--methods", o.settings.methods,
                  "Our integrators, with commas between; all, where not given")
      ->delimiter(',');
  program.add_option("--equations", o.equations, "Our equations of motion")
      ->delimiter(',')
      ->check(CLI::IsMember({"recursive", "lagrange"}))
      ->capture_default_str();
  program.add_option("--end", o.end, "End time, s");
  program.add_option("--outputs", o.settings.outputs, "Times at which runs are compared")
      ->capture_default_str();
  program.add_option("--repeats", o.settings.repeats, "Runs that a time is the median of")
      ->capture_default_str();
  program.add_option("--budget", o.settings.budget, "Processor time of a run, s")->capture_default_str();
  program.add_flag("--orders", o.orders,
                   "All by steps of one length: the order of orientation instead of the fronts");
  CLI11_PARSE(program, argc, argv);
  o.settings.equations.clear();
  for (const std::string& name : o.equations)
    o.settings.equations.push_back(name == "lagrange" ? Equations::lagrange : Equations::recursive);
  const auto done = peers::work(o);
  if (done) return 0;
  fmt::print(stderr, "peers: {}\n", done.error().message());
  return done.error().kind == Error::Kind::use ? 2 : 1;
}
