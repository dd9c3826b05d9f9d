// A switch (the paper's elementary reference frame switching): one elementary motion or fixed displacement of
// a frame. A joint is a sequence of switches.
//
// To add a kind, write a file like switch_rotation.hpp and list its name below. The kind gives its name in
// files (`kind`), the numbers of its positions and velocities (`nq`, `nv`), its fields, and `advance`, which
// moves a frame and gives the unit twists. `rotates` and `slides` say whether its unit twists have an angular
// and a linear part. A kind whose unit twists change with q in both its frames also gives their rate
// (Bending). A kind with lengths has `scale_lengths`. (A kind whose three unit twists are rotations about its
// own axes may declare `turns_freely`: its accelerations are then cheaper.)
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "dynamics/numbers/rotation_vector.hpp"
#include "dynamics/numbers/time_function.hpp"
#include "dynamics/scene/switch_ball.hpp"
#include "dynamics/scene/switch_ellipsoid.hpp"
#include "dynamics/scene/switch_fixed.hpp"
#include "dynamics/scene/switch_guided.hpp"
#include "dynamics/scene/switch_rotation.hpp"
#include "dynamics/scene/switch_screw.hpp"
#include "dynamics/scene/switch_translation.hpp"

namespace borelli {

using SwitchKind = std::variant<Fixed, Translation, Rotation, Screw, Ball, Guided, OnEllipsoid>;

/// Kinds whose unit twists S_i vary with the position in both frames: their second `advance` also gets
/// velocities v and gives the rate of the twist sum S_i v_i at constant v, as seen from the frame B behind the
/// switch (angular and linear part, in W). (The twists of all other kinds are constant in B, or like a
/// translation's without rotation.)
template <class Kind>
concept Bending = requires(const Kind& kind, double* q, Pose& X, Eigen::Vector3d* twists,
                           Eigen::Vector3d& rate) {
  kind.advance(q, q, X, twists, twists, rate, rate);
};

/// Moves the frame X through a switch at position q (nq numbers).
inline void move_through(const SwitchKind& kind, const double* q, Pose& X) {
  std::visit(
      [&]<class Kind>(const Kind& k) {
        Eigen::Vector3d angular[Kind::nv + 1], linear[Kind::nv + 1];
        k.advance(q, X, angular, linear);
      },
      kind);
}

/// The coordinate is an unknown of the equations of motion.
struct Free {};

/// The coordinate is a given function of time (the paper's coordinate 0). A translation (m) or a rotation
/// (rad) has one function. A ball has three: the components (rad) of the rotation vector from its initial
/// orientation, in its own axes.
struct Driven {
  std::vector<TimeFunction> functions;
};

/// The coordinate stays at its initial value; compile() merges it into the placements.
struct Locked {};

/// The scalar coordinate is a function of another scalar coordinate of the scene (offset gear, translations
/// of a knee with its flexion). compile() makes it free and adds a `coordinate_function` that enforces it.
struct Coupled {
  std::string to;         ///< the other coordinate's name
  TimeFunction function;  ///< of the other coordinate, m or rad
};

using Motion = std::variant<Free, Driven, Locked, Coupled>;

/// The allowed range of a component of a free coordinate, m or rad. A start outside is an error. A motion
/// that leaves it is noted in the certificate (ranges are not enforced).
struct Range {
  double lower = 0, upper = 0;

  /// Allows 1e-9 m or rad for the rounding of a start on a bound (that of a ball passes through its
  /// quaternion).
  bool holds(double x) const { return x >= lower - 1e-9 && x <= upper + 1e-9; }
};

struct Switch {
  SwitchKind kind = Fixed{};
  std::string coordinate;  ///< its coordinate's name, unique in the scene; if empty, named after its solid
  Motion motion = Free{};
  std::vector<double> q;  ///< initial position (nq numbers); empty: zero, or the identity quaternion
  std::vector<double> v;  ///< initial velocity (nv numbers); empty: zero. Free coordinates only
  /// Empty, or nv of them: one for a scalar coordinate, three for the components of the rotation vector of a
  /// ball, in its own axes. The rotation vector is the logarithm of the quaternion, of length at most pi.
  /// Where a ball passes half a turn, it jumps to the opposite side.
  std::vector<Range> ranges;
  /// Inertia of parts that move with the coordinate but belong to no solid, such as a motor's rotor: kg m^2,
  /// or kg for a translation; for a ball about each axis. See armature.hpp.
  double armature = 0;
};

/// The value that the i-th range limits, of a coordinate with `nq` positions q: q itself, or a component of
/// the rotation vector of a ball.
inline double ranged_value(const double* q, int nq, int i) {
  return nq == 4 ? logarithm(Quaternion(q[0], q[1], q[2], q[3]))[i] : q[i];
}

}  // namespace borelli
