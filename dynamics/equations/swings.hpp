// Bodies that each turn alone on a hinge fixed in the world: the pendulum equation replaces the articulated
// bodies. One body per lane (articulated_side.hpp).
#pragma once

#include "dynamics/numbers/changes.hpp"
#include "dynamics/system/system.hpp"

namespace borelli {

/// Constants of a body that turns by q about an axis fixed in the world. Its acceleration is (cosine sin q -
/// sine cos q + effort) / meets. SI.
template <class T>
struct PendulumOf {
  T inertia;       ///< about the axis, kg m^2
  T meets;         ///< inertia plus armature
  T cosine, sine;  ///< potential energy: constant + cosine cos q + sine sin q, J
  bool sound;      ///< false: in some lane `meets` is negligible
};

/// `axis` (of unit length) and `gravity` in the axes of the body's frame at q = 0.
template <class T, class Inertia>
PendulumOf<T> find_pendulum(const Eigen::Vector3d& axis, const Eigen::Vector3d& gravity,
                            const Inertia& inertial, double armature) {
  const auto along = [](const Eigen::Vector3d& d, const Eigen::Vector3<T>& x) -> T {
    return d[0] * x[0] + d[1] * x[1] + d[2] * x[2];
  };
  const T mass = inertial.mass;
  const Eigen::Vector3<T>& c = inertial.centre;
  // gravity centre: fixed part + cos q (radial vector) + sin q ahead, about the axis
  const Eigen::Vector3<T> ahead(axis[1] * c[2] - axis[2] * c[1], axis[2] * c[0] - axis[0] * c[2],
                                axis[0] * c[1] - axis[1] * c[0]);
  PendulumOf<T> out;
  out.cosine = mass * (gravity.dot(axis) * along(axis, c) - along(gravity, c));
  out.sine = -mass * along(gravity, ahead);
  out.inertia = axis[0] * along(axis, inertial.tensor.col(0)) +
                axis[1] * along(axis, inertial.tensor.col(1)) +
                axis[2] * along(axis, inertial.tensor.col(2)) + mass * ahead.squaredNorm();
  out.meets = out.inertia + armature;
  // the same threshold as release_step (articulated_step.hpp)
  out.sound =
      everywhere(out.meets > 2e-14 * (armature + 0.5 * inertial.tensor.trace() + mass * c.squaredNorm()));
  return out;
}

class Swings {
 public:
  /// The only step and the only body of each tree.
  Swings(const AlikeTrees::Each& steps, const AlikeTrees::Each& bodies) : steps_(steps), bodies_(bodies) {}

  // Constants, from the parameters at the last update().
  Quad inertia;              ///< about the axis, kg m^2
  Quad inverse;              ///< 1 / (inertia + armature)
  bool sound = false;        ///< false: in some lane the inertia is negligible
  Quad level, cosine, sine;  ///< potential energy: level + cosine cos q + sine sin q, J

  // The current state.
  Quad cos_q, sin_q, u;

  /// Recomputes the constants if the parameters changed.
  void update(const Parameters& parameters) {
    if (changed(parameters)) [[unlikely]]
      find(parameters);
  }

 private:
  struct Numbers {
    Eigen::Vector3d axis;
    Pose placement;
    Inertial inertial;
    double armature;
  };
  bool changed(const Parameters& parameters) const {
    Changes changes;
    changes.add(parameters.gravity, gravity_);
    for (int lane = 0; lane < Quad::count; ++lane) {
      const Numbers& before = from_[lane];
      changes.add(std::get_if<Rotation>(&parameters.kinds[steps_[lane]])->axis, before.axis);
      changes.add(parameters.placements[steps_[lane]].X, before.placement);
      changes.add(parameters.inertials[bodies_[lane]], before.inertial);
      changes.add(parameters.armatures[steps_[lane]], before.armature);
    }
    return !found_ || changes.any();
  }

  void find(const Parameters& parameters);

  AlikeTrees::Each steps_, bodies_;
  bool found_ = false;
  Eigen::Vector3d gravity_;
  std::array<Numbers, Quad::count> from_;
};

}  // namespace borelli
