// Visits the functions of time that a scene prescribes.
#pragma once

#include <fmt/format.h>

#include <string>

#include "dynamics/system/system.hpp"

namespace borelli {

/// Calls take(name of what it moves, function) for each field of a kind that is a function of time.
template <class Take>
struct TimeFunctionFields {
  const std::string& name;
  Take& take;

  void operator()(std::string_view, const TimeFunction& f) { take(name, f); }
  void operator()(std::string_view, const std::vector<TimeFunction>& functions) {
    for (const TimeFunction& f : functions) take(name, f);
  }
  template <class T>
  void operator()(std::string_view, const T&) {}

  template <class Kind>
  void of(const Kind& kind) {
    if constexpr (!std::is_same_v<Kind, CoordinateFunction>)  // a function of a coordinate, not of time
      kind.fields(kind, *this);
  }
};

/// Visits the functions of all drives, efforts and constraints, named like "effort 'push'". Changes in time
/// inside user C++ are unknown.
template <class Take>
void each_time_function(const System& system, const Parameters& parameters, Take&& take) {
  for (std::size_t d = 0; d < parameters.drives.size(); ++d) {
    const std::string name = fmt::format("driven coordinate '{}'", system.driven[d].name);
    for (const TimeFunction& f : parameters.drives[d].functions) take(name, f);
  }
  const auto visit_kinds = [&](const char* what, const auto& things) {
    for (const auto& thing : things) {
      const std::string name = fmt::format("{} '{}'", what, thing.name);
      std::visit([&](const auto& kind) { TimeFunctionFields<Take>{name, take}.of(kind); }, thing.kind);
    }
  };
  visit_kinds("effort", parameters.efforts);
  visit_kinds("constraint", parameters.constraints);
}

}  // namespace borelli
