#include "dynamics/methods/integrator.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "dynamics/methods/collocation.hpp"
#include "dynamics/methods/embedded_runge_kutta.hpp"
#include "dynamics/methods/extrapolation.hpp"
#include "dynamics/methods/gauss_legendre.hpp"
#include "dynamics/methods/generalized_alpha.hpp"
#include "dynamics/methods/moreau.hpp"
#include "dynamics/methods/splitting.hpp"
#include "dynamics/methods/step_doubling.hpp"
#include "dynamics/methods/sundials_integrator.hpp"

namespace borelli {

namespace {

struct Choice {
  double tolerance, spectral_radius;
};

struct Method {
  const char* name;
  std::unique_ptr<Integrator> (*make)(const Choice& choice);
};

template <const Tableau& (*tableau)()>
std::unique_ptr<Integrator> fixed(const Choice&) {
  return std::make_unique<ExplicitRungeKutta>(tableau());
}

template <class Kind>
std::unique_ptr<Integrator> plain(const Choice&) {
  return std::make_unique<Kind>();
}

template <class Kind>
std::unique_ptr<Integrator> with_tolerance(const Choice& choice) {
  return std::make_unique<Kind>(choice.tolerance);
}

template <int order>
std::unique_ptr<Integrator> extrapolated(const Choice& choice) {
  return std::make_unique<Extrapolation>(choice.tolerance, order / 2);
}

template <int stages>
std::unique_ptr<Integrator> gauss(const Choice&) {
  return std::make_unique<GaussLegendre>(stages);
}

template <const EmbeddedTableau& (*tableau)()>
std::unique_ptr<Integrator> embedded(const Choice& choice) {
  return std::make_unique<EmbeddedRungeKutta>(tableau(), choice.tolerance);
}

constexpr Method methods[] = {
    {"euler", fixed<euler>},
    {"rk2", fixed<midpoint>},
    {"rk4", fixed<classical_runge_kutta>},
    {"rk4_adaptive",
     [](const Choice& choice) -> std::unique_ptr<Integrator> {
       return std::make_unique<StepDoubling>(classical_runge_kutta(), choice.tolerance);
     }},
    {"dopri5", embedded<dormand_prince_5>},
    {"dop853", embedded<dormand_prince_853>},
    {"gbs", with_tolerance<Extrapolation>},
    {"gbs4", extrapolated<4>},
    {"gbs6", extrapolated<6>},
    {"gbs8", extrapolated<8>},
    {"gauss16", with_tolerance<Collocation>},
    {"semi_implicit_euler", plain<SemiImplicitEuler>},
    {"verlet", plain<VelocityVerlet>},
    {"implicit_midpoint", gauss<1>},
    {"gauss4", gauss<2>},
    {"gauss6", gauss<3>},
    {"generalized_alpha",
     [](const Choice& choice) -> std::unique_ptr<Integrator> {
       return std::make_unique<GeneralizedAlpha>(choice.spectral_radius);
     }},
    {"moreau", plain<MoreauStepping>},
    {"cvode", with_tolerance<CvodeBdf>},
    {"arkode", with_tolerance<ArkodeDirk>},
};

}  // namespace

bool Integrator::prepare_dense(Flow& flow, double t, double h, const Eigen::VectorXd& y,
                               const Eigen::VectorXd& dy, const Eigen::VectorXd& out) {
  hermite_step_ = h;
  hermite_start_ = y;
  hermite_end_ = out;
  hermite_start_slope_ = dy;
  return flow.derivative(t + h, out, hermite_end_slope_);
}

void Integrator::interpolate(double theta, Eigen::VectorXd& y) const {
  const double s = theta, r = 1 - theta;
  y = r * r * (1 + 2 * s) * hermite_start_ + s * s * (1 + 2 * r) * hermite_end_ +
      hermite_step_ * s * r * (r * hermite_start_slope_ - s * hermite_end_slope_);
}

std::vector<std::string> integrator_names() {
  std::vector<std::string> names;
  for (const Method& method : methods) names.emplace_back(method.name);
  return names;
}

Result<std::unique_ptr<Integrator>> make_integrator(const std::string& name, double tolerance,
                                                    double spectral_radius) {
  for (const Method& method : methods)
    if (name == method.name) return method.make({tolerance, spectral_radius});
  return bad_use(fmt::format("method '{}'", name),
                 fmt::format("is unknown; choose from {}", fmt::join(integrator_names(), ", ")));
}

bool method_is_adaptive(const std::string& name) {
  const auto method = make_integrator(name, 1);
  return method && (*method)->adaptive();
}

}  // namespace borelli
