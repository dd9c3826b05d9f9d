// A proportional-derivative controller that drives a coordinate to a target.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "dynamics/numbers/rotation_vector.hpp"
#include "dynamics/numbers/time_function.hpp"
#include "dynamics/scene/site.hpp"
#include "dynamics/scene/switch.hpp"

namespace borelli {

template <class T>
class EffortPass;

/// On a scalar coordinate: the generalised force kp (target - q) + kd (dtarget/dt - dq/dt). On a ball: R =
/// rotation(target) rotation(e), with e the rotation vector of the error (|e| <= pi, axes of the ball). The
/// torque is -kp e - kd (w - w_target); it jumps where |e| passes pi. The kp part has the potential kp e^2 /
/// 2. The work of a moving target and of kd counts as work of efforts.
struct PdController {
  static constexpr std::string_view kind = "pd_controller";
  AnyCoordinate on;
  double kp = 0;                                  ///< N/m or N m/rad
  double kd = 0;                                  ///< N s/m or N m s/rad
  std::vector<TimeFunction> target{constant(0)};  ///< m or rad; a ball has three: its rotation vector

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("on", self.on);
    visit("kp", self.kp);
    visit("kd", self.kd);
    visit("target", self.target);
  }

  std::string complaint() const {
    if (!(kp >= 0 && kd >= 0)) return "its gains kp and kd must not be negative";
    return "";
  }

  /// As LimitSpring::settle.
  std::string settle(int components, const std::vector<Range>& /*own*/) const {
    if (int(target.size()) == components) return "";
    return components == 1
               ? "has several targets, but its coordinate is not a ball; give one function of time"
               : "acts on a ball; give three targets, one per component of its rotation vector";
  }

  template <class T>
  void apply(EffortPass<T>& pass) const {
    enum { on_coordinate };
    if (target.size() == 1) {
      const TimeValue wanted = at(target[0], pass.time());
      const T off = pass.position(on_coordinate) - wanted.value, rate = pass.rate(on_coordinate);
      const T damper = -kd * (rate - wanted.rate);
      pass.coordinate(on_coordinate, -kp * off + damper);
      pass.potential(0.5 * kp * off * off);
      pass.power(damper * rate - kp * off * wanted.rate);
      return;
    }
    Eigen::Vector3d theta, theta_rate;
    for (int i = 0; i < 3; ++i) {
      const TimeValue wanted = at(target[i], pass.time());
      theta[i] = wanted.value;
      theta_rate[i] = wanted.rate;
    }
    const QuaternionOf<T> off = product(conjugate(exponential(theta)), pass.turn(on_coordinate));
    const Eigen::Vector3<T> e = logarithm(off), w = pass.turn_rate(on_coordinate);
    const Eigen::Vector3<T> wanted =
        rotation_matrix(off).transpose() *
        body_velocity(theta, theta_rate, Eigen::Vector3d::Zero())[0].template cast<T>();
    const Eigen::Vector3<T> damper = -kd * (w - wanted);
    pass.turning(on_coordinate, -kp * e + damper);
    pass.potential(0.5 * kp * e.squaredNorm());
    pass.power(damper.dot(w) - kp * e.dot(wanted));
  }
};

}  // namespace borelli
