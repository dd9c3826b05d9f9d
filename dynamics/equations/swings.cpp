#include "dynamics/equations/swings.hpp"

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
    const Vector3d pull = now.placement.R.transpose() * gravity_;
    const auto swing = find_pendulum<double>(now.axis, pull, now.inertial, now.armature);
    level.set(lane, -now.inertial.mass * (gravity_.dot(now.placement.p) +
                                          pull.dot(now.axis) * now.axis.dot(now.inertial.centre)));
    cosine.set(lane, swing.cosine);
    sine.set(lane, swing.sine);
    inertia.set(lane, swing.inertia);
    inverse.set(lane, 1 / swing.meets);
    if (!swing.sound) sound = false;
  }
}

}  // namespace borelli
