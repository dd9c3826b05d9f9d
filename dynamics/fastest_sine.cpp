#include "dynamics/fastest_sine.hpp"

#include <fmt/format.h>

#include <cmath>

namespace borelli {

namespace {

/// Visits the fields of an effort or constraint, or a drive's functions, and keeps the shortest period.
struct Search {
  std::string name;
  std::optional<FastestSine> found;

  void operator()(std::string_view, const TimeFunction& f) {
    const auto* sine = std::get_if<Sine>(&f);
    if (!sine || sine->amplitude == 0 || sine->angular_frequency == 0) return;
    const double period = 2 * M_PI / std::abs(sine->angular_frequency);
    if (!found || period < found->period) found = FastestSine{name, period};
  }
  void operator()(std::string_view field, const std::vector<TimeFunction>& functions) {
    for (const TimeFunction& f : functions) (*this)(field, f);
  }
  template <class T>
  void operator()(std::string_view, const T&) {}
};

}  // namespace

std::optional<FastestSine> fastest_sine(const System& system, const Parameters& parameters) {
  Search search;
  for (std::size_t d = 0; d < parameters.drives.size(); ++d) {
    search.name = fmt::format("driven coordinate '{}'", system.driven[d].name);
    for (const TimeFunction& f : parameters.drives[d].functions) search("function", f);
  }
  const auto look_into = [&](const char* what, const auto& things) {
    for (const auto& thing : things) {
      search.name = fmt::format("{} '{}'", what, thing.name);
      std::visit([&](const auto& kind) { kind.fields(kind, search); }, thing.kind);
    }
  };
  look_into("effort", parameters.efforts);
  look_into("constraint", parameters.constraints);
  return search.found;
}

}  // namespace borelli
