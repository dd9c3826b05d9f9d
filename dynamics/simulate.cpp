#include "dynamics/simulate.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "dynamics/certifier.hpp"
#include "dynamics/evaluate.hpp"
#include "dynamics/fastest_sine.hpp"
#include "dynamics/integrator.hpp"
#include "dynamics/recorder.hpp"
#include "dynamics/settings_check.hpp"
#include "dynamics/step_path.hpp"

namespace borelli {

namespace {

// beyond these no scene of solids means anything: the run has diverged
constexpr double largest_number = 1e12;

class Run {
 public:
  Run(const System& system, const State& state, const SimulationSettings& settings, const Observer& observer,
      Integrator& integrator)
      : system_(system),
        settings_(settings),
        observer_(observer),
        integrator_(integrator),
        state_(state),
        workspace_(system, settings.equations),
        probe_(system),
        motion_(system, settings, workspace_),
        path_(system, settings, motion_, integrator, probe_),
        recorder_(system),
        landing_(system),
        between_(system),
        y_(motion_.size()),
        dy_(motion_.size()),
        out_(motion_.size()),
        step_(settings.step) {}

  Result<Trajectory> run() {
    auto assembly = assemble(system_, system_.parameters, state_, workspace_);
    if (!assembly) return tl::unexpected(assembly.error());
    workspace_.evaluations = 0;
    Certifier certifier(system_, system_.parameters, threshold(), *assembly);
    certifier_ = &certifier;
    if (const auto sine = fastest_sine(system_, system_.parameters)) {
      sine_ = *sine;
      longest_step_ = longest_step_in_periods * sine->period;
    }
    landing_.state = state_;
    if (auto done = begin_step(); !done) return tl::unexpected(done.error());
    recorder_.record(state_, workspace_, work_);
    start_ = state_.t;
    const double end = settings_.end_time, interval = settings_.output_interval;
    outputs_ = interval > 0 ? std::max(1L, long(std::ceil((end - start_) / interval - 1e-9))) : 1;
    // fixed steps are evened out between outputs, where there is one at least
    const bool between =
        integrator_.dense_suffices() && (integrator_.adaptive() || interval < settings_.step);
    while (output_ <= outputs_ && !stopped_ && end > start_) {
      const double target = between ? end : output_time(output_);
      auto done = integrator_.adaptive() ? advance_adaptively(target) : advance_evenly(target);
      if (!done) return tl::unexpected(done.error());
    }
    judge_steps();
    return recorder_.finish(certifier.finish(work_, workspace_.evaluations + probe_.evaluations));
  }

 private:
  /// Of the k-th row after the first.
  double output_time(long k) const {
    return k == outputs_ ? settings_.end_time : start_ + double(k) * settings_.output_interval;
  }

  /// Looks at the state reached and readies the step from it.
  Result<void> begin_step() {
    if (!motion_.start(state_, work_, y_, dy_)) return diverged(motion_.failure(state_.t));
    if (landing_.projected) {
      landing_.book_projection(workspace_);
      certifier_->observe_projection(state_.t, landing_.velocity_change, workspace_);
      work_ = landing_.work;
      landing_.projected = false;
    }
    certifier_->observe(state_, workspace_, work_);
    probe_.solver.remember(workspace_.solver);
    return {};
  }

  Result<void> advance_evenly(double target) {
    const double from = state_.t;
    const long steps = std::max(1L, long(std::ceil((target - from) / settings_.step - 1e-9)));
    for (long i = 1; i <= steps && !stopped_; ++i) {
      const double t = state_.t,
                   next = i == steps ? target : from + (target - from) * double(i) / double(steps);
      if (!integrator_.attempt(motion_, t, next - t, y_, dy_, out_).evaluated)
        return diverged(motion_.failure(t));
      if (auto done = accept(next, next - t, true); !done) return done;
    }
    return {};
  }

  Result<void> advance_adaptively(double target) {
    const double resolution = 16 * std::numeric_limits<double>::epsilon() *
                              std::max(std::abs(settings_.end_time), std::abs(state_.t));
    while (state_.t < target && !stopped_) {
      if (step_ > longest_step_) {
        step_ = longest_step_;
        held_ = true;
      }
      const double t = state_.t, left = target - t;
      // land on the target without a sliver of a step before it
      const bool last = step_ >= left * (1 - 1e-12), whole = !last && step_ <= left / 2;
      const double h = last ? left : whole ? step_ : left / 2;
      const Attempt attempt = integrator_.attempt(motion_, t, h, y_, dy_, out_);
      if (double(++attempts_) > most_steps) return too_many("steps", most_steps);
      if (!attempt.accepted) {
        certifier_->count_rejection();
        step_ = attempt.next_step;
        if (step_ > resolution) continue;
        return failure(
            system_.scene,
            fmt::format("the step fell below {:.3g} s at t = {:.9g} s, for the sake of {}; the motion cannot "
                        "be continued to the tolerance of {:.3g}",
                        resolution, t, motion_.component(attempt.worst), settings_.tolerance));
      }
      // a step cut short says little about the next; do not let it shrink that
      step_ = whole ? attempt.next_step : std::max(step_, attempt.next_step);
      if (auto done = accept(last ? target : t + h, h, whole); !done) return done;
    }
    return {};
  }

  /// Takes the step just made: onto the constraints, into the books.
  Result<void> accept(double t, double h, bool whole) {
    const double from = state_.t;
    path_.begin(from, h, y_, dy_, out_, work_);
    if (auto done = path_.land_at_end(t, landing_); !done) return diverged(done.error());
    if (auto done = check_bounds(); !done) return done;
    if (auto done = record_between(t); !done) return done;
    state_ = landing_.state;
    work_ = landing_.work;
    certifier_->count_step(from, h, whole);
    recorder_.record_step(from, h);
    longest_made_ = std::max(longest_made_, h);
    if (auto done = begin_step(); !done) return done;
    if (observer_.progress && !observer_.progress(t)) {
      stopped_ = true;
      certifier_->stop(fmt::format("stopped on request at t = {:.6g} s of {:.6g} s", t, settings_.end_time),
                       t);
    }
    return record_end();
  }

  /// The rows that are due within the step, before its end at t.
  Result<void> record_between(double t) {
    if (settings_.output_interval <= 0) return {};
    for (; output_ < outputs_ && output_time(output_) < t; ++output_) {
      const double at = output_time(output_), from = state_.t;
      if (auto done = path_.land((at - from) / (t - from), between_); !done) return diverged(done.error());
      between_.state.t = at;
      if (const Fault fault = accelerate(system_, system_.parameters, at, between_.state.q.data(),
                                         between_.state.v.data(), motion_.handling(), probe_))
        return diverged(describe(system_, fault, at));
      between_.book_projection(probe_);
      certifier_->observe(between_.state, probe_, between_.work);
      recorder_.record(between_.state, probe_, between_.work);
    }
    return {};
  }

  /// The row at the state reached, if one is due.
  Result<void> record_end() {
    const bool every_step = settings_.output_interval <= 0;
    const bool due = state_.t >= output_time(output_);
    if (due) ++output_;
    if (!due && !every_step && !stopped_) return {};
    if (every_step && double(++rows_) > most_rows) return too_many("rows of output", most_rows);
    recorder_.record(state_, workspace_, work_);
    return {};
  }

  Result<void> check_bounds() {
    for (int i = 0; i < system_.nv; ++i) {
      const double x = out_[i], v = landing_.state.v[i];
      if (std::abs(x) < largest_number && std::abs(v) < largest_number) continue;
      return diverged({fmt::format("coordinate '{}'", system_.velocity_name(i)),
                       std::isfinite(v) && std::isfinite(x)
                           ? fmt::format("its velocity has grown to {:.3g}", v)
                           : "it is no longer a finite number"});
    }
    return {};
  }

  tl::unexpected<Error> diverged(const Error& error) const {
    return failure(error.where, fmt::format("{}; the run ends at t = {:.9g} s of {:.6g} s", error.what,
                                            state_.t, settings_.end_time));
  }

  tl::unexpected<Error> too_many(const char* what, double most) const {
    return failure(system_.scene,
                   fmt::format("more than {:.0e} {} were needed to come to t = {:.9g} s of {:.6g} s; shorten "
                               "the run{}",
                               most, what, state_.t, settings_.end_time,
                               settings_.output_interval > 0 ? "" : ", or set an output_interval"));
  }

  /// Whether the steps followed the scene's fastest sine.
  void judge_steps() {
    if (held_)
      certifier_->note(fmt::format("steps were held to {:.4g} s, an eighth of the period of {}",
                                   longest_step_, sine_.name));
    // a whole number of steps between outputs may be off by rounding
    if (longest_made_ > longest_step_ * (1 + 1e-9))
      certifier_->distrust(
          settings_.end_time,
          fmt::format("steps of {:.4g} s cannot follow {}, whose period is {:.4g} s; take steps of at most "
                      "{:.4g} s, an eighth of it",
                      longest_made_, sine_.name, sine_.period, longest_step_));
  }

  double threshold() const {
    if (settings_.energy_threshold > 0) return settings_.energy_threshold;
    // a fixed step promises nothing: a thousandth is what an eye lets pass. A tolerance per step adds up over
    // steps.
    return integrator_.adaptive() ? std::clamp(1e3 * settings_.tolerance, 1e-9, 1e-3) : 1e-3;
  }

  const System& system_;
  const SimulationSettings& settings_;
  const Observer& observer_;
  Integrator& integrator_;
  State state_;
  Workspace workspace_;
  Workspace probe_;  ///< for states between steps
  MotionFlow motion_;
  StepPath path_;
  Recorder recorder_;
  Certifier* certifier_ = nullptr;
  Work work_{system_.groups};
  Landing landing_, between_;
  Eigen::VectorXd y_, dy_, out_;
  double step_;
  FastestSine sine_;
  double longest_step_ = std::numeric_limits<double>::infinity();  ///< s, that follows the fastest sine
  double longest_made_ = 0;                                        ///< s, of the accepted ones
  bool held_ = false;                                              ///< a step was cut to longest_step_
  long attempts_ = 0, rows_ = 0;
  double start_ = 0;
  long outputs_ = 1, output_ = 1;  ///< rows to come to after the first, and the next of them
  bool stopped_ = false;
};

}  // namespace

Result<Trajectory> simulate(const System& system, const State& state, const SimulationSettings& settings,
                            const Observer& observer) {
  if (auto ok = check_state(system, state); !ok) return tl::unexpected(ok.error());
  if (auto ok = check_settings(settings, state.t); !ok) return tl::unexpected(ok.error());
  auto integrator = make_integrator(settings.method, settings.tolerance);
  if (!integrator) return tl::unexpected(integrator.error());
  if (auto ok = check_counts(system, state.t, settings, (*integrator)->adaptive()); !ok)
    return tl::unexpected(ok.error());
  try {
    return Run(system, state, settings, observer, **integrator).run();
  } catch (const std::exception& thrown) {  // from a user's function
    return failure(system.scene, fmt::format("a user's function threw: {}", thrown.what()));
  }
}

Result<Trajectory> simulate(const System& system) {
  return simulate(system, system.initial, system.settings);
}

}  // namespace borelli
