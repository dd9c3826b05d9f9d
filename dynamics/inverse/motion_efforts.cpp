#include "dynamics/inverse/motion_efforts.hpp"

#include <algorithm>

namespace borelli {

using Eigen::Vector3d;
using Eigen::VectorXd;

MotionEfforts::MotionEfforts(const System& system)
    : system_(system),
      kinematics_(system, Equations::recursive),
      efforts_(system),
      articulation_(system),
      carried_(system.bodies.size()),
      generalised_(system.size()),
      needed_(system.nv) {}

const VectorXd& MotionEfforts::needed(const State& state, const VectorXd& a,
                                      const std::vector<SolidWrench>& wrenches) {
  return needed(system_.parameters, state, a, wrenches);
}

const VectorXd& MotionEfforts::needed(const Parameters& parameters, const State& state, const VectorXd& a,
                                      const std::vector<SolidWrench>& wrenches) {
  inverse_dynamics<double>(system_, parameters, parameters.inertials, state.t, state.q.data(), state.v.data(),
                           a.data(), kinematics_, efforts_, articulation_, generalised_.data());
  if (!wrenches.empty()) {
    update_kinematics(system_, parameters, state.t, state.q.data(), nullptr, kinematics_);
    for (auto& wrench : carried_) wrench.setZero();
    for (const SolidWrench& w : wrenches) {
      auto& sum = carried_[std::size_t(system_.solid_bodies[std::size_t(w.solid)])];
      sum.head<3>() += w.moment + w.point.cross(w.force);
      sum.tail<3>() += w.force;
    }
    for (std::size_t b = carried_.size() - 1; b > 0; --b) {
      const Body& body = system_.bodies[b];
      const Vector3d moment = carried_[b].head<3>(), force = carried_[b].tail<3>();
      for (int s = body.first_step; s < body.first_step + body.step_count; ++s) {
        const SwitchStep& step = system_.steps[std::size_t(s)];
        for (int u = step.u; u < step.u + step.nv; ++u) {
          const Vector3d angular = kinematics_.angular(u);
          const Vector3d linear = kinematics_.linear(u) - angular.cross(kinematics_.origin(u));
          generalised_[u] -= angular.dot(moment) + linear.dot(force);
        }
      }
      carried_[std::size_t(body.parent)] += carried_[b];
    }
  }
  needed_ = generalised_.head(system_.nv);
  return needed_;
}

}  // namespace borelli
