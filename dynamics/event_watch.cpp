#include "dynamics/event_watch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "dynamics/root.hpp"

namespace borelli {

namespace {

constexpr double none = 2;  // a theta beyond the step

// Events that close, in parts of the resolution of time, are one: rounding adds up over steps, and what falls
// alike must land alike.
constexpr double together = 16;

int sign(double x) { return x > 0 ? 1 : x < 0 ? -1 : 0; }

/// Where a function that starts on `side` with these values and rates h apart may have been through zero and
/// back: it heads for zero at the start, away from it at the end, and the tangents meet beyond zero.
bool may_have_been_through(int side, const EventValue& start, const EventValue& end, double h) {
  if (side * start.rate >= 0 || side * end.rate <= 0) return false;
  const double time = (end.value - end.rate * h - start.value) / (start.rate - end.rate);
  return side * (start.value + start.rate * time) <= 0;
}

}  // namespace

EventWatch::EventWatch(const System& system, std::vector<EventSource*> sources)
    : system_(system), sources_(std::move(sources)), kinematics_(system) {
  int count = 0;
  for (EventSource* source : sources_) {
    first_.push_back(count);
    for (int i = 0; i < source->count(); ++i)
      watched_.push_back({.crossing = source->crossing(i), .side = 0});
    count += source->count();
  }
  values_.resize(count);
  hits_.reserve(count);
  which_.reserve(count);
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
    update_kinematics(system_, system_.parameters, end.state.t, end.state.q.data(), end.state.v.data(),
                      kinematics_);
    evaluate(end.state, kinematics_);
    for (std::size_t i = 0; i < watched_.size(); ++i) watched_[i].end = values_[i];
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

/// Finds the first event of function i in what is left of the step.
Result<void> EventWatch::search(int i, StepPath& path, double h, Landing& landing) {
  Watched& w = watched_[i];
  w.found = none;
  Error error;
  const auto at = [&](double theta, EventValue& value) {
    if (auto done = path.land(theta, landing); !done) {
      error = done.error();
      return false;
    }
    const State& state = landing.state;
    update_kinematics(system_, system_.parameters, state.t, state.q.data(), state.v.data(), kinematics_);
    evaluate(state, kinematics_);
    value = values_[i];
    return true;
  };
  const auto value_at = [&](double theta, double& y) {
    EventValue value;
    if (!at(theta, value)) return false;
    y = value.value;
    return true;
  };
  const auto rate_at = [&](double theta, double& y) {
    EventValue value;
    if (!at(theta, value)) return false;
    y = value.rate;
    return true;
  };

  struct Point {
    double theta, value;
  };
  Point points[3] = {{w.from, w.start.value}};
  int count = 1, side = w.side;
  const bool crossed = side * w.end.value < 0;
  // of a function that starts at zero, or beyond it by rounding, the turning point tells whether it left at
  // all
  if (w.start.rate * w.end.rate < 0 &&
      (crossed ? side * w.start.value <= 0 : may_have_been_through(side, w.start, w.end, (1 - w.from) * h))) {
    Root turn;
    if (!find_root(rate_at, w.from, w.start.rate, 1, w.end.rate, std::sqrt(resolution_), turn))
      return tl::unexpected(error);
    Point point{turn.after, 0};
    if (!value_at(point.theta, point.value)) return tl::unexpected(error);
    points[count++] = point;
  }
  points[count++] = {1, w.end.value};
  for (int k = 1; k < count; ++k) {
    const Point &before = points[k - 1], &after = points[k];
    if (side * after.value >= 0) continue;
    if (w.crossing == Crossing::both || (side > 0) == (w.crossing == Crossing::falling)) {
      if (side * before.value <= 0) {
        w.found = before.theta;  // it never left zero
        return {};
      }
      Root root;
      if (!find_root(value_at, before.theta, before.value, after.theta, after.value, resolution_, root))
        return tl::unexpected(error);
      w.found = root.after;
      return {};
    }
    side = -side;
  }
  w.side_at_end = side;
  return {};
}

Result<AfterEvent> EventWatch::handle(Landing& landing, Workspace& workspace, std::vector<LoggedEvent>& log) {
  evaluate(landing.state, workspace.kinematics);
  for (int i : hits_) watched_[i].start = values_[i];
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
  const State& state = landing.state;
  update_kinematics(system_, system_.parameters, state.t, state.q.data(), state.v.data(), kinematics_);
  evaluate(state, kinematics_);
  for (std::size_t i = 0; i < watched_.size(); ++i) {
    Watched& w = watched_[i];
    const EventValue before = w.start;
    w.start = w.end = values_[i];
    const bool hit = std::find(hits_.begin(), hits_.end(), int(i)) != hits_.end();
    const int value = sign(w.start.value), rate = sign(w.start.rate);
    if (hit)  // at zero to rounding, unless the event changed it: it is where it goes
      w.side = std::abs(w.start.value) > 2 * std::abs(before.value) && value != 0 ? value
               : rate != 0                                                        ? rate
                                                                                  : -w.side;
    else if (w.found > 1 && value != 0)
      w.side = value;
    // one that is still to come in this step keeps its side, whatever rounding says
    w.side_at_end = w.side;
  }
  return after;
}

}  // namespace borelli
