#include "dynamics/run/run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dynamics/contacts/put_apart.hpp"
#include "dynamics/run/settings_check.hpp"

namespace borelli {

namespace {

// Tolerated deviation of a function of a coordinate from what the ends of a step predict: in tolerances, or,
// without a tolerance, relative to its constraint's size.
constexpr double features_in_tolerances = 10, least_feature = 1e-3;

// A stiff run is abandoned if its rest needs this multiple of the steps tried so far. The next method must
// repeat the whole run, twice.
constexpr double worth_leaving = 1.5;

/// The number of rows to reserve, including the start. The number of adaptive steps is unknown.
std::size_t expected_rows(double start, const SimulationSettings& s, bool adaptive) {
  constexpr std::size_t adaptive_steps = 1024;
  if (s.output_interval > 0) return std::size_t(OutputTimes(start, s).count()) + 1;
  if (adaptive) return adaptive_steps;
  return std::size_t(std::ceil((s.end_time - start) / s.step)) + 2;  // rounding may add a step
}

}  // namespace

Run::Run(const System& system, Parameters* own, const State& state, const SimulationSettings& settings,
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
      change_(system, system.parameters, settings.end_time - state.t, !integrator.adaptive()),
      knots_(system, system.parameters),
      leaps_(settings.tolerance),
      functions_(system, system.parameters,
                 integrator.adaptive() ? features_in_tolerances * settings.tolerance : least_feature),
      outputs_(state.t, settings) {
  workspace_.leaves_contacts = integrator.handles_contacts();
  if (probe_) probe_->leaves_contacts = workspace_.leaves_contacts;
}

Result<Trajectory> Run::run() {
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
  const double end = settings_.end_time, interval = settings_.output_interval;
  // Fixed steps are equalised between outputs if there is at least one step between them.
  const bool between = integrator_.dense_suffices() && (integrator_.adaptive() || interval < settings_.step);
  if (!observer_.checkpoint.empty())
    if (auto done = read_checkpoint(observer_.checkpoint, signature(), [&](Keeper& k) { keep(k, ranges); });
        !done)
      return tl::unexpected(done.error());
  ranges_ = &ranges;
  while (!outputs_.done() && !stopped_ && end > start_state_.t) {
    const double target = between ? end : outputs_.next_time();
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

const Kinematics& Run::landed(const State& state) {
  if (!landed_) landed_.emplace(system_);
  update_kinematics(system_, system_.parameters, state.t, state.q.data(), state.v.data(), *landed_);
  return *landed_;
}

Result<void> Run::begin_step() {
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
    work_.add_event(workspace_.terms.group_kinetic + workspace_.terms.group_potential - energy_before_event_);
    certifier_->pass_event(workspace_, !observer_.events.empty());
    event_passed_ = false;
  }
  certifier_->observe(state_, workspace_, work_);
  if (!integrator_.adaptive()) observe_step(joined);
  if (probe_) probe_->solver.remember(workspace_.solver);
  if (contacts_) contacts_->follow(workspace_);
  return {};
}

void Run::observe_step(bool joined) {
  const Eigen::VectorXd* within = nullptr;
  if (const auto at = joined ? certifier_->step_watch().within_turn(state_) : std::nullopt)
    if (!accelerate(system_, system_.parameters, at->t, at->q.data(), at->v.data(), motion_.handling(),
                    probe()))
      within = &probe().a;
  certifier_->observe_step(state_, workspace_.a, integrator_.order(), joined, within);
}

Result<void> Run::accept(double t, double h, bool whole) {
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
    change_.take_step(from, made);
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
      fmt::format("stopped on request at t = {:.6g} s of {:.6g} s", state_.t, settings_.end_time), state_.t);
  return recorded_ ? Result<void>() : record(state_, workspace_, work_);
}

const char* Run::equations_name() const {
  return settings_.equations == Equations::lagrange ? "lagrange" : "recursive";
}

void Run::show_rows() {
  Certificate certificate;
  certificate.reason = fmt::format("the run was interrupted; this is its state at t = {:.6g} s of {:.6g} s",
                                   state_.t, settings_.end_time);
  certificate.reason_time = state_.t;
  certificate.method = settings_.method;
  certificate.equations = equations_name();
  observer_.rows(recorder_.so_far(std::move(certificate)));
}

bool Run::keep(Keeper& k, RangeEvents& ranges) {
  k(state_.t, state_.q, state_.v, work_, y_, dy_, out_, step_, sink_, change_, attempts_, rows_,
    follow_function_, stiff_, keeping_, last_event_, events_at_once_, motion_, workspace_, probe(), leaps_,
    *certifier_, recorder_, *watch_, ranges);
  outputs_.keep(k);
  even_.keep(k, start_state_.t, settings_);
  if (contacts_) k(*contacts_);
  if (springs_) k(*springs_);
  return integrator_.keep(k);
}

tl::unexpected<Error> Run::diverged(const Error& error) const {
  return failure(error.where, fmt::format("{}; the run ends at t = {:.9g} s of {:.6g} s", error.what,
                                          state_.t, settings_.end_time));
}

tl::unexpected<Error> Run::too_many(const char* what, double most) const {
  return failure(
      system_.scene,
      fmt::format("the run needed more than {:.0e} {} to reach t = {:.9g} s of {:.6g} s; shorten the run{}",
                  most, what, state_.t, settings_.end_time,
                  settings_.output_interval > 0 ? "" : ", or set an output_interval"));
}

void Run::judge_steps() {
  if (leaps_.count() > 0)
    certifier_->note(
        fmt::format("{} steps were repeated with a shorter length, because constraint projection moved "
                    "their ends by more than {:g} times the tolerance",
                    leaps_.count(), ProjectionWatch::limit));
  change_.judge(*certifier_);
}

}  // namespace borelli
