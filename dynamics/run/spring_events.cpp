#include "dynamics/run/spring_events.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "dynamics/equations/passes.hpp"
#include "dynamics/numbers/rotation_vector.hpp"

namespace borelli {

namespace {

// Tolerance for a start on a bound, m or rad; the force at this depth is negligible.
constexpr double spring_room = 1e-9;

// m or rad: accuracy to which a bound is located.
constexpr double spring_rounding = 1e-13;

// rad: largest turn of a torsion spring in one step, less than half a turn.
constexpr double largest_turn = 2;

const LimitSpring& spring_of(const Parameters& parameters, std::size_t effort) {
  return std::get<LimitSpring>(parameters.efforts[effort].kind);
}

}  // namespace

bool has_spring_events(const Parameters& parameters) {
  return std::any_of(parameters.efforts.begin(), parameters.efforts.end(), [](const Effort& effort) {
    return std::holds_alternative<LimitSpring>(effort.kind) ||
           std::holds_alternative<TorsionSpring>(effort.kind);
  });
}

SpringEvents::SpringEvents(const System& system, Parameters& parameters)
    : system_(system), parameters_(parameters) {
  for (std::size_t e = 0; e < parameters.efforts.size(); ++e) {
    if (auto* stop = std::get_if<LimitSpring>(&parameters.efforts[e].kind)) {
      for (std::size_t c = 0; c < stop->range.size(); ++c) bounds_.push_back({e, int(c)});
      stop->held.resize(stop->range.size());
    }
    if (const auto* torsion = std::get_if<TorsionSpring>(&parameters.efforts[e].kind))
      if (torsion->stiffness != 0) turns_.push_back({e});
  }
}

void SpringEvents::measure_bounds(const Kinematics& kinematics) {
  enum { on_coordinate };
  SiteReader<double> reader(system_, parameters_, kinematics);
  at_.clear();
  while (at_.size() < bounds_.size()) {  // the bounds of one spring are consecutive
    const std::size_t effort = bounds_[at_.size()].effort;
    reader.turn_to(system_.efforts[effort]);
    if (spring_of(parameters_, effort).range.size() == 1) {
      at_.emplace_back(reader.position(on_coordinate), reader.rate(on_coordinate));
      continue;
    }
    const Eigen::Vector3d turn = logarithm(reader.turn(on_coordinate));
    const Eigen::Vector3d rate = rotation_vector_rate(turn, reader.turn_rate(on_coordinate));
    for (std::size_t c = 0; c < spring_of(parameters_, effort).range.size(); ++c)
      at_.emplace_back(turn[Eigen::Index(c)], rate[Eigen::Index(c)]);
  }
}

EventValue SpringEvents::bound_value(int i) const {
  const Bound& bound = bounds_[i / 4];
  const LimitSpring& spring = spring_of(parameters_, bound.effort);
  const Range& range = spring.range[bound.component];
  const auto [x, rate] = at_[i / 4];
  const bool upper = i % 2 == 0;
  const EventValue left = upper ? EventValue{range.upper + spring_room - x, -rate}
                                : EventValue{x - range.lower + spring_room, rate};
  if (!std::isfinite(left.value)) return {1, 0};  // no bound
  if (i % 4 < 2) return left;
  return {left.value < 0 ? 1 - spring.dissipation * left.rate : 1, 0};
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
  measure_bounds(kinematics);
  for (int i = 0; i < first_turn(); ++i) values[i] = bound_value(i);
  for (std::size_t i = 0; i < turns_.size(); ++i) {
    const Quaternion theta = turned(turns_[i], kinematics);
    values[first_turn() + i] = {theta[0], -0.5 * theta.tail<3>().dot(turn_rate(turns_[i], kinematics))};
  }
}

void SpringEvents::follow(const Kinematics& kinematics) {
  measure_bounds(kinematics);
  for (std::size_t b = 0; b < bounds_.size(); ++b) {
    Bound& bound = bounds_[b];
    std::array<bool, 2>& acts = acting(bound);
    for (int side = 0; side < 2; ++side) {
      const EventValue left = bound_value(int(4 * b) + side);
      // Right at a bound, the rate decides the side.
      acts[side] = std::abs(left.value) > spring_rounding ? left.value < 0 : left.rate < 0;
      const double pushes = bound_value(int(4 * b) + 2 + side).value;
      if (std::abs(pushes) > 1e-6) bound.slack[side] = pushes < 0;  // otherwise as the event left it
    }
  }
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
  measure_bounds(workspace.kinematics);
  for (const int i : which) {
    if (const int turn = i - first_turn(); turn >= 0) {
      log.push_back(
          {state.t, "half_turn",
           fmt::format("effort '{}' passes half a turn", parameters_.efforts[turns_[turn].effort].name)});
      continue;
    }
    Bound& bound = bounds_[i / 4];
    const auto& spring = spring_of(parameters_, bound.effort);
    const bool upper = i % 2 == 0, of_bound = i % 4 < 2;
    const EventValue left = bound_value(upper ? i / 4 * 4 : i / 4 * 4 + 1);
    if (!of_bound && left.value >= 0) continue;  // the bound itself is a separate event
    bool& slack = bound.slack[i % 2];
    slack = !of_bound && !slack;
    const char* kind =
        of_bound ? (left.rate < 0 ? "stop_reached" : "stop_left") : (slack ? "stop_slack" : "stop_taut");
    log.push_back(
        {state.t, kind,
         fmt::format(
             "effort '{}' {} {:.6g}{}", parameters_.efforts[bound.effort].name, upper ? "above" : "below",
             upper ? spring.range[bound.component].upper : spring.range[bound.component].lower,
             spring.range.size() == 1 ? "" : fmt::format(" about its {} axis", "xyz"[bound.component]))});
  }
  return AfterEvent::restart;
}

}  // namespace borelli
