// Bodies that each turn alone about an axis at rest: the equation of a pendulum is all they need. As many at
// once as there are lanes (articulated_side.hpp).
#pragma once

#include "dynamics/system.hpp"

namespace borelli {

class Swings {
 public:
  /// The only step and the only body of each tree.
  Swings(const AlikeTrees::Each& steps, const AlikeTrees::Each& bodies) : steps_(steps), bodies_(bodies) {}

  // What does not change as they turn; of `parameters` at the last update().
  Quad inertia;              ///< about the axis, kg m^2
  Quad inverse;              ///< of what meets the coordinate, the rotor's armature among it
  bool sound = false;        ///< else it meets no inertia to speak of
  Quad level, cosine, sine;  ///< potential energy: level + cosine cos q + sine sin q, J

  // The state at hand.
  Quad cos_q, sin_q, u;

  /// Finds the constants where the parameters are not those that they were found from.
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
  using Words = Quad::Mask::Vector;

  /// To a bit, so that what is no number is seen too.
  template <class Value>
  static void compare(const Value& now, const Value& before, Words& differ, long long& rest) {
    constexpr int count = sizeof(Value) / sizeof(double);
    static_assert(sizeof(Value) == count * sizeof(double), "numbers alone, without gaps");
    const char *a = reinterpret_cast<const char*>(&now), *b = reinterpret_cast<const char*>(&before);
    int i = 0;
    for (; i + Quad::count <= count; i += Quad::count) {
      Words x, y;
      __builtin_memcpy(&x, a + i * sizeof(double), sizeof x);
      __builtin_memcpy(&y, b + i * sizeof(double), sizeof y);
      differ |= x ^ y;
    }
    for (; i < count; ++i) {
      long long x, y;
      __builtin_memcpy(&x, a + i * sizeof(double), sizeof x);
      __builtin_memcpy(&y, b + i * sizeof(double), sizeof y);
      rest |= x ^ y;
    }
  }

  bool changed(const Parameters& parameters) const {
    Words differ{};
    long long rest = !found_;
    compare(parameters.gravity, gravity_, differ, rest);
    for (int lane = 0; lane < Quad::count; ++lane) {
      const Numbers& before = from_[lane];
      compare(std::get_if<Rotation>(&parameters.kinds[steps_[lane]])->axis, before.axis, differ, rest);
      compare(parameters.placements[steps_[lane]].X, before.placement, differ, rest);
      compare(parameters.inertials[bodies_[lane]], before.inertial, differ, rest);
      compare(parameters.armatures[steps_[lane]], before.armature, differ, rest);
    }
    return rest != 0 || !Quad::Mask(differ == 0).all();
  }

  void find(const Parameters& parameters);

  AlikeTrees::Each steps_, bodies_;
  bool found_ = false;
  Eigen::Vector3d gravity_;
  std::array<Numbers, Quad::count> from_;
};

}  // namespace borelli
