#include "dynamics/range_events.hpp"

#include <fmt/format.h>

#include "dynamics/rotation_vector.hpp"

namespace borelli {

namespace {

// the room that Range::holds leaves for a start on a bound, m or rad
constexpr double room = 1e-9;

}  // namespace

RangeEvents::RangeEvents(const System& system, Certifier& certifier)
    : system_(system), certifier_(certifier) {
  for (std::size_t i = 0; i < system.ranges.size(); ++i)
    for (std::size_t k = 0; k < system.ranges[i].ranges.size(); ++k) watched_.push_back({int(i), int(k)});
  outside_.resize(2 * watched_.size(), false);
  noted_.resize(watched_.size(), false);
}

void RangeEvents::evaluate(const State& state, const Kinematics&, std::span<EventValue> values) {
  for (std::size_t i = 0; i < watched_.size(); ++i) {
    const auto& limited = system_.ranges[watched_[i].coordinate];
    const Range& range = limited.ranges[watched_[i].component];
    const CoordinateInfo& info = system_.coordinates[limited.coordinate];
    double x, rate;
    if (info.q_size == 4) {
      const Eigen::Vector3d turn = logarithm(state.q.segment<4>(info.q_index));
      x = turn[watched_[i].component];
      rate = rotation_vector_rate(turn, state.v.segment<3>(info.v_index))[watched_[i].component];
    } else {
      x = state.q[info.q_index];
      rate = state.v[info.v_index];
    }
    values[2 * i] = {range.upper + room - x, -rate};
    values[2 * i + 1] = {x - range.lower + room, rate};
  }
}

Result<AfterEvent> RangeEvents::handle(std::span<const int> which, State& state, Workspace&,
                                       std::vector<LoggedEvent>& log) {
  for (int i : which) {
    const auto& limited = system_.ranges[watched_[i / 2].coordinate];
    const Range& range = limited.ranges[watched_[i / 2].component];
    const CoordinateInfo& info = system_.coordinates[limited.coordinate];
    const std::string axis =
        info.v_size == 1 ? "" : fmt::format(" about its {} axis", "xyz"[watched_[i / 2].component]);
    outside_[i] = !outside_[i];
    log.push_back({state.t, outside_[i] ? "range_left" : "range_entered",
                   fmt::format("coordinate '{}' {} {:.6g}{}", info.name, i % 2 == 0 ? "above" : "below",
                               i % 2 == 0 ? range.upper : range.lower, axis)});
    if (!outside_[i] || noted_[i / 2]) continue;
    noted_[i / 2] = true;
    certifier_.note(fmt::format(
        "coordinate '{}' left its range of {:.6g} to {:.6g}{} at t = {:.6g} s (ranges are not enforced)",
        info.name, range.lower, range.upper, axis, state.t));
  }
  return AfterEvent::go_on;
}

}  // namespace borelli
