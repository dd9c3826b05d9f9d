#include "dynamics/run/event_watch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "dynamics/numbers/root.hpp"

namespace borelli {

namespace {

constexpr double none = 2;  // a theta beyond the step
constexpr double middle_of_step = 0.5;

// Events this close, in units of the time resolution, are simultaneous: rounding accumulates over steps, and
// bodies that fall alike must land together.
constexpr double together = 16;

int sign(double x) { return x > 0 ? 1 : x < 0 ? -1 : 0; }

// Fraction of the step: samples are no closer, unless a function may turn sharply.
constexpr double finest = 1. / 4096;

// Largest number of samples in a step, over all functions. Bodies that need more (passing through each other
// and back) cannot be resolved.
constexpr long most_samples = 1 << 15;

// Number of samples kept for other functions.
constexpr std::size_t kept_samples = 64;

// Speeds change between samples.
constexpr double allowance = 2;

/// Whether a function of known size is zero to rounding.
bool at_zero(const EventValue& value) {
  return std::isfinite(value.size) && std::abs(value.value) <= 1e-13 * value.size;
}

/// Bound on how far a function moves between two samples.
double reach(const EventValue& a, const EventValue& b, double time) {
  return allowance * time * std::max({a.speed, std::abs(a.rate), b.speed, std::abs(b.rate)});
}

/// The cubic through two values and rates, h apart, at s from 0 to 1.
struct Cubic {
  Cubic(const EventValue& a, const EventValue& b, double h)
      : c0(a.value),
        c1(a.rate * h),
        c2(3 * (b.value - a.value) - (2 * a.rate + b.rate) * h),
        c3(2 * (a.value - b.value) + (a.rate + b.rate) * h) {}
  double at(double s) const { return c0 + s * (c1 + s * (c2 + s * c3)); }
  /// Deviation from a sample in the middle: of the value, and of the rate over a quarter of the time.
  double off(const EventValue& middle, double h) const {
    return std::max(std::abs(at(0.5) - middle.value), std::abs(c1 + c2 + 0.75 * c3 - middle.rate * h) / 4);
  }
  /// The stationary point in the interior that is nearest to zero or farthest beyond it, seen from `side`;
  /// 0.5 if there is none.
  double lowest(int side) const {
    double best = 0.5;
    const double half = c2 / 3, root = half * half - c3 * c1 / 3;
    if (root < 0) return best;
    // Solves c1 + 2 c2 s + 3 c3 s^2 = 0 without cancellation.
    const double q = -(half + std::copysign(std::sqrt(root), half));
    for (const double s : {q / c3, c1 / (3 * q)})
      if (s > 0 && s < 1 && side * at(s) < side * at(best)) best = s;
    return best;
  }
  /// Whether the cubic stays on `side` between its ends, given its error `off` in the middle; elsewhere the
  /// error is taken as off * 16 s^2 (1 - s)^2.
  bool keeps(int side, double off) const {
    const auto beyond = [&](double s) { return side * at(s) <= 16 * s * s * (1 - s) * (1 - s) * off; };
    for (int k = 1; k < 16; ++k)
      if (beyond(k / 16.)) return false;
    return !beyond(lowest(side));  // it may dip briefly between those points
  }
  double c0, c1, c2, c3;
};

}  // namespace

EventWatch::EventWatch(const System& system, std::vector<EventSource*> sources)
    : system_(system), sources_(std::move(sources)) {
  int count = 0;
  for (EventSource* source : sources_) {
    first_.push_back(count);
    for (int i = 0; i < source->count(); ++i)
      watched_.push_back({.crossing = source->crossing(i), .side = 0});
    count += source->count();
  }
  if (count == 0) return;
  kinematics_.emplace(system);
  values_.resize(count);
  hits_.reserve(count);
  which_.reserve(count);
  ahead_.reserve(64);
  kept_.resize(count > 1 ? kept_samples : 0);
  for (Kept& kept : kept_) kept.values.resize(count);
}

void EventWatch::evaluate_at(const State& state) {
  update_kinematics(system_, system_.parameters, state.t, state.q.data(), state.v.data(), *kinematics_);
  evaluate(state, *kinematics_);
}

void EventWatch::evaluate(const State& state, const Kinematics& kinematics) {
  for (std::size_t s = 0; s < sources_.size(); ++s)
    sources_[s]->evaluate(state, kinematics, std::span(values_).subspan(first_[s], sources_[s]->count()));
}

void EventWatch::start(const State& state, const Kinematics& kinematics) {
  evaluate(state, kinematics);
  for (std::size_t i = 0; i < watched_.size(); ++i) {
    Watched& w = watched_[i];
    w.start = w.end = values_[i];
    w.side = sign(w.start.value) != 0 ? sign(w.start.value) : sign(w.start.rate);
    w.side_at_end = w.side;
  }
}

void EventWatch::begin_step() {
  end_known_ = false;
  samples_ = 0;
  kept_count_ = 0;
  for (Watched& w : watched_) {
    w.start = w.end;
    w.side = w.side_at_end;
    w.from = 0;
    w.searched = false;
  }
}

Result<bool> EventWatch::find(StepPath& path, double t, double h, const Landing& end, Landing& landing) {
  if (!end_known_) {
    end_known_ = true;
    resolution_ = 4 * std::numeric_limits<double>::epsilon() * std::max(1.0, std::abs(t) / h);
    evaluate_at(end.state);
    for (std::size_t i = 0; i < watched_.size(); ++i) {
      Watched& w = watched_[i];
      w.end = values_[i];
      w.fastest = std::abs(w.end.value - w.start.value) / h;
    }
    if (path.has_outline()) {
      if (auto done = path.outline(middle_of_step, landing); !done) return tl::unexpected(done.error());
      evaluate_at(landing.state);
      for (std::size_t i = 0; i < watched_.size(); ++i)
        watched_[i].fastest = std::max({watched_[i].fastest, values_[i].speed, std::abs(values_[i].rate)});
    }
  }
  double earliest = none;
  for (std::size_t i = 0; i < watched_.size(); ++i) {
    if (!watched_[i].searched)
      if (auto done = search(int(i), path, h, landing); !done) return tl::unexpected(done.error());
    watched_[i].searched = true;
    earliest = std::min(earliest, watched_[i].found);
  }
  if (earliest > 1) return false;
  hits_.clear();
  theta_ = earliest;
  for (std::size_t i = 0; i < watched_.size(); ++i)
    if (watched_[i].found <= earliest + together * resolution_) {
      hits_.push_back(int(i));
      theta_ = std::max(theta_, watched_[i].found);
    }
  if (auto done = path.land(theta_, landing); !done) return tl::unexpected(done.error());
  if (theta_ >= 1) landing.state.t = end.state.t;
  return true;
}

/// Samples one function in the rest of a step.
class EventWatch::Search {
 public:
  Search(EventWatch& watch, int i, StepPath& path, double h, Landing& landing)
      : watch_(watch), i_(i), path_(path), h_(h), landing_(landing) {}

  bool sample(double theta, EventValue& value) {
    for (std::size_t k = 0; k < watch_.kept_count_; ++k)
      if (watch_.kept_[k].theta == theta) {
        value = watch_.kept_[k].values[i_];
        return true;
      }
    if (++watch_.samples_ > most_samples) {
      error_ = {
          watch_.system_.scene,
          fmt::format("a step of {:.3g} s up to t = {:.6g} s passes contacts, stops or events more often "
                      "than {} checks can resolve; take shorter steps, unless the motion diverges",
                      h_, landing_.state.t, most_samples)};
      return false;
    }
    if (auto done = path_.land(theta, landing_); !done) {
      error_ = done.error();
      return false;
    }
    watch_.evaluate_at(landing_.state);
    value = watch_.values_[i_];
    if (watch_.kept_count_ < watch_.kept_.size()) {
      Kept& kept = watch_.kept_[watch_.kept_count_++];
      kept.theta = theta;
      std::copy(watch_.values_.begin(), watch_.values_.end(), kept.values.begin());
    }
    return true;
  }

  enum class Answer { found, none, failed };

  /// Starts from a sample at zero whose rate points to `side`. Finds a sample, no later than `end`, that has
  /// left zero without another zero between: the cubic between them rises, and a sample in the middle
  /// confirms it. None: the function does not leave zero.
  Answer leave(int side, const Look& from, const Look& end, Look& left) {
    left = end;
    for (;;) {
      const double part = left.theta - from.theta, time = part * h_,
                   least = 0.25 * side * from.value.rate * time;
      Look middle{from.theta + 0.5 * part, {}};
      if (0.5 * part < 4 * watch_.resolution_) return Answer::none;
      if (!sample(middle.theta, middle.value)) return Answer::failed;
      const Cubic cubic(from.value, left.value, time);
      const double off = cubic.off(middle.value, time);
      if (reach(from.value, left.value, time) <= 2 * left.value.size && side * left.value.value > least &&
          2 * side * middle.value.value > least && 8 * off < side * middle.value.value)
        return Answer::found;
      left = middle;
    }
  }

  /// Brackets the first zero between `before`, on `side`, and `end` by two samples, `before` and `after`.
  Answer passage(int side, Look& before, const Look& end, Look& after) {
    std::vector<Look>& ahead = watch_.ahead_;
    ahead.clear();
    ahead.push_back(end);
    while (!ahead.empty()) {
      const Look next = ahead.back();
      const double part = next.theta - before.theta, time = part * h_;
      const bool through = side * next.value.value < 0;
      const double reached = reach(before.value, next.value, time);
      // A long step may lead from one turning point to the next, so its rates alone do not bound the motion.
      // Without known rates, only the ends decide.
      const bool over_middle = reached > 0 && before.theta < middle_of_step && next.theta > middle_of_step;
      const double farthest =
          over_middle ? std::max(reached, allowance * time * watch_.watched_[i_].fastest) : reached;
      const bool near = std::abs(before.value.value) + std::abs(next.value.value) <= farthest;
      // The function may turn within less than the reach between the samples.
      const bool sharp = reached > 2 * next.value.size;
      if (part <= std::max(sharp ? 0 : finest, 8 * watch_.resolution_) || !near) {
        if (through) {
          after = next;
          return Answer::found;
        }
        before = next;
        ahead.pop_back();
        continue;
      }
      Look middle{before.theta + 0.5 * part, {}};
      if (!sample(middle.theta, middle.value)) return Answer::failed;
      if (sharp) {
        ahead.push_back(middle);
        continue;
      }
      const Cubic cubic(before.value, next.value, time);
      const double off = 4 * cubic.off(middle.value, time);
      if (through) {
        // Only one zero if the middle sample confirms the cubic.
        if (off > std::abs(before.value.value) + std::abs(next.value.value)) {
          ahead.push_back(middle);
        } else if (side * middle.value.value < 0) {
          after = middle;
          return Answer::found;
        } else {
          before = middle;
          after = next;
          return Answer::found;
        }
        continue;
      }
      if (side * middle.value.value >= 0) {
        if (cubic.keeps(side, off)) {
          before = next;
          ahead.pop_back();
          continue;
        }
        const double low = cubic.lowest(side);
        if (side * cubic.at(low) < -off) {  // the cubic crosses zero and returns: sample there
          middle.theta = before.theta + low * part;
          if (!sample(middle.theta, middle.value)) return Answer::failed;
        }
      }
      ahead.push_back(middle);
    }
    return Answer::none;
  }

  /// Locates the zero between two samples; theta is just after it.
  Answer moment(const Look& before, const Look& after, double& theta) {
    const auto value_at = [this](double at, double& y) {
      EventValue value;
      if (!sample(at, value)) return false;
      y = value.value;
      return true;
    };
    Root root;
    if (!find_root(value_at, before.theta, before.value.value, after.theta, after.value.value,
                   watch_.resolution_, root))
      return Answer::failed;
    theta = root.after;
    return Answer::found;
  }

  tl::unexpected<Error> failed() const { return tl::unexpected(error_); }

 private:
  EventWatch& watch_;
  int i_;
  StepPath& path_;
  double h_;
  Landing& landing_;
  Error error_;
};

/// Finds the first event of function i in the rest of the step.
Result<void> EventWatch::search(int i, StepPath& path, double h, Landing& landing) {
  using Answer = Search::Answer;
  Watched& w = watched_[i];
  w.found = none;
  Search search(*this, i, path, h, landing);
  const Look end{1, w.end};
  Look before{w.from, w.start};
  int side = w.side;
  const auto counts = [&] {
    return w.crossing == Crossing::both || (side > 0) == (w.crossing == Crossing::falling);
  };
  if (side * before.value.value <= 0 && side * before.value.rate > 0) {
    Look left;
    const Answer answer = search.leave(side, before, end, left);
    if (answer == Answer::failed) return search.failed();
    if (answer == Answer::found) before = left;
  }
  if (side * before.value.value <= 0 && side * end.value.value < 0 && counts()) {
    w.found = before.theta;  // it has not left zero
    return {};
  }
  for (;;) {
    Look after;
    const Answer answer = search.passage(side, before, end, after);
    if (answer == Answer::failed) return search.failed();
    if (answer == Answer::none) break;
    if (counts()) {
      if (search.moment(before, after, w.found) == Answer::failed) return search.failed();
      return {};
    }
    side = -side;
    before = after;
  }
  w.side_at_end = side;
  return {};
}

Result<AfterEvent> EventWatch::handle(Landing& landing, Workspace& workspace, std::vector<LoggedEvent>& log) {
  evaluate(landing.state, workspace.kinematics);
  for (int i : hits_) watched_[i].start = values_[i];
  kept_count_ = 0;
  AfterEvent after = AfterEvent::go_on;
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    which_.clear();
    for (int i : hits_)
      if (i >= first_[s] && i < first_[s] + sources_[s]->count()) which_.push_back(i - first_[s]);
    if (which_.empty()) continue;
    const auto answer = sources_[s]->handle(which_, landing.state, workspace, log);
    if (!answer) return answer;
    if (*answer == AfterEvent::restart) after = AfterEvent::restart;
  }
  if (after == AfterEvent::go_on) {
    for (int i : hits_) {
      Watched& w = watched_[i];
      w.side = -w.side;
      w.from = theta_;
      w.searched = false;
    }
    return after;
  }
  evaluate_at(landing.state);
  for (std::size_t i = 0; i < watched_.size(); ++i) {
    Watched& w = watched_[i];
    const EventValue before = w.start;
    w.start = w.end = values_[i];
    const bool hit = std::find(hits_.begin(), hits_.end(), int(i)) != hits_.end();
    const int value = sign(w.start.value), rate = sign(w.start.rate);
    const bool put_back = value * sign(before.value) < 0 && std::isfinite(w.start.size) && !at_zero(w.start);
    const bool changed = std::abs(w.start.value) > 2 * std::abs(before.value) || put_back;
    if (hit)  // at zero to rounding, unless the event changed it: its rate decides the side
      w.side = changed && value != 0 ? value : rate != 0 ? rate : -w.side;
    else if (at_zero(w.start) && rate != 0)  // another event released it
      w.side = rate;
    else if (w.found > 1 && value != 0)
      w.side = value;
    // A function whose event is still to come in this step keeps its side, despite rounding.
    w.side_at_end = w.side;
  }
  return after;
}

}  // namespace borelli
