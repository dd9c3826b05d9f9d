// Compliant joint limits: stiff springs with losses, without contact events.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "dynamics/numbers/rotation_vector.hpp"
#include "dynamics/scene/site.hpp"
#include "dynamics/scene/switch.hpp"

namespace borelli {

template <class T>
class EffortPass;

/// Beyond a bound by x, at the outward rate dx/dt, the coordinate is pushed back with stiffness x max(0, 1 +
/// dissipation dx/dt) (N or N m). The force begins at zero and never pulls (Hunt, Crossley, Coefficient of
/// restitution interpreted as damping in vibroimpact, J. Appl. Mech. 42, 1975, with exponent 1). A coordinate
/// that reaches a bound at the speed v leaves it at v (1 - 2/3 dissipation v + ...). The elastic part has the
/// potential stiffness x^2 / 2.
///
/// For a ball each component of its rotation vector theta has its bounds (see Switch::ranges). The transpose
/// of the map from angular velocity to dtheta/dt turns the forces on the components into a torque. The bounds
/// must exclude half a turn, where theta jumps.
struct LimitSpring {
  static constexpr std::string_view kind = "limit_spring";
  AnyCoordinate on;
  double stiffness = 0;      ///< N/m or N m/rad
  double dissipation = 0;    ///< s/m or s/rad
  std::vector<Range> range;  ///< one, or three for a ball; empty: those of the coordinate (compile() fills
                             ///< them in)

  /// Per range, whether the upper and the lower spring act. Set at the start of a step and kept through it,
  /// so that the step passes the bounds smoothly (SpringEvents). Empty: the position decides.
  std::vector<std::array<bool, 2>> held{};

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("on", self.on);
    visit("stiffness", self.stiffness);
    visit("dissipation", self.dissipation);
    visit("range", self.range);
  }

  std::string complaint() const {
    if (!(stiffness > 0)) return "its stiffness must be positive";
    if (!(dissipation >= 0)) return "its dissipation must not be negative";
    for (const Range& r : range)
      if (!(r.lower <= r.upper)) return "its range must give the smaller bound first";
    return "";
  }

  /// Completes and checks the ranges: `components` is the number of velocities of the coordinate, `own` are
  /// its ranges. Returns a complaint; empty: none.
  std::string settle(int components, const std::vector<Range>& own) {
    if (range.empty()) range = own;
    if (range.empty()) return "has no range, and neither has its coordinate; give one of them a range";
    if (int(range.size()) != components)
      return components == 1
                 ? "has three ranges, but its coordinate is not a ball; give one range"
                 : "has one range, but a ball needs three, one per component of its rotation vector";
    return "";
  }

  template <class T>
  void apply(EffortPass<T>& pass) const {
    enum { on_coordinate };
    if (range.size() == 1) {
      pass.coordinate(on_coordinate, push(pass, 0, pass.position(on_coordinate), pass.rate(on_coordinate)));
      return;
    }
    const Eigen::Vector3<T> theta = logarithm(pass.turn(on_coordinate));
    const Eigen::Vector3<T> rate = rotation_vector_rate(theta, pass.turn_rate(on_coordinate));
    Eigen::Vector3<T> effort;
    for (int i = 0; i < 3; ++i) effort[i] = push(pass, i, theta[i], rate[i]);
    // the map's transpose is the map at -theta
    pass.turning(on_coordinate, rotation_vector_rate(Eigen::Vector3<T>(-theta), effort));
  }

 private:
  template <class T>
  T push(EffortPass<T>& pass, int i, const T& x, const T& rate) const {
    const Range& bounds = range[i];
    if (!held.empty()) {
      const auto [upper, lower] = held[i];
      if (upper) return act(pass, T(x - bounds.upper), rate, rate);
      if (lower) return act(pass, T(x - bounds.lower), rate, T(-rate));
      return T(0);
    }
    const T zero(0);
    const T beyond = either(
        x > bounds.upper, [&] { return T(x - bounds.upper); },
        [&] {
          return either(
              x < bounds.lower, [&] { return T(x - bounds.lower); }, [&] { return zero; });
        });
    return act(pass, beyond, rate,
               either(
                   beyond < 0, [&] { return T(-rate); }, [&] { return rate; }));
  }

  template <class T>
  T act(EffortPass<T>& pass, const T& beyond, const T& rate, const T& outwards) const {
    const T loss = either(
        dissipation * outwards < -1, [] { return T(-1); }, [&] { return T(dissipation * outwards); });
    pass.potential(0.5 * stiffness * beyond * beyond);
    pass.power(-stiffness * beyond * rate * loss);
    return -stiffness * beyond * (1 + loss);
  }
};

}  // namespace borelli
