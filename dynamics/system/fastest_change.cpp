#include "dynamics/system/fastest_change.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "dynamics/system/time_functions_of.hpp"

namespace borelli {

namespace {

/// Finds the shortest period of the given functions.
struct Search {
  double span;
  bool tables;
  std::string name = {};
  std::optional<FastestChange> found = {};

  void take(double period, const std::string& wave) {
    if (!found || period < found->period) found = FastestChange{name, wave, period};
  }
  void measure(const Sine& sine) {
    if (sine.amplitude == 0 || sine.angular_frequency == 0) return;
    take(2 * M_PI / std::abs(sine.angular_frequency), "period");
  }
  void measure(const Polynomial& polynomial) {
    std::size_t degree = polynomial.coefficients.size();
    while (degree > 0 && polynomial.coefficients[degree - 1] == 0) --degree;
    if (degree < 2) return;  // a constant
    --degree;
    take(2 * span / double(degree), fmt::format("shortest wave (a polynomial of degree {})", degree));
  }
  void measure(const Table& table) {
    if (!tables) return;
    double shortest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 1; i < table.times.size(); ++i)
      shortest = std::min(shortest, table.times[i] - table.times[i - 1]);
    take(4 * shortest, "shortest wave (four intervals of its table)");
  }
  void operator()(const std::string& of, const TimeFunction& f) {
    name = of;
    std::visit([this](const auto& function) { measure(function); }, f);
  }
};

}  // namespace

std::optional<FastestChange> fastest_change(const System& system, const Parameters& parameters, double span,
                                            bool tables) {
  Search search{span, tables};
  each_time_function(system, parameters, search);
  return search.found;
}

std::vector<char> groups_of_counted_work(const System& system, const Parameters& parameters) {
  std::vector<char> counted(system.groups, false);
  for (int d = 0; d < system.driven_nv; ++d) counted[system.velocity_groups[system.nv + d]] = true;
  for (std::size_t e = 0; e < parameters.efforts.size(); ++e)
    if (const auto* stop = std::get_if<LimitSpring>(&parameters.efforts[e].kind);
        stop && stop->dissipation > 0)
      counted[system.efforts[e].group] = true;
  for (std::size_t i = 0; i < parameters.constraints.size(); ++i)
    std::visit(
        [&]<class Kind>(const Kind& kind) {
          Search search{1, true};
          if constexpr (std::is_same_v<Kind, FunctionConstraint>) search.take(1, "");
          TimeFunctionFields<Search>{parameters.constraints[i].name, search}.of(kind);
          if (search.found) counted[system.constraints[i].group] = true;
        },
        parameters.constraints[i].kind);
  return counted;
}

}  // namespace borelli
