#include "dynamics/fastest_change.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace borelli {

namespace {

/// Visits the fields of an effort or constraint, or a drive's functions, and keeps the shortest period of
/// those of time.
struct Search {
  double span;
  std::string name;
  std::optional<FastestChange> found;

  void take(double period, const std::string& wave) {
    if (!found || period < found->period) found = FastestChange{name, wave, period};
  }
  void look(const Sine& sine) {
    if (sine.amplitude == 0 || sine.angular_frequency == 0) return;
    take(2 * M_PI / std::abs(sine.angular_frequency), "period");
  }
  void look(const Polynomial& polynomial) {
    std::size_t degree = polynomial.coefficients.size();
    while (degree > 0 && polynomial.coefficients[degree - 1] == 0) --degree;
    if (degree < 2) return;  // a constant
    --degree;
    take(2 * span / double(degree), fmt::format("shortest wave (a polynomial of degree {})", degree));
  }
  void look(const Table& table) {
    double shortest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 1; i < table.times.size(); ++i)
      shortest = std::min(shortest, table.times[i] - table.times[i - 1]);
    take(4 * shortest, "shortest wave (four intervals of its table)");
  }

  void operator()(std::string_view, const TimeFunction& f) {
    std::visit([this](const auto& function) { look(function); }, f);
  }
  void operator()(std::string_view field, const std::vector<TimeFunction>& functions) {
    for (const TimeFunction& f : functions) (*this)(field, f);
  }
  template <class T>
  void operator()(std::string_view, const T&) {}
};

}  // namespace

std::optional<FastestChange> fastest_change(const System& system, const Parameters& parameters, double span) {
  Search search{span, {}, {}};
  for (std::size_t d = 0; d < parameters.drives.size(); ++d) {
    search.name = fmt::format("driven coordinate '{}'", system.driven[d].name);
    for (const TimeFunction& f : parameters.drives[d].functions) search("function", f);
  }
  const auto look_into = [&](const char* what, const auto& things) {
    for (const auto& thing : things) {
      search.name = fmt::format("{} '{}'", what, thing.name);
      std::visit(
          [&]<class Kind>(const Kind& kind) {
            if constexpr (!std::is_same_v<Kind, CoordinateFunction>)  // no function of time
              kind.fields(kind, search);
          },
          thing.kind);
    }
  };
  look_into("effort", parameters.efforts);
  look_into("constraint", parameters.constraints);
  return search.found;
}

std::vector<char> groups_moved(const System& system, const Parameters& parameters) {
  std::vector<char> moved(system.groups, false);
  for (int d = 0; d < system.driven_nv; ++d) moved[system.velocity_groups[system.nv + d]] = true;
  for (std::size_t i = 0; i < parameters.constraints.size(); ++i)
    std::visit(
        [&]<class Kind>(const Kind& kind) {
          Search search{1, {}, {}};
          if constexpr (std::is_same_v<Kind, FunctionConstraint>) search.take(1, "");
          if constexpr (!std::is_same_v<Kind, CoordinateFunction>) kind.fields(kind, search);
          if (search.found) moved[system.constraints[i].group] = true;
        },
        parameters.constraints[i].kind);
  return moved;
}

}  // namespace borelli
