#include "pipeline/report/range_warning.hpp"

#include <fmt/core.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <set>

#include "dynamics/run/range_events.hpp"

namespace borelli {
namespace {

// The bound that an event crossed, in the reader's units.
std::string in_words(const System& system, const RangeEnd& end) {
  const auto& limited = system.ranges[static_cast<std::size_t>(end.coordinate)];
  const CoordinateInfo& info = system.coordinates[static_cast<std::size_t>(limited.coordinate)];
  const Range& range = limited.ranges[static_cast<std::size_t>(end.component)];
  const double bound = end.upper ? range.upper : range.lower;
  // -0 becomes 0, also after rounding to the displayed tenth
  const double shown = (info.angle ? std::round(bound * 1800 / std::numbers::pi) / 10 : bound) + 0.0;
  return fmt::format("{} ({}{} {:g} {})", info.name,
                     info.v_size == 1 ? "" : fmt::format("about its {} axis, ", "xyz"[end.component]),
                     end.upper ? "above" : "below", shown, info.angle ? "deg" : "m");
}

}  // namespace

std::vector<std::string> warnings_of(const Certificate& certificate, const System& system) {
  std::set<int> left;  // indices into System::ranges
  std::optional<RangeEnd> first;
  double when = 0;
  for (const LoggedEvent& event : certificate.events) {
    if (event.kind != "range_left") continue;
    const auto end = range_end_named(system, event.name);
    if (!end) continue;
    left.insert(end->coordinate);
    if (!first) first = end, when = event.time;
  }
  std::vector<std::string> warnings;
  if (first)
    warnings.push_back(fmt::format(
        "{} usual range{}, {}{} at t = {:.3f} s; ranges are not enforced",
        left.size() == 1 ? "a joint leaves its" : fmt::format("{} joints leave their", left.size()),
        left.size() == 1 ? "" : "s", left.size() == 1 ? "" : "first ", in_words(system, *first), when));
  for (const std::string& note : certificate.notes)
    if (!first || !is_range_note(note)) warnings.push_back(note);
  return warnings;
}

}  // namespace borelli
