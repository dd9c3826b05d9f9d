#include "dynamics/spring_events.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "dynamics/effort.hpp"
#include "dynamics/rotation_vector.hpp"
#include "dynamics/scan.hpp"

namespace borelli {

namespace {

// room for a start on a bound, m or rad: a spring pressed in by that little pushes with nothing to speak of
constexpr double room = 1e-9;

// rad: by so much a torsion spring may turn in one step, less than a half
constexpr double largest_turn = 2;

const LimitSpring& spring_of(const Parameters& parameters, std::size_t effort) {
  return std::get<LimitSpring>(parameters.efforts[effort].kind);
}

}  // namespace

SpringEvents::SpringEvents(const System& system, const Parameters& parameters)
    : system_(system), parameters_(parameters) {
  for (std::size_t e = 0; e < parameters.efforts.size(); ++e) {
    if (const auto* stop = std::get_if<LimitSpring>(&parameters.efforts[e].kind))
      for (std::size_t c = 0; c < stop->range.size(); ++c) bounds_.push_back({e, int(c)});
    if (const auto* torsion = std::get_if<TorsionSpring>(&parameters.efforts[e].kind))
      if (torsion->stiffness != 0) turns_.push_back({e});
  }
}

std::pair<double, double> SpringEvents::at(const Bound& bound, const Kinematics& kinematics) const {
  enum { on_coordinate };
  SiteReader<double> reader(system_, parameters_, kinematics);
  reader.turn_to(system_.efforts[bound.effort]);
  if (spring_of(parameters_, bound.effort).range.size() == 1)
    return {reader.position(on_coordinate), reader.rate(on_coordinate)};
  const Eigen::Vector3d turn = logarithm(reader.turn(on_coordinate));
  return {turn[bound.component],
          rotation_vector_rate(turn, reader.turn_rate(on_coordinate))[bound.component]};
}

EventValue SpringEvents::bound_value(int i, const Kinematics& kinematics) const {
  const Bound& bound = bounds_[i / 2];
  const Range& range = spring_of(parameters_, bound.effort).range[bound.component];
  const auto [x, rate] = at(bound, kinematics);
  const EventValue value =
      i % 2 == 0 ? EventValue{range.upper + room - x, -rate} : EventValue{x - range.lower + room, rate};
  return std::isfinite(value.value) ? value : EventValue{1, 0};  // no bound
}

Quaternion SpringEvents::turned(const Turn& turn, const Kinematics& kinematics) const {
  SiteReader<double> reader(system_, parameters_, kinematics);
  reader.turn_to(system_.efforts[turn.effort]);
  const Quaternion theta = std::get<TorsionSpring>(parameters_.efforts[turn.effort].kind).turned(reader);
  return theta.dot(turn.from) < 0 ? Quaternion(-theta) : theta;
}

Eigen::Vector3d SpringEvents::turn_rate(const Turn& turn, const Kinematics& kinematics) const {
  enum { a_site, b_site };
  SiteReader<double> reader(system_, parameters_, kinematics);
  reader.turn_to(system_.efforts[turn.effort]);
  return reader.frame(a_site).R.transpose() *
         (reader.angular_velocity(a_site) - reader.angular_velocity(b_site));
}

void SpringEvents::evaluate(const State&, const Kinematics& kinematics, std::span<EventValue> values) {
  const int bounds = int(2 * bounds_.size());
  for (int i = 0; i < bounds; ++i) values[i] = bound_value(i, kinematics);
  for (std::size_t i = 0; i < turns_.size(); ++i) {
    const Quaternion theta = turned(turns_[i], kinematics);
    values[bounds + i] = {theta[0], -0.5 * theta.tail<3>().dot(turn_rate(turns_[i], kinematics))};
  }
}

void SpringEvents::follow(const Kinematics& kinematics) {
  for (Turn& turn : turns_) {
    turn.from = turned(turn, kinematics);
    turn.speed = turn_rate(turn, kinematics).norm();
  }
}

bool SpringEvents::turned_too_far(const Kinematics& after, double h) const {
  return std::any_of(turns_.begin(), turns_.end(), [&](const Turn& turn) {
    return h * std::max(turn.speed, turn_rate(turn, after).norm()) > largest_turn;
  });
}

Result<AfterEvent> SpringEvents::handle(std::span<const int> which, State& state, Workspace& workspace,
                                        std::vector<LoggedEvent>& log) {
  for (const int i : which) {
    if (const int turn = i - int(2 * bounds_.size()); turn >= 0) {
      log.push_back({state.t, "half_turn",
                     fmt::format("effort '{}' turns round", parameters_.efforts[turns_[turn].effort].name)});
      continue;
    }
    const Bound& bound = bounds_[i / 2];
    const auto& spring = spring_of(parameters_, bound.effort);
    log.push_back(
        {state.t, bound_value(i, workspace.kinematics).rate < 0 ? "stop_reached" : "stop_left",
         fmt::format(
             "effort '{}' {} {:.6g}{}", parameters_.efforts[bound.effort].name,
             i % 2 == 0 ? "above" : "below",
             i % 2 == 0 ? spring.range[bound.component].upper : spring.range[bound.component].lower,
             spring.range.size() == 1 ? "" : fmt::format(" about its {} axis", "xyz"[bound.component]))});
  }
  return AfterEvent::restart;
}

}  // namespace borelli
