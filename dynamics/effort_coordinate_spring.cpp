#include "dynamics/effort_coordinate_spring.hpp"

#include "dynamics/scan.hpp"

namespace borelli {

void CoordinateSpring::apply(EffortScan& scan) const {
  enum { on_coordinate };
  const double stretch = scan.position(on_coordinate) - rest, rate = scan.rate(on_coordinate);
  scan.coordinate(on_coordinate, -stiffness * stretch - damping * rate);
  scan.potential(0.5 * stiffness * stretch * stretch);
  scan.power(-damping * rate * rate);
}

}  // namespace borelli
