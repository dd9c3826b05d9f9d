#include "dynamics/run/simulate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <optional>

#include "dynamics/contacts/put_apart.hpp"
#include "dynamics/equations/evaluate.hpp"
#include "dynamics/methods/integrator.hpp"
#include "dynamics/run/accuracy.hpp"
#include "dynamics/run/certifier.hpp"
#include "dynamics/run/checkpoint.hpp"
#include "dynamics/run/contact_events.hpp"
#include "dynamics/run/disturbance.hpp"
#include "dynamics/run/equal_steps.hpp"
#include "dynamics/run/event_watch.hpp"
#include "dynamics/run/function_watch.hpp"
#include "dynamics/run/projection_watch.hpp"
#include "dynamics/run/range_events.hpp"
#include "dynamics/run/recorder.hpp"
#include "dynamics/run/settings_check.hpp"
#include "dynamics/run/sink_watch.hpp"
#include "dynamics/run/spring_events.hpp"
#include "dynamics/run/step_path.hpp"
#include "dynamics/system/border.hpp"
#include "dynamics/system/fastest_change.hpp"
#include "dynamics/system/knots.hpp"

namespace borelli {

namespace {

// The number of steps between outputs may differ from a whole number by rounding.
constexpr double slack = 1 + 1e-9;

// Tolerated deviation of a function of a coordinate from what the ends of a step predict: in tolerances, or,
// without a tolerance, relative to its constraint's size.
constexpr double features_in_tolerances = 10, least_feature = 1e-3;

// After a step that was too long for such a function, steps grow by at most this factor.
constexpr double growth_after_feature = 1.5;

// Largest number of events without progress in time; larger than any chain of impacts in a scene.
constexpr int most_events_at_once = 1000;

// A stiff run is abandoned if its rest needs this multiple of the steps tried so far. The next method must
// repeat the whole run, twice.
constexpr double worth_leaving = 1.5;

// How many times a run is disturbed on its way.
constexpr std::size_t disturbances = 8;

/// The number of rows after the start; 1 if every step makes a row.
long rows_from(double start, const SimulationSettings& s) {
  if (s.output_interval <= 0) return 1;
  return std::max(1L, long(std::ceil((s.end_time - start) / s.output_interval - 1e-9)));
}

/// The number of rows to reserve, including the start. The number of adaptive steps is unknown.
std::size_t expected_rows(double start, const SimulationSettings& s, bool adaptive) {
  constexpr std::size_t adaptive_steps = 1024;
  if (s.output_interval > 0) return std::size_t(rows_from(start, s)) + 1;
  if (adaptive) return adaptive_steps;
  return std::size_t(std::ceil((s.end_time - start) / s.step)) + 2;  // rounding may add a step
}

class Run {
 public:
  /// `own`: the parameters of `system` if this run owns them and springs may change them; else null.
  Run(const System& system, Parameters* own, const State& state, const SimulationSettings& settings,
      const Observer& observer, Integrator& integrator, const RunLimits& limits, Samples* samples)
      : system_(system),
        own_(own),
        settings_(settings),
        observer_(observer),
        integrator_(integrator),
        limits_(limits),
        samples_(samples),
        start_state_(state),
        state_(state),
        workspace_(system, settings.equations),
        probe_(system.rows > 0 ? std::make_optional<Workspace>(system) : std::nullopt),
        motion_(system, settings, workspace_),
        path_(system, settings, motion_, integrator, probe_ ? &*probe_ : nullptr),
        recorder_(system, expected_rows(state.t, settings, integrator.adaptive()),
                  settings.output_interval > 0 || !integrator.adaptive()),
        landing_(system),
        between_(system),
        row_(system),
        y_(motion_.size()),
        dy_(motion_.size()),
        out_(motion_.size()),
        step_(settings.step),
        knots_(system, system.parameters),
        leaps_(settings.tolerance),
        functions_(system, system.parameters,
                   integrator.adaptive() ? features_in_tolerances * settings.tolerance : least_feature) {
    workspace_.leaves_contacts = integrator.handles_contacts();
    if (probe_) probe_->leaves_contacts = workspace_.leaves_contacts;
  }

  Result<Trajectory> run() {
    auto assembly = assemble(system_, system_.parameters, state_, workspace_);
    std::string moved;
    if (assembly && settings_.put_apart) {
      auto apart = put_apart(system_, system_.parameters, state_);
      if (!apart) return tl::unexpected(apart.error());
      moved = *apart;
      if (!moved.empty()) assembly = assemble(system_, system_.parameters, state_, workspace_);
    }
    if (!assembly) return tl::unexpected(assembly.error());
    workspace_.evaluations = 0;
    const double threshold = energy_threshold(settings_, integrator_.adaptive(), steps_contacts());
    Certifier certifier(system_, system_.parameters, threshold, *assembly);
    certifier_ = &certifier;
    if (!moved.empty()) certifier.note(moved);
    if (const auto change = fastest_change(system_, system_.parameters, settings_.end_time - state_.t,
                                           !integrator_.adaptive())) {
      change_ = *change;
      longest_step_ = longest_step_in_periods * change->period;
    }
    landing_.state = state_;
    if (auto done = begin_step(); !done) return tl::unexpected(done.error());
    std::optional<ContactEvents> contacts;
    if (steps_contacts()) {
      ConstraintRows every(system_);
      every.every_row = true;
      scan_constraints(system_, system_.parameters, workspace_.kinematics, every);
      if (auto apart = check_apart(system_, every); !apart) return diverged(apart.error());
    } else if (!system_.contacts.empty()) {
      contacts.emplace(system_, settings_, workspace_, probe(), certifier);
      energy_before_event_ = workspace_.terms.group_kinetic + workspace_.terms.group_potential;
      if (auto done = contacts->start(state_); !done) return diverged(done.error());
      contacts_ = &*contacts;
      event_passed_ = true;
      if (auto done = begin_step(); !done) return tl::unexpected(done.error());
    }
    if (samples_) samples_->cover(state_);
    if (auto done = record(state_, workspace_, work_); !done) return tl::unexpected(done.error());
    RangeEvents ranges(system_, certifier);
    std::vector<EventSource*> sources = observer_.events;
    if (ranges.count() > 0) sources.push_back(&ranges);
    if (contacts) sources.push_back(&*contacts);
    std::optional<SpringEvents> springs;
    if (own_ && !steps_contacts()) {
      springs.emplace(system_, *own_);
      if (springs->count() > 0) {
        sources.push_back(&*springs);
        springs_ = &*springs;
        springs_->follow(workspace_.kinematics);
      }
    }
    EventWatch watch(system_, sources);
    watch_ = &watch;
    watch.start(state_, workspace_.kinematics);
    start_ = state_.t;
    const double end = settings_.end_time, interval = settings_.output_interval;
    outputs_ = rows_from(start_, settings_);
    // Fixed steps are equalised between outputs if there is at least one step between them.
    const bool between =
        integrator_.dense_suffices() && (integrator_.adaptive() || interval < settings_.step);
    if (!observer_.checkpoint.empty())
      if (auto done = read_checkpoint(observer_.checkpoint, signature(), [&](Keeper& k) { keep(k, ranges); });
          !done)
        return tl::unexpected(done.error());
    ranges_ = &ranges;
    while (output_ <= outputs_ && !stopped_ && end > start_) {
      const double target = between ? end : output_time(output_);
      auto done = integrator_.adaptive() ? advance_adaptively(std::min(target, knots_.after(state_.t)))
                                         : advance_evenly(target);
      if (!done) return tl::unexpected(done.error());
    }
    judge_steps();
    Certificate certificate = certifier.finish(work_, evaluations());
    certificate.method = settings_.method;
    certificate.equations = equations_name();
    return recorder_.finish(std::move(certificate));
  }

  long evaluations() const { return workspace_.evaluations + (probe_ ? probe_->evaluations : 0); }

 private:
  /// Workspace for states between steps.
  Workspace& probe() { return probe_ ? *probe_ : probe_.emplace(system_); }

  /// The kinematics of a state; valid until the next call.
  const Kinematics& landed(const State& state) {
    if (!landed_) landed_.emplace(system_);
    update_kinematics(system_, system_.parameters, state.t, state.q.data(), state.v.data(), *landed_);
    return *landed_;
  }

  /// Whether the method treats the scene's contacts within its steps.
  bool steps_contacts() const { return integrator_.handles_contacts() && !system_.contacts.empty(); }

  /// Time of the k-th row after the first, s.
  double output_time(long k) const {
    return k == outputs_ ? settings_.end_time : start_ + double(k) * settings_.output_interval;
  }

  /// Observes the present state and prepares the next step from it.
  Result<void> begin_step() {
    if (event_passed_ && contacts_) {  // other rows are active now; the memory of the former rank is invalid
      workspace_.solver.forget();
      probe().solver.forget();
    }
    if (springs_) springs_->follow(landed(state_));
    const bool kept = keeping_ && !event_passed_ && !motion_.off_centre(out_);
    if (kept) y_ = out_;
    if (!(kept ? motion_.go_on(state_, y_, dy_) : motion_.start(state_, work_, y_, dy_)))
      return diverged(motion_.failure(state_.t));
    if (!kept && integrator_.keeps_history()) integrator_.reset();
    keeping_ = integrator_.keeps_history();
    if (landing_.projected) {
      landing_.book_projection(workspace_);
      certifier_->observe_projection(state_.t, landing_.projection, workspace_);
      work_ = landing_.work;
      landing_.projected = false;
    }
    // Events, and contacts that the method treats itself, change velocities within the step.
    const ContactStep* contact = steps_contacts() ? integrator_.contact_step() : nullptr;
    const bool joined = !event_passed_ && !(contact && contact->acted);
    if (event_passed_) {
      work_.add_event(workspace_.terms.group_kinetic + workspace_.terms.group_potential -
                      energy_before_event_);
      certifier_->pass_event(workspace_, !observer_.events.empty());
      event_passed_ = false;
    }
    certifier_->observe(state_, workspace_, work_);
    if (!integrator_.adaptive()) certifier_->observe_step(state_, workspace_.a, integrator_.order(), joined);
    if (probe_) probe_->solver.remember(workspace_.solver);
    if (contacts_) contacts_->follow(workspace_);
    return {};
  }

  Result<void> advance_evenly(double target) {
    // the latter if a resumed run is at its output row
    if (even_.done() || state_.t >= even_.target()) even_.begin(state_.t, target, settings_.step);
    for (; !even_.done() && !stopped_; even_.go_on()) {
      const double next = even_.step_end();
      while (state_.t < next && !stopped_) {  // once, unless an event ends the step or the step is divided
        const double t = state_.t;
        const auto [h, end] = even_.part_from(t);
        const auto made = try_evenly(end, h);
        if (!made) return tl::unexpected(made.error());
        if (!*made) {
          certifier_->count_rejection();
          even_.divide(h);
          continue;
        }
        even_.lengthen();
        if (const std::string name = passes_over_function(); !name.empty())
          certifier_->distrust(t, fmt::format("steps of {:.4g} s miss changes of the function of constraint "
                                              "'{}' between their ends; take shorter steps",
                                              h, name));
        if (auto done = accept(end, h, even_.whole()); !done) return done;
        if (state_.t < end) even_.cut_short();
      }
    }
    return {};
  }

  /// Makes a step of h, an equal step or a part of it, to time `end`. Returns false if the step must be
  /// divided, as methods that treat contacts may require.
  Result<bool> try_evenly(double end, double h) {
    const double t = state_.t;
    const bool divisible = steps_contacts() && even_.divisible(h);
    const Attempt attempt = integrator_.attempt(motion_, t, h, y_, dy_, out_);
    if (attempt.trouble) return diverged({system_.scene, attempt.trouble});
    if (!attempt.evaluated && divisible) return false;
    if (!attempt.evaluated) return diverged(motion_.failure(t));
    if (auto done = land(end, h); !done) {
      if (divisible) return false;
      return tl::unexpected(done.error());
    }
    if (!steps_contacts() || !too_long(h)) return true;
    if (!divisible) even_.count_vain();
    return !divisible;
  }

  Result<void> advance_adaptively(double target) {
    const double resolution = 16 * std::numeric_limits<double>::epsilon() *
                              std::max(std::abs(settings_.end_time), std::abs(state_.t));
    if (limits_.own_first_step && attempts_ == 0)
      if (const double h = integrator_.first_step(motion_, state_.t, y_, dy_); h > 0) step_ = h;
    while (state_.t < target && !stopped_) {
      if (step_ > longest_step_) {
        step_ = longest_step_;
        held_ = true;
      }
      const double t = state_.t, left = target - t;
      // Land on the target without a tiny last step.
      const bool last = step_ >= left * (1 - 1e-12), whole = !last && step_ <= left / 2;
      const double h = last ? left : whole ? step_ : left / 2;
      const Attempt attempt = integrator_.attempt(motion_, t, h, y_, dy_, out_);
      attempts_ += 1 + attempt.rejected;
      if (double(attempts_) > most_steps) return too_many("steps", most_steps);
      if (attempt.trouble) return diverged({system_.scene, attempt.trouble});
      for (int i = 0; i < attempt.rejected; ++i) certifier_->count_rejection();
      if (!attempt.accepted) {
        certifier_->count_rejection();
        step_ = attempt.next_step;
        if (auto done = follow_steps(attempt); !done) return done;
        if (step_ > resolution) continue;
        return failure(system_.scene,
                       fmt::format("the step fell below {:.3g} s at t = {:.9g} s because of {}, so the "
                                   "tolerance of {:.3g} cannot be met",
                                   resolution, t, motion_.component(worst_of(attempt)), settings_.tolerance));
      }
      // A shortened step says little about the next one; do not let it reduce the proposal.
      step_ = whole ? attempt.next_step : std::max(step_, attempt.next_step);
      const bool cut = attempt.made > 0 && attempt.made < h * (1 - 1e-12);
      const double made = cut ? attempt.made : h, end = last && !cut ? target : t + made;
      if (auto done = land(end, made); !done) return done;
      if (landing_.projected && leaps_.again(t, made, motion_.distance(out_, landing_.state))) {
        certifier_->count_rejection();
        integrator_.reset();
        step_ = ProjectionWatch::shorter * made;
        continue;
      }
      // The shortest possible steps are accepted; otherwise this would not terminate.
      if (made > 2 * resolution && (!passes_over_function().empty() || passes_over_springs(made))) {
        certifier_->count_rejection();
        integrator_.reset();
        step_ = follow_function_ = 0.5 * made;
        continue;
      }
      follow_function_ *= growth_after_feature;
      step_ = std::min(step_, follow_function_);
      if (auto done = accept(end, made, whole || cut); !done) return done;
      if (auto done = follow_steps(attempt); !done) return done;
    }
    return {};
  }

  /// The component that limits the step: the method's worst one, or if there is none (or the equations could
  /// not be solved), the one that changes fastest.
  int worst_of(const Attempt& attempt) const {
    if (attempt.worst >= 0) return attempt.worst;
    int fastest = -1;
    double most = -1;
    for (int i = 0; i < 2 * system_.nv; ++i)
      if (const double rate = std::abs(dy_[i]) / motion_.error_scale()[i]; rate > most) {
        most = rate;
        fastest = i;
      }
    return fastest;
  }

  /// Fails if the steps shrink to zero or stall.
  Result<void> follow_steps(const Attempt& attempt) {
    const double t = state_.t, end = settings_.end_time;
    const double step = attempt.made > 0 ? attempt.made : step_;  // such methods propose no step
    const auto verdict = sink_.after(t, step, attempt.accepted, end, most_steps);
    if (verdict == SinkWatch::Verdict::fine) return {};
    const int i = worst_of(attempt), n = system_.nv;
    const std::string now = i < 0 || i >= 2 * n
                                ? ""
                                : fmt::format(" (now {:.3g}, changing by {:.3g} per second)",
                                              i < n ? state_.v[i] : state_.v[i - n], dy_[n + i % n]);
    const std::string sake = motion_.component(i) + now;
    if (verdict == SinkWatch::Verdict::sinking)
      return diverged({system_.scene, fmt::format("the steps shrink towards zero, from {:.3g} s to {:.3g} s, "
                                                  "because of {}: the run cannot pass t = {:.9g} s",
                                                  sink_.longest(), step, sake, t)});
    return diverged({system_.scene, fmt::format("{} step attempts advanced by only {:.3g} s, because of {}; "
                                                "the rest would take more than {:.0e} of them",
                                                sink_.tried(), sink_.made(), sake, most_steps)});
  }

  /// Projects the end of the step of h, at time t, on the constraints.
  Result<void> land(double t, double h) {
    path_.begin(state_.t, h, y_, dy_, out_, work_);
    if (auto done = path_.land_at_end(t, landing_); !done) return diverged(done.error());
    return {};
  }

  /// Whether the step of h given to land() must be divided, for a method that treats contacts itself.
  bool too_long(double h) {
    const State& end = landing_.state;
    if (!landing_.projected) {
      if (update_energies(system_, system_.parameters, end.t, end.q.data(), end.v.data(), probe()))
        return true;
      energy_ = probe().terms.group_kinetic + probe().terms.group_potential;
    }
    return certifier_->too_long(h, *integrator_.contact_step(),
                                landing_.projected ? landing_.projection.energy_before : energy_,
                                landing_.work);
  }

  /// The constraint whose function makes the step given to land() too long; empty: none.
  std::string passes_over_function() {
    if (functions_.empty()) return "";
    update_kinematics(system_, system_.parameters, state_.t, state_.q.data(), state_.v.data(),
                      probe().kinematics);
    return functions_.passed_over(probe().kinematics, landed(landing_.state));
  }

  /// Whether the step of h given to land() may skip an event of a torsion spring.
  bool passes_over_springs(double h) {
    if (!springs_ || !springs_->any_turns()) return false;
    return springs_->turned_too_far(landed(landing_.state), h);
  }

  /// Accepts the step given to land(), up to its first event that changes anything, and books it.
  Result<void> accept(double t, double h, bool whole) {
    const double from = state_.t;
    if (auto done = check_bounds(); !done) return done;
    if (auto done = pass_events(h); !done) return done;
    const double made = landing_.state.t < t ? landing_.state.t - from : h;
    if (auto done = record_between(h, landing_.state.t); !done) return done;
    if (auto done = sample_between(h, landing_.state.t); !done) return done;
    if (samples_) samples_->take(landing_.state);
    if (const ContactStep* step = steps_contacts() ? integrator_.contact_step() : nullptr) {
      landing_.work.add_event(step->group_work);
      landing_.work.add_projection(step->group_projection);
      certifier_->observe_contacts(landing_.state.t, *step);
      recorder_.record_impulses(step->impulse, h);
    }
    state_ = landing_.state;
    work_ = landing_.work;
    if (limits_.disturbance > 0) disturb();
    if (made > 0) {
      certifier_->count_step(from, made, whole && made == h);
      recorder_.record_step(from, made);
      if (longest_made_ <= slack * longest_step_ && made > slack * longest_step_) first_overlong_ = from;
      longest_made_ = std::max(longest_made_, made);
    }
    if (samples_) samples_->cover(state_);
    if (auto done = begin_step(); !done) return done;
    if (integrator_.stiff() && !stiff_) {
      stiff_ = true;
      certifier_->find_stiff(state_.t);
      certifier_->note(
          fmt::format("stability, not accuracy, limits the steps of {} from t = {:.6g} s on: the scene is "
                      "stiff; an implicit method (cvode, arkode, gauss4) may take longer steps",
                      settings_.method, state_.t));
    }
    if (stiff_ && limits_.leave_if_stiff &&
        settings_.end_time - state_.t > worth_leaving * double(attempts_) * made)
      stopped_ = true;
    stopped_ = stopped_ || double(evaluations()) > limits_.evaluations;
    if (auto done = record_end(); !done) return done;
    const bool stop = observer_.progress && !observer_.progress(state_.t);
    if (observer_.keep && (stop || (observer_.keep_due && observer_.keep_due())))
      observer_.keep(write_checkpoint(signature(), [&](Keeper& k) { keep(k, *ranges_); }));
    if (observer_.rows && observer_.rows_due && observer_.rows_due()) show_rows();
    if (!stop) return {};
    stopped_ = true;
    certifier_->stop(
        fmt::format("stopped on request at t = {:.6g} s of {:.6g} s", state_.t, settings_.end_time),
        state_.t);
    return recorded_ ? Result<void>() : record(state_, workspace_, work_);
  }

  const char* equations_name() const {
    return settings_.equations == Equations::lagrange ? "lagrange" : "recursive";
  }

  void show_rows() {
    Certificate certificate;
    certificate.reason = fmt::format("the run was interrupted; this is its state at t = {:.6g} s of {:.6g} s",
                                     state_.t, settings_.end_time);
    certificate.reason_time = state_.t;
    certificate.method = settings_.method;
    certificate.equations = equations_name();
    observer_.rows(recorder_.so_far(std::move(certificate)));
  }

  std::string signature() const { return run_signature(system_, start_state_, settings_); }

  /// Saves or restores everything that later steps depend on. Returns false if the method does not support
  /// it.
  bool keep(Keeper& k, RangeEvents& ranges) {
    k(state_.t, state_.q, state_.v, work_, y_, dy_, out_, step_, sink_, longest_made_, first_overlong_, held_,
      attempts_, rows_, follow_function_, start_, stiff_, keeping_, last_event_, events_at_once_, motion_,
      workspace_, probe(), leaps_, *certifier_, recorder_, *watch_, ranges);
    k.within(output_, 1L, outputs_ + 1);
    even_.keep(k, start_state_.t, settings_);
    if (contacts_) k(*contacts_);
    if (springs_) k(*springs_);
    return integrator_.keep(k);
  }

  std::string last_event_words() const {
    const auto& log = certifier_->events();
    return log.empty() ? "" : fmt::format(", the last of them {} at '{}'", log.back().kind, log.back().name);
  }

  /// Handles the events of the step; the first one that changes anything ends it.
  Result<void> pass_events(double h) {
    if (watch_->empty()) return {};
    watch_->begin_step();
    for (;;) {
      const auto found = watch_->find(path_, state_.t, h, landing_, between_);
      if (!found) return diverged(found.error());
      if (!*found) return {};
      // Record the rows before the event now, because the event may change what they depend on.
      if (auto done = record_between(h, between_.state.t); !done) return done;
      if (auto done = sample_between(h, between_.state.t); !done) return done;
      if (auto done = look_between(between_); !done) return done;
      energy_before_event_ = probe().terms.group_kinetic + probe().terms.group_potential;
      const auto after = watch_->handle(between_, probe(), certifier_->events());
      if (!after) return diverged(after.error());
      if (double(certifier_->events().size()) > most_rows) return too_many("events", most_rows);
      if (*after == AfterEvent::go_on) continue;
      landing_ = between_;
      integrator_.reset();
      event_passed_ = true;
      events_at_once_ = landing_.state.t > last_event_ ? 0 : events_at_once_ + 1;
      last_event_ = landing_.state.t;
      if (events_at_once_ > most_events_at_once)
        return diverged({system_.scene, fmt::format("{} events follow each other at the same time{}",
                                                    most_events_at_once, last_event_words())});
      return {};
    }
  }

  /// Solves the equations at a state between steps, books its projection and shows it to the certifier.
  Result<void> look_between(Landing& between) {
    const State& state = between.state;
    if (const Fault fault = accelerate(system_, system_.parameters, state.t, state.q.data(), state.v.data(),
                                       motion_.handling(), probe()))
      return diverged(describe(system_, fault, state.t));
    between.book_projection(probe());
    between.projected = false;  // not a second time if it becomes the step's end
    certifier_->observe(state, probe(), between.work);
    return {};
  }

  /// Records the rows due within the step of h, before time `until`.
  Result<void> record_between(double h, double until) {
    if (settings_.output_interval <= 0) return {};
    for (; output_ < outputs_ && output_time(output_) < until; ++output_) {
      const double at = output_time(output_);
      if (auto done = path_.land((at - state_.t) / h, row_); !done) return diverged(done.error());
      row_.state.t = at;
      if (samples_) samples_->take(row_.state);
      if (auto done = look_between(row_); !done) return done;
      if (auto done = record(row_.state, probe(), row_.work); !done) return done;
    }
    return {};
  }

  /// Takes the samples due within the step of h, before time `until`.
  Result<void> sample_between(double h, double until) {
    if (!samples_) return {};
    for (double at = samples_->next(); at < until; at = samples_->next()) {
      if (auto done = path_.glance((at - state_.t) / h, row_); !done) return diverged(done.error());
      row_.state.t = at;
      samples_->take(row_.state);
    }
    return {};
  }

  /// Disturbs the state on the way. If work is done on the scene, the disturbance at the start decays before
  /// the motion may become unstable. Signs follow the Thue-Morse sequence, so that the disturbances hardly
  /// accumulate.
  void disturb() {
    const bool conserves =
        work_.efforts == 0 && work_.drives == 0 && work_.constraints == 0 && work_.violation == 0;
    if (conserves || !samples_ || integrator_.keeps_history()) return;
    const std::size_t times = disturbances * samples_->q.size() / samples_->times.size();
    if (times == disturbed_) return;
    disturbed_ = times;
    state_ = disturbed(system_, state_,
                       std::popcount(times) % 2 == 0 ? limits_.disturbance : -limits_.disturbance);
  }

  /// Records the row at the present state, if one is due.
  Result<void> record_end() {
    const bool every_step = settings_.output_interval <= 0;
    const bool due = state_.t >= output_time(output_);
    if (due) ++output_;
    recorded_ = due || every_step || stopped_;
    if (!recorded_) return {};
    if (every_step && double(++rows_) > most_rows) return too_many("rows of output", most_rows);
    return record(state_, workspace_, work_);
  }

  Result<void> record(const State& state, Workspace& workspace, const Work& work) {
    if (auto fits = recorder_.admit(); !fits) return diverged(fits.error());
    recorder_.record(state, workspace, work);
    return {};
  }

  Result<void> check_bounds() {
    for (int i = 0; i < system_.nv; ++i) {
      const double x = out_[i], v = landing_.state.v[i];
      if (std::abs(x) < largest_number && std::abs(v) < largest_number) continue;
      return diverged({fmt::format("coordinate '{}'", system_.velocity_name(i)),
                       !std::isfinite(v) || !std::isfinite(x) ? "it is no longer a finite number"
                       : std::abs(v) < largest_number ? fmt::format("it has grown to {:.3g} within a step", x)
                                                      : fmt::format("its velocity has grown to {:.3g}", v)});
    }
    return {};
  }

  tl::unexpected<Error> diverged(const Error& error) const {
    return failure(error.where, fmt::format("{}; the run ends at t = {:.9g} s of {:.6g} s", error.what,
                                            state_.t, settings_.end_time));
  }

  tl::unexpected<Error> too_many(const char* what, double most) const {
    return failure(
        system_.scene,
        fmt::format("the run needed more than {:.0e} {} to reach t = {:.9g} s of {:.6g} s; shorten the run{}",
                    most, what, state_.t, settings_.end_time,
                    settings_.output_interval > 0 ? "" : ", or set an output_interval"));
  }

  /// Judges the steps: notes repeated ones and checks whether they resolved the scene's fastest change in
  /// time.
  void judge_steps() {
    if (leaps_.count() > 0)
      certifier_->note(
          fmt::format("{} steps were repeated with a shorter length, because constraint projection moved "
                      "their ends by more than {:g} times the tolerance",
                      leaps_.count(), ProjectionWatch::limit));
    if (held_)
      certifier_->note(fmt::format("steps were limited to {:.4g} s, an eighth of the {} of {}", longest_step_,
                                   change_.wave, change_.name));
    if (longest_made_ > slack * longest_step_)
      certifier_->distrust(
          first_overlong_,
          fmt::format("steps of {:.4g} s (from t = {:.6g} s on) cannot follow {}, whose {} is {:.4g} s; take "
                      "steps of at most {:.4g} s, an eighth of it",
                      longest_made_, first_overlong_, change_.name, change_.wave, change_.period,
                      longest_step_));
  }

  const System& system_;
  Parameters* own_;
  const SimulationSettings& settings_;
  const Observer& observer_;
  Integrator& integrator_;
  const RunLimits& limits_;
  Samples* samples_;           ///< null: no samples wanted
  std::size_t disturbed_ = 0;  ///< number of disturbances on the way
  const State start_state_;
  State state_;
  Workspace workspace_;
  std::optional<Workspace> probe_;  ///< see probe(); set if the scene has rows, or at first use
  MotionFlow motion_;
  StepPath path_;
  Recorder recorder_;
  Certifier* certifier_ = nullptr;
  Work work_{system_.groups};
  Landing landing_, between_, row_;
  Eigen::VectorXd y_, dy_, out_;
  double step_;
  FastestChange change_;
  /// s, longest step that resolves the fastest change
  double longest_step_ = std::numeric_limits<double>::infinity();
  double longest_made_ = 0;    ///< s, longest accepted step
  double first_overlong_ = 0;  ///< s, start of the first step above longest_step_
  bool held_ = false;          ///< a step was cut to longest_step_
  long attempts_ = 0, rows_ = 0;
  Knots knots_;  ///< times at which adaptive steps end
  ProjectionWatch leaps_;
  SpringEvents* springs_ = nullptr;  ///< null: no spring events, or springs not owned
  FunctionWatch functions_;
  std::optional<Kinematics> landed_;  ///< see landed(); set at first use
  /// s, longest step to try after one that skipped a feature
  double follow_function_ = std::numeric_limits<double>::infinity();
  SinkWatch sink_;
  double start_ = 0;
  long outputs_ = 1, output_ = 1;  ///< number of rows after the first; index of the next one
  bool stopped_ = false;
  ContactEvents* contacts_ = nullptr;
  bool stiff_ = false;
  bool keeping_ = false;  ///< the method's history continues from the previous step
  EventWatch* watch_ = nullptr;
  RangeEvents* ranges_ = nullptr;
  bool recorded_ = false;  ///< the present state has its row
  EqualSteps even_;
  bool event_passed_ = false;  ///< the present state follows an event that changed it
  Eigen::VectorXd energy_, energy_before_event_;
  double last_event_ = -std::numeric_limits<double>::infinity();
  int events_at_once_ = 0;
};

}  // namespace

namespace {

/// Requests memory for everything but the output rows, which Recorder::admit() covers.
Result<void> admit_run(const System& system, const SimulationSettings& settings,
                       const Integrator& integrator) {
  // For steps, for states between them, and for contact events.
  const int workspaces = system.rows == 0                                           ? 1
                         : system.contacts.empty() || integrator.handles_contacts() ? 2
                                                                                    : 3;
  if (auto fits = admit_workspaces(system, settings.equations, workspaces, false); !fits) return fits;
  return admit_large(system, integrator.bytes(2 * system.nv + 4 + system.groups), [&] {
    return fmt::format("the method {} for {} coordinates", settings.method, system.nv);
  });
}

/// One run with the named method.
Result<Trajectory> simulate_once(const System& system, const State& state, const SimulationSettings& settings,
                                 const Observer& observer, const RunLimits& limits = {},
                                 Samples* samples = nullptr) {
  auto integrator = make_integrator(settings.method, settings.tolerance, settings.spectral_radius);
  if (!integrator) return tl::unexpected(integrator.error());
  if (const char* objection = (*integrator)->objection(system, settings.constraints))
    return bad_use(fmt::format("method '{}'", settings.method), objection);
  if ((*integrator)->handles_contacts() && !system.contacts.empty() && !observer.events.empty())
    return bad_use(
        fmt::format("method '{}'", settings.method),
        "resolves contacts within its steps, and a user's own event would cut a step; choose another method");
  if (auto ok = check_time_stepping(system, settings.method, (*integrator)->handles_contacts()); !ok)
    return tl::unexpected(ok.error());
  if (auto ok = check_counts(system, state.t, settings, (*integrator)->adaptive()); !ok)
    return tl::unexpected(ok.error());
  if (observer.keep || !observer.checkpoint.empty()) {
    if (!observer.events.empty())
      return bad_use("checkpoint",
                     "cannot store a user's own events; run without a checkpoint, or without these events");
    if (Keeper trial; !(*integrator)->keep(trial))
      return bad_use(fmt::format("method '{}'", settings.method),
                     "depends on a history that no checkpoint can store; run without a checkpoint, or choose "
                     "another method");
  }
  if (auto fits = admit_run(system, settings, **integrator); !fits) return tl::unexpected(fits.error());
  return at_border(system, [&] {
    std::optional<System> own;  // its springs act, within a step, as at the step's start
    if (has_spring_events(system.parameters)) own = system;
    Run run(own ? *own : system, own ? &own->parameters : nullptr, state, settings, observer, **integrator,
            limits, samples);
    auto out = run.run();
    if (observer.ended) observer.ended(run.evaluations());
    return out;
  });
}

}  // namespace

Result<Trajectory> simulate(const System& system, const State& state, const SimulationSettings& settings,
                            const Observer& observer) {
  if (auto ok = check_state(system, state); !ok) return tl::unexpected(ok.error());
  if (auto ok = check_settings(settings, state.t); !ok) return tl::unexpected(ok.error());
  if (settings.accuracy == 0) return simulate_once(system, state, settings, observer, observer.limits);
  if (!observer.events.empty())
    return bad_use(
        "simulation, accuracy",
        "takes several runs, and a user's own events may change from one to the next; name a method and a "
        "tolerance instead");
  if (observer.keep || !observer.checkpoint.empty())
    return bad_use(
        "needs several runs, and a user's own events may change from one to the next; name a method and a "
        "tolerance instead",
        "needs several runs, which a checkpoint cannot store; name a method and a tolerance instead");
  bool stopped = false;
  Observer watched = observer;
  if (observer.progress)
    watched.progress = [&](double t) {
      stopped = !observer.progress(t);
      return !stopped;
    };
  const double most = observer.limits.evaluations;
  double spent = 0;
  long of_run = 0;
  watched.ended = [&](long evaluations) {
    of_run = evaluations;
    if (observer.ended) observer.ended(evaluations);
  };
  return run_to_accuracy(
      system, state.t, settings,
      [&](const SimulationSettings& chosen, RunLimits limits, Samples& samples) -> Result<Trajectory> {
        limits.evaluations = std::min(limits.evaluations, most - spent);
        const State from = limits.disturbance > 0 ? disturbed(system, state, limits.disturbance) : state;
        of_run = 0;
        auto made = simulate_once(system, from, chosen, watched, limits, &samples);
        samples.evaluations = of_run;
        spent += double(of_run);
        if (!(spent > most)) return made;
        stopped = true;
        return failure(system.scene, fmt::format("needs more than {:.2g} evaluations, the most allowed, for "
                                                 "an accuracy of {:.3g}; give a lower accuracy",
                                                 most, settings.accuracy));
      },
      [&] { return stopped; });
}

Result<Trajectory> simulate(const System& system) {
  return simulate(system, system.initial, system.settings);
}

}  // namespace borelli
