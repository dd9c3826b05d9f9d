// How a run makes its steps: fixed ones, adaptive ones, and when a step is made again.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dynamics/run/run.hpp"
#include "dynamics/run/settings_check.hpp"

namespace borelli {

namespace {

// After a step that was too long for a function of a coordinate, steps grow by at most this factor.
constexpr double growth_after_feature = 1.5;

}  // namespace

Result<void> Run::advance_evenly(double target) {
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

Result<bool> Run::try_evenly(double end, double h) {
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

Result<void> Run::advance_adaptively(double target) {
  const double resolution = 16 * std::numeric_limits<double>::epsilon() *
                            std::max(std::abs(settings_.end_time), std::abs(state_.t));
  if (limits_.own_first_step && attempts_ == 0)
    if (const double h = integrator_.first_step(motion_, state_.t, y_, dy_); h > 0) step_ = h;
  const double share = limits_.step_share;
  // Between knots, steps otherwise take all of the time or half of it.
  const double longest =
      share < 1 ? share * (target - state_.t) / 2 : std::numeric_limits<double>::infinity();
  while (state_.t < target && !stopped_) {
    const double wanted = step_;
    const double bounded = change_.bounded(step_, share);
    step_ = std::min(bounded, longest);
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
    if (samples_) {
      ++samples_->steps;
      // (the run's end is no feature that steps must resolve)
      samples_->cut_steps +=
          !cut && h < wanted * (1 - 1e-9) && (bounded < wanted || target < settings_.end_time);
    }
    if (auto done = accept(end, made, whole || cut); !done) return done;
    if (auto done = follow_steps(attempt); !done) return done;
  }
  return {};
}

int Run::worst_of(const Attempt& attempt) const {
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

Result<void> Run::follow_steps(const Attempt& attempt) {
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

Result<void> Run::land(double t, double h) {
  path_.begin(state_.t, h, y_, dy_, out_, work_);
  if (auto done = path_.land_at_end(t, landing_); !done) return diverged(done.error());
  return {};
}

bool Run::too_long(double h) {
  const State& end = landing_.state;
  if (!landing_.projected) {
    if (update_energies(system_, system_.parameters, end.t, end.q.data(), end.v.data(), probe())) return true;
    energy_ = probe().terms.group_kinetic + probe().terms.group_potential;
  }
  return certifier_->too_long(h, *integrator_.contact_step(),
                              landing_.projected ? landing_.projection.energy_before : energy_,
                              landing_.work);
}

std::string Run::passes_over_function() {
  if (functions_.empty()) return "";
  update_kinematics(system_, system_.parameters, state_.t, state_.q.data(), state_.v.data(),
                    probe().kinematics);
  return functions_.passed_over(probe().kinematics, landed(landing_.state));
}

bool Run::passes_over_springs(double h) {
  if (!springs_ || !springs_->any_turns()) return false;
  return springs_->turned_too_far(landed(landing_.state), h);
}

Result<void> Run::check_bounds() {
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

}  // namespace borelli
