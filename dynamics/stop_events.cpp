#include "dynamics/stop_events.hpp"

#include <fmt/format.h>

#include "dynamics/effort.hpp"
#include "dynamics/rotation_vector.hpp"
#include "dynamics/scan.hpp"

namespace borelli {

namespace {

// room for a start on a bound, m or rad: a spring pressed in by that little pushes with nothing to speak of
constexpr double room = 1e-9;

const LimitSpring& spring_of(const Parameters& parameters, std::size_t effort) {
  return std::get<LimitSpring>(parameters.efforts[effort].kind);
}

}  // namespace

StopEvents::StopEvents(const System& system, const Parameters& parameters)
    : system_(system), parameters_(parameters) {
  for (std::size_t e = 0; e < parameters.efforts.size(); ++e)
    if (const auto* spring = std::get_if<LimitSpring>(&parameters.efforts[e].kind))
      for (std::size_t c = 0; c < spring->range.size(); ++c) watched_.push_back({e, int(c)});
}

std::pair<double, double> StopEvents::at(const Watched& watched, const Kinematics& kinematics) const {
  enum { on_coordinate };
  SiteReader<double> reader(system_, parameters_, kinematics);
  reader.turn_to(system_.efforts[watched.effort]);
  if (spring_of(parameters_, watched.effort).range.size() == 1)
    return {reader.position(on_coordinate), reader.rate(on_coordinate)};
  const Eigen::Vector3d turn = logarithm(reader.turn(on_coordinate));
  return {turn[watched.component],
          rotation_vector_rate(turn, reader.turn_rate(on_coordinate))[watched.component]};
}

EventValue StopEvents::value(int i, const Kinematics& kinematics) const {
  const Watched& watched = watched_[i / 2];
  const Range& range = spring_of(parameters_, watched.effort).range[watched.component];
  const auto [x, rate] = at(watched, kinematics);
  const EventValue value =
      i % 2 == 0 ? EventValue{range.upper + room - x, -rate} : EventValue{x - range.lower + room, rate};
  return std::isfinite(value.value) ? value : EventValue{1, 0};  // no bound
}

void StopEvents::evaluate(const State&, const Kinematics& kinematics, std::span<EventValue> values) {
  for (int i = 0; i < count(); ++i) values[i] = value(i, kinematics);
}

Result<AfterEvent> StopEvents::handle(std::span<const int> which, State& state, Workspace& workspace,
                                      std::vector<LoggedEvent>& log) {
  for (const int i : which) {
    const Watched& watched = watched_[i / 2];
    const auto& spring = spring_of(parameters_, watched.effort);
    log.push_back(
        {state.t, value(i, workspace.kinematics).rate < 0 ? "stop_reached" : "stop_left",
         fmt::format(
             "effort '{}' {} {:.6g}{}", parameters_.efforts[watched.effort].name,
             i % 2 == 0 ? "above" : "below",
             i % 2 == 0 ? spring.range[watched.component].upper : spring.range[watched.component].lower,
             spring.range.size() == 1 ? "" : fmt::format(" about its {} axis", "xyz"[watched.component]))});
  }
  return AfterEvent::restart;
}

}  // namespace borelli
