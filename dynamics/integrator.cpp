#include "dynamics/integrator.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "dynamics/explicit_runge_kutta.hpp"
#include "dynamics/step_doubling.hpp"

namespace borelli {

namespace {

struct Method {
  const char* name;
  std::unique_ptr<Integrator> (*make)(double tolerance);
};

template <const Tableau& (*tableau)()>
std::unique_ptr<Integrator> fixed(double) {
  return std::make_unique<ExplicitRungeKutta>(tableau());
}

constexpr Method methods[] = {
    {"euler", fixed<euler>},
    {"rk2", fixed<midpoint>},
    {"rk4", fixed<classical_runge_kutta>},
    {"rk4_adaptive",
     [](double tolerance) -> std::unique_ptr<Integrator> {
       return std::make_unique<StepDoubling>(classical_runge_kutta(), tolerance);
     }},
};

}  // namespace

std::vector<std::string> integrator_names() {
  std::vector<std::string> names;
  for (const Method& method : methods) names.emplace_back(method.name);
  return names;
}

Result<std::unique_ptr<Integrator>> make_integrator(const std::string& name, double tolerance) {
  for (const Method& method : methods)
    if (name == method.name) return method.make(tolerance);
  return bad_use(fmt::format("method '{}'", name),
                 fmt::format("is not known; there are {}", fmt::join(integrator_names(), ", ")));
}

}  // namespace borelli
