#include "dynamics/run/range_events.hpp"

#include <fmt/format.h>

#include "dynamics/numbers/rotation_vector.hpp"

namespace borelli {

namespace {

// The tolerance of Range::holds for a start on a bound, m or rad.
constexpr double range_room = 1e-9;

// The ending of every note about a range.
constexpr std::string_view not_enforced = "(ranges are not enforced)";

std::string axis_of(const CoordinateInfo& info, int component) {
  return info.v_size == 1 ? "" : fmt::format(" about its {} axis", "xyz"[component]);
}

}  // namespace

std::string range_end_name(const System& system, const RangeEnd& end) {
  const auto& limited = system.ranges[end.coordinate];
  const CoordinateInfo& info = system.coordinates[limited.coordinate];
  const Range& range = limited.ranges[end.component];
  return fmt::format("coordinate '{}' {} {:.6g}{}", info.name, end.upper ? "above" : "below",
                     end.upper ? range.upper : range.lower, axis_of(info, end.component));
}

std::optional<RangeEnd> range_end_named(const System& system, std::string_view name) {
  for (std::size_t i = 0; i < system.ranges.size(); ++i)
    for (std::size_t k = 0; k < system.ranges[i].ranges.size(); ++k)
      for (const bool upper : {false, true})
        if (const RangeEnd end{int(i), int(k), upper}; range_end_name(system, end) == name) return end;
  return std::nullopt;
}

bool is_range_note(std::string_view note) { return note.ends_with(not_enforced); }

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
    values[2 * i] = {range.upper + range_room - x, -rate};
    values[2 * i + 1] = {x - range.lower + range_room, rate};
  }
}

Result<AfterEvent> RangeEvents::handle(std::span<const int> which, State& state, Workspace&,
                                       std::vector<LoggedEvent>& log) {
  for (int i : which) {
    const auto& limited = system_.ranges[watched_[i / 2].coordinate];
    const Range& range = limited.ranges[watched_[i / 2].component];
    const CoordinateInfo& info = system_.coordinates[limited.coordinate];
    outside_[i] = !outside_[i];
    log.push_back(
        {state.t, outside_[i] ? "range_left" : "range_entered",
         range_end_name(system_, {watched_[i / 2].coordinate, watched_[i / 2].component, i % 2 == 0})});
    if (!outside_[i] || noted_[i / 2]) continue;
    noted_[i / 2] = true;
    certifier_.note(fmt::format("coordinate '{}' left its range of {:.6g} to {:.6g}{} at t = {:.6g} s {}",
                                info.name, range.lower, range.upper, axis_of(info, watched_[i / 2].component),
                                state.t, not_enforced));
  }
  return AfterEvent::go_on;
}

}  // namespace borelli
