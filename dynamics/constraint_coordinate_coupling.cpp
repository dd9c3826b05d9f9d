#include "dynamics/constraint_coordinate_coupling.hpp"

#include "dynamics/scan.hpp"

namespace borelli {

void CoordinateCoupling::evaluate(ConstraintScan& scan) const {
  const TimeValue asked = at(value, scan.time());
  double sum = 0;
  for (std::size_t i = 0; i < coordinates.size(); ++i) {
    sum += ratios[i] * scan.position(int(i));
    scan.coordinate(0, int(i), ratios[i]);
  }
  scan.residual(0, sum - asked.value, -asked.rate, -asked.acceleration);
}

}  // namespace borelli
