// The guided switch: a motion whose every part is a function of one coordinate (cam, knee, coupled joint).
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "dynamics/numbers/pose.hpp"
#include "dynamics/numbers/time_function.hpp"

namespace borelli {

/// A part of a guided motion: a rotation about an axis, or a translation along it, by a function of q.
struct GuidedPart {
  enum class Kind { rotation, translation };
  Kind kind = Kind::rotation;
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< in the frame that the parts before it have moved
  TimeFunction by = linear(0, 1);                   ///< of q (rad): rad or m, twice differentiable
};

/// Names in files, in the order of GuidedPart::Kind.
inline constexpr std::string_view guided_part_names[] = {"rotation", "translation"};

/// f(q) and its derivatives; for lane types each lane by itself, since a table has its own piece in each.
template <class T>
TimeValueOf<T> guided_value(const TimeFunction& f, const T& q) {
  if constexpr (is_lanes<T>) {
    TimeValueOf<T> out;
    for (int lane = 0; lane < T::count; ++lane) {
      const TimeValue one = at(f, double(q[lane]));
      out.value.set(lane, one.value);
      out.rate.set(lane, one.rate);
      out.acceleration.set(lane, one.acceleration);
    }
    return out;
  } else {
    return at(f, q);
  }
}

/// X_AB = X_1(f_1(q)) X_2(f_2(q)) ..., the parts in their order. q in rad; v = dq/dt. With three translations
/// and then three rotations this is OpenSim's CustomJoint of one coordinate (Seth, Sherman, Eastman, Delp,
/// Minimal formulation of joint motion for biomechanisms, Nonlinear Dynamics 62, 2010). The unit twist varies
/// with q in both frames. Where it vanishes, the coordinate moves nothing.
struct Guided {
  static constexpr std::string_view kind = "guided";
  static constexpr int nq = 1, nv = 1;
  static constexpr bool rotates = true;  ///< q is an angle
  static constexpr bool slides = true;
  std::vector<GuidedPart> parts;

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("parts", self.parts);
  }

  void scale_lengths(double s) {
    for (GuidedPart& part : parts)
      if (part.kind == GuidedPart::Kind::translation) part.by = scaled(part.by, s);
  }

  std::string complaint() const {
    if (parts.empty()) return "has no parts; give it a rotation or a translation";
    for (const GuidedPart& part : parts)
      if (const std::string bad = complaint_of(part.by); !bad.empty()) return bad;
    return "";
  }

  /// Moves the frame X from X_WA to X_WB. Gives the unit twist of the coordinate in W, at the origin of B.
  template <class T>
  void advance(const T* q, PoseOf<T>& X, Eigen::Vector3<T>* angular, Eigen::Vector3<T>* linear) const {
    const T unit(1);
    Eigen::Vector3<T> angular_rate, linear_rate;
    advance(q, &unit, X, angular, linear, angular_rate, linear_rate);
  }

  /// Also gives the rate of the twist at constant v, as seen from B, in W (Bending).
  ///
  /// The frames between the parts move like a chain at dq/dt = 1: angular velocity w, velocity v of the
  /// origin, and their rates as seen from A. A vector's rate seen from B is that seen from A, less w x it.
  template <class T>
  void advance(const T* q, const T* u, PoseOf<T>& X, Eigen::Vector3<T>* angular, Eigen::Vector3<T>* linear,
               Eigen::Vector3<T>& angular_rate, Eigen::Vector3<T>& linear_rate) const {
    Eigen::Vector3<T> w = Eigen::Vector3<T>::Zero(), v = w, w_rate = w, v_rate = w;
    for (const GuidedPart& part : parts) {
      const TimeValueOf<T> f = guided_value(part.by, q[0]);
      const Eigen::Vector3<T> axis = X.R * part.axis, along = f.rate * axis;
      if (part.kind == GuidedPart::Kind::rotation) {
        w_rate += w.cross(along) + f.acceleration * axis;
        w += along;
        X.R = X.R * rotation_about(part.axis, f.value);
      } else {
        const Eigen::Vector3<T> arm = f.value * axis, carried = w.cross(arm);
        v_rate += w_rate.cross(arm) + w.cross(carried) + 2 * w.cross(along) + f.acceleration * axis;
        v += carried + along;
        X.p += arm;
      }
    }
    angular[0] = w;
    linear[0] = v;
    const T square = u[0] * u[0];
    angular_rate = square * w_rate;
    linear_rate = square * (v_rate - w.cross(v));
  }
};

}  // namespace borelli
