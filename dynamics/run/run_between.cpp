// What happens within and after a run's steps: events, rows, samples.
#include <fmt/format.h>

#include <bit>

#include "dynamics/run/disturbance.hpp"
#include "dynamics/run/run.hpp"
#include "dynamics/run/settings_check.hpp"

namespace borelli {

namespace {

// Largest number of events without progress in time; larger than any chain of impacts in a scene.
constexpr int most_events_at_once = 1000;

// How many times a run is disturbed on its way.
constexpr std::size_t disturbances = 8;

}  // namespace

std::string Run::last_event_words() const {
  const auto& log = certifier_->events();
  return log.empty() ? "" : fmt::format(", the last of them {} at '{}'", log.back().kind, log.back().name);
}

Result<void> Run::pass_events(double h) {
  if (watch_->empty()) return {};
  watch_->begin_step();
  for (;;) {
    const auto found = watch_->find(path_, state_.t, h, landing_, between_);
    if (!found) return diverged(found.error());
    if (!*found) return {};
    // Record the rows before the event now, because the event may change what they depend on.
    if (auto done = record_between(h, between_.state.t); !done) return done;
    if (auto done = sample_between(h, between_.state.t); !done) return done;
    if (auto done = check_between(between_); !done) return done;
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

Result<void> Run::check_between(Landing& between) {
  const State& state = between.state;
  if (const Fault fault = accelerate(system_, system_.parameters, state.t, state.q.data(), state.v.data(),
                                     motion_.handling(), probe()))
    return diverged(describe(system_, fault, state.t));
  between.book_projection(probe());
  between.projected = false;  // not a second time if it becomes the step's end
  certifier_->observe(state, probe(), between.work);
  return {};
}

Result<void> Run::record_between(double h, double until) {
  if (settings_.output_interval <= 0) return {};
  for (; !outputs_.at_last() && outputs_.next_time() < until; outputs_.go_on()) {
    const double at = outputs_.next_time();
    if (auto done = path_.land((at - state_.t) / h, row_); !done) return diverged(done.error());
    row_.state.t = at;
    if (samples_) samples_->take(row_.state);
    if (auto done = check_between(row_); !done) return done;
    if (auto done = record(row_.state, probe(), row_.work); !done) return done;
  }
  return {};
}

Result<void> Run::sample_between(double h, double until) {
  if (!samples_) return {};
  for (double at = samples_->next(); at < until; at = samples_->next()) {
    if (auto done = path_.glance((at - state_.t) / h, row_); !done) return diverged(done.error());
    row_.state.t = at;
    samples_->take(row_.state);
  }
  return {};
}

void Run::disturb() {
  const bool conserves =
      work_.efforts == 0 && work_.drives == 0 && work_.constraints == 0 && work_.violation == 0;
  if (conserves || !samples_ || integrator_.keeps_history()) return;
  const std::size_t times = disturbances * samples_->q.size() / samples_->times.size();
  if (times == disturbed_) return;
  disturbed_ = times;
  state_ =
      disturbed(system_, state_, std::popcount(times) % 2 == 0 ? limits_.disturbance : -limits_.disturbance);
}

Result<void> Run::record_end() {
  const bool every_step = settings_.output_interval <= 0;
  const bool due = state_.t >= outputs_.next_time();
  if (due) outputs_.go_on();
  recorded_ = due || every_step || stopped_;
  if (!recorded_) return {};
  if (every_step && double(++rows_) > most_rows) return too_many("rows of output", most_rows);
  return record(state_, workspace_, work_);
}

Result<void> Run::record(const State& state, Workspace& workspace, const Work& work) {
  if (auto fits = recorder_.admit(); !fits) return diverged(fits.error());
  recorder_.record(state, workspace, work);
  return {};
}

}  // namespace borelli
