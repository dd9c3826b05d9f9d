#include "pipeline/charts/work_precision.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <limits>
#include <optional>
#include <tuple>

#include "dynamics/methods/integrator.hpp"
#include "dynamics/run/simulate.hpp"
#include "pipeline/charts/motion_difference.hpp"

namespace borelli {
namespace {

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

// a run this close to the reference's own error cannot be judged
constexpr double reference_margin = 10;

/// Limits a run's processor time; checked at each step. Reads the wall clock first, which a thread's time
/// cannot exceed and which costs a hundredth as much to read.
class TimeLimit {
 public:
  explicit TimeLimit(double seconds) : most_(seconds) {}
  bool holds() const {
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - begun_;
    return passed.count() < most_ || processor_time() - start_ < most_;
  }

 private:
  double most_, start_ = processor_time();
  std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
};

/// The row of a given reference at a time; the number of rows if there is none. `length`: of the run, s.
std::size_t row_at(const GivenReference& given, double time, double length) {
  const double near = 1e-9 * length;
  const auto found = std::lower_bound(given.times.begin(), given.times.end(), time - near);
  return found == given.times.end() || *found > time + near ? given.times.size()
                                                            : std::size_t(found - given.times.begin());
}

class Chart {
 public:
  Chart(const Scene& scene, const System& system, const WorkPrecisionSettings& settings,
        const WorkPrecisionObserver& observer, const std::vector<OtherMethod>& others)
      : system_(system),
        settings_(settings),
        observer_(observer),
        others_(others),
        how_(scene.simulation),
        centres_(gravity_centres(scene)) {
    how_.accuracy = 0;
    how_.verify = false;
  }

  Result<WorkPrecision> run() {
    chart_.scene = system_.scene;
    chart_.has_constraints = system_.rows > 0;
    chart_.has_impacts = !system_.contacts.empty();
    chart_.length = system_.length;
    const bool given = settings_.reference.has_value();
    FoundReference found =
        find_reference(system_, centres_, how_,
                       {.outputs = settings_.outputs,
                        .budget = settings_.budget,
                        .anew = !given,
                        .progress = [&](const std::string& what) { observer_.progress(what, 0); }});
    chart_.reference = found.reference;
    how_.end_time = found.end_time;
    how_.output_interval = found.output_interval;
    last_row_ = motion_row_ = found.last_row;
    trajectory_ = motion_ = std::move(found.motion);
    if (given) take_reference();
    how_.end_time = system_.initial.t + double(last_row_) * how_.output_interval;
    chart_.duration = how_.end_time - system_.initial.t;
    std::vector<std::string> methods = settings_.methods;
    if (methods.empty()) {
      methods = integrator_names();
      methods.emplace_back(automatic);
    }
    for (const std::string& method : methods)
      for (const Equations equations : settings_.equations) {
        if (method == automatic && equations != settings_.equations.front()) continue;
        for (const ConstraintTreatment constraints : settings_.constraints)
          if (constraints == settings_.constraints.front() || (system_.rows > 0 && method != automatic))
            chart_.variants.push_back(
                {method, equations, constraints, method == automatic || method_is_adaptive(method)});
      }
    first_other_ = chart_.variants.size();
    for (const OtherMethod& other : others_)
      chart_.variants.push_back({.method = other.name, .adaptive = other.adaptive, .other = true});
    if (auto done = climb_all(); !done) return tl::unexpected(done.error());
    return std::move(chart_);
  }

 private:
  /// Difference of two runs' poses at one time: over the scene's length, and rad.
  MotionDifference difference(const Pose* a, const Pose* b) const {
    MotionDifference worst = motion_difference(a, b, centres_);
    worst.position /= system_.length;
    return worst;
  }

  /// `evaluations`: until a run fails by itself; 0: it finished, or took too long.
  Result<Trajectory> simulate_for(const SimulationSettings& how, double most_seconds, long& evaluations) {
    const TimeLimit limit(most_seconds);
    Observer observer;
    observer.progress = [&](double) { return limit.holds(); };
    long made = 0;
    observer.ended = [&](long more) { made += more; };
    auto t = simulate(system_, system_.initial, how, observer);
    evaluations = t ? 0 : made;
    out_of_time_ = t && t->times.back() < how.end_time * (1 - 1e-12);
    if (out_of_time_) return failure("", fmt::format("took more than {:.3g} s", most_seconds));
    return t;
  }

  /// Takes the given reference's rows at the output times, which work_precision() has checked. Our own
  /// reference tells whether the given one is plausible, and supplies the impacts and momenta that poses
  /// lack.
  void take_reference() {
    const GivenReference& given = *settings_.reference;
    Trajectory t;
    t.solids = system_.solids;
    for (int i = 0; i <= settings_.outputs; ++i) {
      const double at = system_.initial.t + i * how_.output_interval;
      const std::size_t row = row_at(given, at, how_.end_time - system_.initial.t);
      t.times.push_back(at);
      const auto first = given.poses.begin() + long(row * system_.solids.size());
      t.poses.insert(t.poses.end(), first, first + long(system_.solids.size()));
    }
    std::string words = fmt::format(
        "Reference: {}, given by the user, assumed accurate to {:.1g} of the scene's length and {:.1g} rad.",
        given.name, given.error, given.error);
    if (motion_) {
      const Reference& own = chart_.reference;
      const double off = size_of(motion_differences(t, *motion_, centres_, system_.length)[motion_row_]),
                   known = given.error + std::max(own.position, own.orientation);
      const std::string who = fmt::format("{} and {}", own.runs[0], own.runs[1]);
      words += off > reference_margin * known
                   ? fmt::format(
                         " It is contradicted: {} agree to {:.1g}, up to t = {:.4g} s, and differ from it by "
                         "{:.2g}. Errors here are relative to the given reference.",
                         who, std::max(own.position, own.orientation), own.horizon, off)
                   : fmt::format(" {} agree with it to {:.1g}, up to t = {:.4g} s.", who, off, own.horizon);
      if (off > reference_margin * known) motion_.reset();
    }
    trajectory_ = std::move(t);
    last_row_ = std::size_t(settings_.outputs);
    chart_.reference = {.found = true,
                        .runs = {given.name},
                        .position = given.error,
                        .orientation = given.error,
                        .horizon = how_.end_time,
                        .words = words};
  }

  /// Error of the poses at every stride-th output, starting with the first.
  void compare(const Pose* poses, std::size_t rows, std::size_t stride, RunErrors& e) const {
    if (!chart_.reference.found || last_row_ < stride || (rows - 1) * stride < last_row_ / stride * stride)
      return;
    e.position = e.orientation = 0;
    for (std::size_t row = stride; row <= last_row_; row += stride) {
      const MotionDifference here =
          difference(poses + row / stride * centres_.size(), &trajectory_->pose(row, 0));
      e.position = std::max(e.position, here.position);
      e.orientation = std::max(e.orientation, here.orientation);
    }
  }

  RunErrors errors_of(const Trajectory& t, std::size_t stride) const {
    RunErrors e{nothing, nothing, nothing, nothing, nothing, nothing};
    const Certificate& c = t.certificate;
    if (c.energy_turnover > 0) e.energy = c.energy_drift / c.energy_turnover;
    if (!c.residuals.empty()) {
      e.constraint = 0;
      for (const ConstraintResidual& r : c.residuals) e.constraint = std::max(e.constraint, r.position);
    }
    compare(t.poses.data(), t.times.size(), stride, e);
    if (chart_.has_impacts && std::isfinite(e.position) && motion_) {
      if (tells_impacts(c.method))
        e.impacts = impact_time_error(impacts_of(c), impacts_of(motion_->certificate), system_.initial.t,
                                      motion_end());
      std::vector<Eigen::Vector3d> momenta;
      for (Eigen::Index row = 1; row < t.linear_momentum.rows(); ++row)
        momenta.push_back(t.linear_momentum.row(row).transpose());
      e.momentum = momentum_error(momenta, stride);
    }
    return e;
  }

  /// Error of the momenta at every stride-th output after the start.
  double momentum_error(const std::vector<Eigen::Vector3d>& momenta, std::size_t stride) const {
    const Rows& reference = motion_->linear_momentum;
    double worst = 0, largest = 0;
    for (std::size_t i = 0; i < momenta.size() && (i + 1) * stride <= motion_row_; ++i)
      worst =
          std::max(worst, (momenta[i] - reference.row(Eigen::Index((i + 1) * stride)).transpose()).norm());
    for (std::size_t row = 0; row <= motion_row_; ++row)
      largest = std::max(largest, reference.row(Eigen::Index(row)).norm());
    return largest > 0 && !momenta.empty() ? worst / largest : nothing;
  }

  /// s, up to which motion_ is valid.
  double motion_end() const { return system_.initial.t + double(motion_row_) * how_.output_interval; }

  /// Whether a method detects times of impacts; methods that treat contacts within a step do not.
  static bool tells_impacts(const std::string& method) {
    const auto integrator = make_integrator(method, 1e-6);
    return integrator && !(*integrator)->handles_contacts();
  }

  static std::vector<double> impacts_of(const Certificate& c) {
    std::vector<double> out;
    for (const LoggedEvent& e : c.events)
      if (e.kind == "impact") out.push_back(e.time);
    return out;
  }

  /// Number of outputs per step.
  std::size_t stride_of(std::size_t variant, double setting) const {
    if (chart_.variants[variant].adaptive) return 1;
    return std::max<long>(1, std::lround(setting / how_.output_interval));
  }

  /// One run of another program; answers its time, s.
  double run_other(const OtherMethod& other, WorkPrecisionPoint& point) {
    const std::size_t stride = stride_of(point.variant, point.setting);
    std::vector<double> times;
    for (std::size_t row = stride; row <= last_row_; row += stride)
      times.push_back(system_.initial.t + double(row) * how_.output_interval);
    const double start = processor_time();
    const TimeLimit limit(4 * budget_);
    auto run = other.run(point.setting, times, [&] { return limit.holds(); });
    const double seconds = run ? run->seconds : processor_time() - start;
    out_of_time_ = !run && !limit.holds();
    if (run && run->poses.size() != times.size() * centres_.size())
      run = failure(other.name, "did not reach its end");
    point.finished = point.trusted = run.has_value();
    point.reason = run ? "" : run.error().message();
    if (!run) return seconds;
    point.evaluations = run->evaluations;
    point.errors = {nothing, nothing, run->energy, run->constraint, nothing, nothing};
    std::vector<Pose> poses(centres_.size());  // of the start, which is not compared
    poses.insert(poses.end(), run->poses.begin(), run->poses.end());
    compare(poses.data(), times.size() + 1, stride, point.errors);
    if (!chart_.has_impacts || !motion_ || !std::isfinite(point.errors.position)) return seconds;
    point.errors.momentum = momentum_error(run->momenta, stride);
    if (!run->impacts.empty())
      point.errors.impacts =
          impact_time_error(run->impacts, impacts_of(motion_->certificate), system_.initial.t, motion_end());
    return seconds;
  }

  /// One run of ours; answers its time, s.
  double run_ours(const Variant& v, WorkPrecisionPoint& point) {
    SimulationSettings how = how_;
    if (v.method != automatic) how.method = v.method;
    how.equations = v.equations;
    how.constraints = v.constraints;
    const std::string_view what = setting_name(v);
    (what == "step" ? how.step : what == "tolerance" ? how.tolerance : how.accuracy) = point.setting;
    const std::size_t stride = stride_of(point.variant, point.setting);
    how.output_interval *= double(stride);
    const double start = processor_time();
    const auto t = simulate_for(how, 4 * budget_, point.evaluations);
    const double seconds = processor_time() - start;
    point.finished = t.has_value();
    if (!t) {
      point.reason = t.error().message();
      return seconds;
    }
    point.trusted = t->certificate.trusted;
    point.reason = t->certificate.reason;
    point.evaluations = t->certificate.evaluations;
    point.errors = errors_of(*t, stride);
    return seconds;
  }

  WorkPrecisionPoint measure(std::size_t variant, double setting) {
    WorkPrecisionPoint point{.variant = variant, .setting = setting};
    std::vector<double> seconds;
    const Variant& v = chart_.variants[variant];
    for (int repeat = 0; repeat < settings_.repeats && (repeat == 0 || point.finished); ++repeat)
      seconds.push_back(v.other ? run_other(others_[variant - first_other_], point) : run_ours(v, point));
    std::nth_element(seconds.begin(), seconds.begin() + seconds.size() / 2, seconds.end());
    point.seconds = seconds[seconds.size() / 2];
    return point;
  }

  /// The runs of a variant, from the coarsest on.
  struct Ladder {
    std::vector<WorkPrecisionPoint> points;
    int rung = 0, without_gain = 0;  ///< the next rung; how many of the last ones gained nothing
    double best = std::numeric_limits<double>::infinity();  ///< least error
    long evaluations = 0;
    bool ended = false;
  };

  Result<void> climb_all() {
    ladders_.resize(chart_.variants.size());
    constexpr double shares[] = {0.04, 0.2, 1};
    const std::size_t n = ladders_.size();
    for (std::size_t round = 0; round < std::size(shares); ++round) {
      chart_.share = shares[round];
      budget_ = chart_.share * settings_.budget;
      for (std::size_t i = 0; i < n; ++i) {
        observer_.progress(name_of(chart_.variants[i]),
                           double(round * n + i) / double(std::size(shares) * n));
        climb(i, shares[round] == 1);
        chart_.points.clear();
        for (const Ladder& each : ladders_)
          chart_.points.insert(chart_.points.end(), each.points.begin(), each.points.end());
        if (auto done = observer_.ladder_ends(chart_.points); !done) return done;
      }
      if (shares[round] < 1)
        if (auto done = observer_.round_ends(chart_); !done) return done;
    }
    return {};
  }

  /// A run of an interrupted chart, or a new one.
  WorkPrecisionPoint known_or_measured(std::size_t variant, double setting) {
    out_of_time_ = false;
    for (const WorkPrecisionPoint& p : observer_.known)
      if (p.variant == variant && p.setting == setting) return p;
    return measure(variant, setting);
  }

  /// Climbs on until a run exceeds the budget or finer rungs gain nothing. A run that is broken off within a
  /// share of the budget is made again with the next share.
  void climb(std::size_t variant, bool last) {
    Ladder& ladder = ladders_[variant];
    const bool adaptive = chart_.variants[variant].adaptive;
    const int finer = adaptive ? settings_.per_decade : 1;
    const int rungs = !adaptive ? 26 : (chart_.variants[variant].method == automatic ? 10 : 13) * finer + 1;
    // the longest step spans two or four outputs, if that divides their number
    const int longest = last_row_ % 4 == 0 ? 4 : last_row_ % 2 == 0 ? 2 : 1;
    while (!ladder.ended && ladder.rung < rungs && ladder.without_gain < 2 * finer) {
      const int rung = ladder.rung;
      const WorkPrecisionPoint point =
          known_or_measured(variant, adaptive ? std::pow(10, -1 - double(rung) / finer)
                                              : longest * how_.output_interval * std::pow(0.5, rung));
      if (out_of_time_ && !last) return;
      ladder.points.push_back(point);
      ++ladder.rung;
      // a method that refuses the scene refuses it at every step
      if (!point.finished && point.seconds < 1e-4 && rung == 0 && point.reason.starts_with("method '"))
        ladder.ended = true;
      if (point.seconds > settings_.budget) ladder.ended = true;
      if (point.finished) weigh_gain(point, rung, finer, ladder);
      if (point.seconds > budget_) return;
    }
  }

  /// Whether the error fell at a rung.
  void weigh_gain(const WorkPrecisionPoint& point, int rung, int finer, Ladder& ladder) const {
    const double judged = judged_error(chart_, point);
    const double error = std::isfinite(judged) ? judged : point.errors.energy;
    // an identical run (steps limited by the scene) says nothing about finer rungs
    if (error == ladder.best && point.evaluations == ladder.evaluations) return;
    ladder.evaluations = point.evaluations;
    // (errors of completely wrong runs do not count)
    const bool gains = error < 0.9 * ladder.best || ladder.best > 0.1 || rung < 3 * finer;
    ladder.without_gain = gains ? 0 : ladder.without_gain + 1;
    ladder.best = std::min(ladder.best, error);
  }

  const System& system_;
  const WorkPrecisionSettings& settings_;
  const WorkPrecisionObserver& observer_;
  const std::vector<OtherMethod>& others_;
  std::size_t first_other_ = 0;  ///< index into the variants
  SimulationSettings how_;
  std::vector<Eigen::Vector3d> centres_;  ///< gravity centre in each solid's frame
  std::optional<Trajectory> trajectory_;  ///< the reference
  std::size_t last_row_ = 0;              ///< last row of the runs
  /// Source of impacts and momenta (the reference, if we made it), and its last valid row.
  std::optional<Trajectory> motion_;
  std::size_t motion_row_ = 0;
  std::vector<Ladder> ladders_;  ///< by variant
  double budget_ = 0;            ///< the present share of the budget, s
  bool out_of_time_ = false;     ///< the last run was broken off
  WorkPrecision chart_;
};

// whether a point may be on a front: a run chosen automatically is another method's run
bool counts(const WorkPrecision& chart, const WorkPrecisionPoint& p, Whose whose) {
  const Variant& v = chart.variants[p.variant];
  return v.other == (whose == Whose::others) && v.method != automatic && p.finished && p.trusted;
}

}  // namespace

double processor_time() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

std::string name_of(const Variant& variant) {
  std::string out = variant.method;
  if (variant.equations == Equations::lagrange) out += ", lagrange";
  if (variant.constraints == ConstraintTreatment::baumgarte) out += ", baumgarte";
  return out;
}

std::string_view setting_name(const Variant& variant) {
  return variant.method == automatic ? "accuracy" : variant.adaptive ? "tolerance" : "step";
}

Result<WorkPrecision> work_precision(const Scene& scene, const WorkPrecisionSettings& settings,
                                     const WorkPrecisionObserver& observer,
                                     const std::vector<OtherMethod>& others) {
  const auto system = compile(scene);
  if (!system) return tl::unexpected(system.error());
  if (!(scene.simulation.end_time > system->initial.t))
    return bad_use(scene.name, "ends at its start, so it has no motion to chart; give a later --end");
  if (settings.outputs < 1 || settings.repeats < 1 || settings.per_decade < 1 || !(settings.budget > 0) ||
      settings.equations.empty() || settings.constraints.empty())
    return bad_use(
        "work-precision",
        "needs at least one output time, one repeat, one tolerance per decade, and time for a run");
  if (const auto& given = settings.reference) {
    const double start = system->initial.t, length = scene.simulation.end_time - start;
    for (int i = 0; i <= settings.outputs; ++i)
      if (const double at = start + i * length / settings.outputs;
          row_at(*given, at, length) == given->times.size())
        return bad_use(given->name, fmt::format("has no row at t = {:.9g} s; it needs a row every {:.9g} s, "
                                                "because runs are compared at {} times (--samples)",
                                                at, length / settings.outputs, settings.outputs));
  }
  return Chart(scene, *system, settings, observer, others).run();
}

double judged_error(const WorkPrecision& chart, const WorkPrecisionPoint& point) {
  const RunErrors& e = point.errors;
  if (!chart.has_impacts || !std::isfinite(e.position)) return std::max(e.position, e.orientation);
  double worst = 0;
  for (const double size : {e.impacts / chart.duration, e.momentum, e.constraint / chart.length, e.energy})
    if (std::isfinite(size)) worst = std::max(worst, size);
  return worst;
}

double reference_floor(const WorkPrecision& chart) {
  return chart.reference.found
             ? reference_margin * std::max(chart.reference.position, chart.reference.orientation)
             : 0;
}

std::vector<const WorkPrecisionPoint*> pareto_front(
    const WorkPrecision& chart, const std::function<double(const WorkPrecisionPoint&)>& cost,
    const std::function<double(const WorkPrecisionPoint&)>& error, double floor, Whose whose) {
  std::vector<std::tuple<double, double, const WorkPrecisionPoint*>> all;
  for (const WorkPrecisionPoint& p : chart.points)
    if (counts(chart, p, whose) && std::isfinite(error(p)))
      all.emplace_back(cost(p), std::max(error(p), floor), &p);
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) {
    return std::pair(std::get<0>(a), std::get<1>(a)) < std::pair(std::get<0>(b), std::get<1>(b));
  });
  double best = std::numeric_limits<double>::infinity();
  std::vector<const WorkPrecisionPoint*> out;
  for (const auto& [spent, size, p] : all)
    if (size < best) best = size, out.push_back(p);
  return out;
}

const WorkPrecisionPoint* fastest_within(const WorkPrecision& chart, double error, Whose whose) {
  if (!chart.reference.found || error < reference_floor(chart)) return nullptr;
  const WorkPrecisionPoint* best = nullptr;
  for (const WorkPrecisionPoint& p : chart.points)
    if (counts(chart, p, whose) && judged_error(chart, p) <= error && (!best || p.seconds < best->seconds))
      best = &p;
  return best;
}

double impact_time_error(const std::vector<double>& a, const std::vector<double>& reference, double start,
                         double end) {
  double worst = nothing;
  const auto compare = [&](const std::vector<double>& x, const std::vector<double>& y) {
    for (std::size_t i = 0; i < x.size() && x[i] <= end; ++i) {
      const double other = i < y.size() ? y[i] : y.empty() ? start : y.back();
      worst = std::fmax(worst, std::abs(x[i] - other));
    }
  };
  compare(a, reference);
  compare(reference, a);
  return worst;
}

}  // namespace borelli
