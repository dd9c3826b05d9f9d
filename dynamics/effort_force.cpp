#include "dynamics/effort_force.hpp"

#include "dynamics/scan.hpp"

namespace borelli {

void Force::apply(EffortScan& scan) const {
  enum { at_site, reaction_site };
  const Eigen::Vector3d given = axes == Axes::solid ? Eigen::Vector3d(scan.frame(at_site).R * force) : force;
  const Eigen::Vector3d f = borelli::at(factor, scan.time()).value * given;
  const MovingPoint point = scan.point(at_site, at.point);
  scan.force(at_site, point.p, f);
  scan.power(f.dot(point.v));
  if (!reaction) return;
  const MovingPoint other = scan.point(reaction_site, reaction->point);
  scan.force(reaction_site, other.p, -f);
  scan.power(-f.dot(other.v));
}

}  // namespace borelli
