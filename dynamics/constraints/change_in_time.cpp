#include "dynamics/constraints/change_in_time.hpp"

#include <cmath>

#include "dynamics/system/fastest_change.hpp"
#include "dynamics/system/knots.hpp"

namespace borelli {

ChangeInTime change_in_time(const System& system, double t) {
  const auto fastest = fastest_change(system, system.parameters, 1, true);
  if (!fastest) return {};
  ChangeInTime out{fastest->name, {}};
  for (const double part : {0.137, 0.382, 0.618, 3.82, 61.8}) out.times.push_back(t + part * fastest->period);
  constexpr int most_knots = 16;
  const Knots knots(system, system.parameters);
  double knot = t;
  for (int i = 0; i < most_knots && std::isfinite(knot = knots.after(knot)); ++i) out.times.push_back(knot);
  return out;
}

}  // namespace borelli
