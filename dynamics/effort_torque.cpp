#include "dynamics/effort_torque.hpp"

#include "dynamics/scan.hpp"

namespace borelli {

void Torque::apply(EffortScan& scan) const {
  enum { on_site, reaction_site };
  const Eigen::Vector3d given =
      axes == Axes::solid ? Eigen::Vector3d(scan.frame(on_site).R * torque) : torque;
  const Eigen::Vector3d m = at(factor, scan.time()).value * given;
  scan.torque(on_site, m);
  scan.power(m.dot(scan.angular_velocity(on_site)));
  if (!reaction) return;
  scan.torque(reaction_site, -m);
  scan.power(-m.dot(scan.angular_velocity(reaction_site)));
}

}  // namespace borelli
