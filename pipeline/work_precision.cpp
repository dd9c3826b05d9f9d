#include "pipeline/work_precision.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>
#include <optional>

#include "dynamics/integrator.hpp"
#include "dynamics/simulate.hpp"
#include "pipeline/motion_difference.hpp"

namespace borelli {
namespace {

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

// two references that differ by more are none: beyond that time the motion is rounding's
constexpr double reference_limit = 1e-8;

// a reference may take so many times the budget of a run
constexpr double reference_patience = 40;

// a run that is so near to the reference's own error tells nothing of its own
constexpr double reference_margin = 10;

double processor_time() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

class Chart {
 public:
  Chart(const Scene& scene, const System& system, const WorkPrecisionSettings& settings,
        const WorkPrecisionObserver& observer)
      : system_(system),
        settings_(settings),
        observer_(observer),
        how_(scene.simulation),
        centres_(gravity_centres(scene)) {
    how_.accuracy = 0;
    how_.output_interval = (how_.end_time - system.initial.t) / settings.outputs;
  }

  WorkPrecision run() {
    chart_.scene = system_.scene;
    chart_.has_constraints = system_.rows > 0;
    chart_.has_impacts = !system_.contacts.empty();
    find_reference();
    std::vector<std::string> methods = settings_.methods.empty() ? integrator_names() : settings_.methods;
    for (const std::string& method : methods)
      for (const Equations equations : settings_.equations)
        for (const ConstraintTreatment constraints : settings_.constraints)
          if (system_.rows > 0 || constraints == settings_.constraints.front())
            chart_.variants.push_back({method, equations, constraints});
    for (std::size_t i = 0; i < chart_.variants.size(); ++i) {
      observer_.progress(name_of(chart_.variants[i]), double(i) / double(chart_.variants.size()));
      climb(i);
      observer_.ladder_ends(chart_.points);
    }
    return std::move(chart_);
  }

 private:
  /// Of two trajectories at a row: over the scene's length, and rad.
  MotionDifference difference_at(const Trajectory& a, const Trajectory& b, std::size_t row) const {
    MotionDifference worst = motion_difference(a, b, row, centres_);
    worst.position /= system_.length;
    return worst;
  }

  Result<Trajectory> simulate_for(const SimulationSettings& how, double most_seconds) {
    const double start = processor_time();
    Observer observer;
    observer.progress = [&](double) { return processor_time() - start < most_seconds; };
    auto t = simulate(system_, system_.initial, how, observer);
    if (t && t->times.back() < how.end_time * (1 - 1e-12))
      return failure("", fmt::format("took more than {:.3g} s", most_seconds));
    return t;
  }

  std::optional<Trajectory> reference_run(const std::string& method, double tolerance) {
    SimulationSettings how = how_;
    how.method = method;
    how.tolerance = tolerance;
    auto t = simulate_for(how, reference_patience * settings_.budget);
    // (a verdict may ask for more than a reference can give: what two unlike methods agree on is its proof)
    if (!t) return std::nullopt;
    return std::move(*t);
  }

  /// Up to which row two runs agree, and by how much they differ up to there.
  std::pair<std::size_t, MotionDifference> agreement(const Trajectory& a, const Trajectory& b) const {
    MotionDifference worst;
    std::size_t row = 1;
    for (; row < std::min(a.times.size(), b.times.size()); ++row) {
      const MotionDifference here = difference_at(a, b, row);
      if (!(std::max(here.position, here.orientation) < reference_limit)) break;
      worst.widen(here);
    }
    return {row - 1, worst};
  }

  void find_reference() {
    // one step methods of high order of unlike making; implicit ones where these cannot get through
    const char* stiff = system_.rows > 0 ? "arkode" : "cvode";
    const std::pair<const char*, const char*> pairs[] = {
        {"dop853", "gbs"}, {"dop853", stiff}, {"gbs", stiff}, {"dopri5", "rk4_adaptive"}};
    Reference& best = chart_.reference;
    std::size_t best_row = 0;
    for (const auto& [first, second] : pairs) {
      for (const double tolerance : {1e-11, 1e-12, 1e-13, 1e-14}) {
        observer_.progress(fmt::format("reference: {}, {} at {:g}", first, second, tolerance), 0);
        auto a = reference_run(first, tolerance);
        auto b = a ? reference_run(second, tolerance) : std::nullopt;
        if (!b) break;
        const auto [row, worst] = agreement(*a, *b);
        const double size = std::max(worst.position, worst.orientation);
        if (row == 0 || row < best_row ||
            (row == best_row && best.found && size >= std::max(best.position, best.orientation)))
          continue;
        best_row = row;
        best = {.found = true,
                .runs = {fmt::format("{} at tolerance {:g}", first, tolerance),
                         fmt::format("{} at tolerance {:g}", second, tolerance)},
                .position = worst.position,
                .orientation = worst.orientation,
                .horizon = a->times[row],
                .words = {}};
        trajectory_ = std::move(*a);
      }
      if (best.found) break;
    }
    last_row_ = best_row;
    const double end = how_.end_time;
    if (!best.found)
      best.words = "No reference: no two unlike methods agree; energy and constraints alone are judged.";
    else
      best.words =
          fmt::format("Reference: {}, which {} differs from by {:.1g} of the scene's length and {:.1g} rad.",
                      best.runs[0], best.runs[1], best.position, best.orientation);
    if (best.found && best.horizon < end * (1 - 1e-9))
      best.words += fmt::format(
          " Beyond t = {:.4g} s (of {:.4g} s) they part by more than {:g}: the motion is chaotic, and errors "
          "are "
          "taken up to there.",
          best.horizon, end, reference_limit);
  }

  RunErrors errors_of(const Trajectory& t) const {
    RunErrors e{nothing, nothing, nothing, nothing, nothing};
    const Certificate& c = t.certificate;
    if (c.energy_turnover > 0) e.energy = c.energy_drift / c.energy_turnover;
    if (!c.residuals.empty()) {
      e.constraint = 0;
      for (const ConstraintResidual& r : c.residuals) e.constraint = std::max(e.constraint, r.position);
    }
    if (!chart_.reference.found || t.times.size() <= last_row_) return e;
    e.position = e.orientation = 0;
    for (std::size_t row = 1; row <= last_row_; ++row) {
      const MotionDifference here = difference_at(t, *trajectory_, row);
      e.position = std::max(e.position, here.position);
      e.orientation = std::max(e.orientation, here.orientation);
    }
    if (chart_.has_impacts) e.impacts = impact_times(c, trajectory_->certificate);
    return e;
  }

  double impact_times(const Certificate& a, const Certificate& b) const {
    const auto times = [&](const Certificate& c) {
      std::vector<double> out;
      for (const LoggedEvent& e : c.events)
        if (e.kind == "impact" && e.time <= chart_.reference.horizon) out.push_back(e.time);
      return out;
    };
    const std::vector<double> x = times(a), y = times(b);
    if (x.empty() || y.empty()) return nothing;
    double worst = 0;
    for (std::size_t i = 0; i < std::min(x.size(), y.size()); ++i)
      worst = std::max(worst, std::abs(x[i] - y[i]));
    return worst;
  }

  WorkPrecisionPoint measure(std::size_t variant, double setting) {
    const Variant& v = chart_.variants[variant];
    SimulationSettings how = how_;
    how.method = v.method;
    how.equations = v.equations;
    how.constraints = v.constraints;
    (method_is_adaptive(v.method) ? how.tolerance : how.step) = setting;
    WorkPrecisionPoint point{.variant = variant, .setting = setting};
    std::vector<double> seconds;
    for (int repeat = 0; repeat < settings_.repeats; ++repeat) {
      const double start = processor_time();
      const auto t = simulate_for(how, 4 * settings_.budget);
      seconds.push_back(processor_time() - start);
      if (!t) {
        point.reason = t.error().message();
        break;
      }
      if (repeat > 0) continue;
      point.finished = true;
      point.trusted = t->certificate.trusted;
      point.reason = t->certificate.reason;
      point.evaluations = t->certificate.evaluations;
      point.errors = errors_of(*t);
    }
    std::nth_element(seconds.begin(), seconds.begin() + seconds.size() / 2, seconds.end());
    point.seconds = seconds[seconds.size() / 2];
    return point;
  }

  /// From the coarsest rung to where a run takes longer than it may, or finer ones gain nothing any more.
  void climb(std::size_t variant) {
    const auto known = [&](const WorkPrecisionPoint& p) { return p.variant == variant; };
    if (std::any_of(observer_.known.begin(), observer_.known.end(), known)) {
      std::copy_if(observer_.known.begin(), observer_.known.end(), std::back_inserter(chart_.points), known);
      return;
    }
    const bool adaptive = method_is_adaptive(chart_.variants[variant].method);
    const double factor = adaptive ? 0.1 : 0.5;
    double setting = adaptive ? 1e-2 : how_.output_interval, best = std::numeric_limits<double>::infinity();
    for (int rung = 0, without_gain = 0; rung < (adaptive ? 13 : 24) && without_gain < 2;
         ++rung, setting *= factor) {
      const WorkPrecisionPoint point = measure(variant, setting);
      chart_.points.push_back(point);
      // what the method refuses it refuses at every step
      if (!point.finished && point.seconds < 1e-4 && rung == 0 && point.reason.starts_with("method '"))
        return;
      if (point.seconds > settings_.budget) return;
      if (!point.finished) continue;
      const double error = std::isfinite(point.errors.position)
                               ? std::max(point.errors.position, point.errors.orientation)
                               : point.errors.energy;
      without_gain = error < 0.9 * best || rung < 3 ? 0 : without_gain + 1;
      best = std::min(best, error);
    }
  }

  const System& system_;
  const WorkPrecisionSettings& settings_;
  const WorkPrecisionObserver& observer_;
  SimulationSettings how_;
  std::vector<Eigen::Vector3d> centres_;  ///< of gravity, in each solid's frame
  std::optional<Trajectory> trajectory_;  ///< the reference
  std::size_t last_row_ = 0;              ///< of it, that counts
  WorkPrecision chart_;
};

}  // namespace

std::string name_of(const Variant& variant) {
  std::string out = variant.method;
  if (variant.equations == Equations::lagrange) out += ", lagrange";
  if (variant.constraints == ConstraintTreatment::baumgarte) out += ", baumgarte";
  return out;
}

Result<WorkPrecision> work_precision(const Scene& scene, const WorkPrecisionSettings& settings,
                                     const WorkPrecisionObserver& observer) {
  const auto system = compile(scene);
  if (!system) return tl::unexpected(system.error());
  if (!(scene.simulation.end_time > system->initial.t))
    return bad_use(scene.name, "ends when it begins: there is no motion to chart");
  if (settings.outputs < 1 || settings.repeats < 1 || !(settings.budget > 0) || settings.equations.empty() ||
      settings.constraints.empty())
    return bad_use("work-precision", "needs at least one output time, one repeat, and time for a run");
  return Chart(scene, *system, settings, observer).run();
}

std::vector<const WorkPrecisionPoint*> pareto_front(
    const WorkPrecision& chart, const std::function<double(const WorkPrecisionPoint&)>& cost,
    const std::function<double(const WorkPrecisionPoint&)>& error) {
  std::vector<const WorkPrecisionPoint*> out;
  for (const WorkPrecisionPoint& p : chart.points) {
    const bool above_reference =
        !chart.reference.found ||
        std::max(p.errors.position, p.errors.orientation) >=
            reference_margin * std::max(chart.reference.position, chart.reference.orientation);
    if (p.finished && p.trusted && above_reference && std::isfinite(error(p))) out.push_back(&p);
  }
  std::sort(out.begin(), out.end(), [&](const auto* a, const auto* b) {
    return std::pair(cost(*a), error(*a)) < std::pair(cost(*b), error(*b));
  });
  double best = std::numeric_limits<double>::infinity();
  std::erase_if(out, [&](const WorkPrecisionPoint* p) {
    if (!(error(*p) < best)) return true;
    best = error(*p);
    return false;
  });
  return out;
}

}  // namespace borelli
