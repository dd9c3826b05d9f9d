#include "dynamics/swings.hpp"

namespace borelli {

using Eigen::Vector3d;

void Swings::find(const Parameters& parameters) {
  found_ = sound = true;
  gravity_ = parameters.gravity;
  for (int lane = 0; lane < Quad::count; ++lane) {
    const int step = steps_[lane];
    const Numbers now{std::get<Rotation>(parameters.kinds[step]).axis, parameters.placements[step].X,
                      parameters.inertials[bodies_[lane]], parameters.armatures[step]};
    from_[lane] = now;
    const auto& [mass, centre, tensor] = now.inertial;
    // the gravity centre as it turns: still + cos q aside + sin q ahead, about the axis
    const Vector3d still = now.axis.dot(centre) * now.axis, aside = centre - still;
    const Vector3d ahead = now.axis.cross(centre);
    const Vector3d weight = mass * (now.placement.R.transpose() * gravity_);
    level.set(lane, -mass * gravity_.dot(now.placement.p) - weight.dot(still));
    cosine.set(lane, -weight.dot(aside));
    sine.set(lane, -weight.dot(ahead));
    const double about = now.axis.dot(tensor * now.axis) + mass * ahead.squaredNorm();
    const double meets = about + now.armature;
    inertia.set(lane, about);
    inverse.set(lane, 1 / meets);
    // as for any coordinate (articulated_step.hpp)
    if (!(meets > 2e-14 * (now.armature + 0.5 * tensor.trace() + mass * centre.squaredNorm()))) sound = false;
  }
}

}  // namespace borelli
