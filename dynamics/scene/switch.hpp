// A switch (the paper's elementary reference frame switching): one fixed or one-parameter motion of a frame.
// A joint is a sequence of switches.
//
// A new kind of switch is one new file beside switch_rotation.hpp, and its name in the list below. It gives
// its name in files (`kind`), the number of its positions and velocities (`nq`, `nv`), whether a position is
// an angle, whether its twists turn or slide, its fields, and `advance`, which moves a frame on and says what
// unit velocity does to it. (One whose three unit twists are the turns about its own axes may say that it
// `turns_freely`: then its accelerations cost less.)
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "dynamics/numbers/rotation_vector.hpp"
#include "dynamics/numbers/time_function.hpp"
#include "dynamics/scene/switch_ball.hpp"
#include "dynamics/scene/switch_fixed.hpp"
#include "dynamics/scene/switch_rotation.hpp"
#include "dynamics/scene/switch_screw.hpp"
#include "dynamics/scene/switch_translation.hpp"

namespace borelli {

using SwitchKind = std::variant<Fixed, Translation, Rotation, Screw, Ball>;

/// The coordinate is an unknown of the motion.
struct Free {};

/// The coordinate is given as a function of time (the paper's coordinate 0): one function for a translation
/// (m) or a rotation (rad); three for a ball, the components (rad) of the rotation vector that turns the
/// initial orientation, in its own axes.
struct Driven {
  std::vector<TimeFunction> functions;
};

/// The coordinate stays at its initial value; compile() folds it away.
struct Locked {};

/// The scalar coordinate is a function of another scalar one of the scene (a gear with an offset, the slides
/// of a knee with its flexion): a free coordinate, and the `coordinate_function` that compile() adds to hold
/// it.
struct Coupled {
  std::string to;         ///< the other coordinate's name
  TimeFunction function;  ///< of it: m or rad
};

using Motion = std::variant<Free, Driven, Locked, Coupled>;

/// Where a component of a free coordinate is allowed to be, m or rad. A start outside is refused; a motion
/// that leaves it is noted in the certificate (ranges are not enforced).
struct Range {
  double lower = 0, upper = 0;

  /// With room for the rounding of a start on a bound (a ball's goes through its quaternion): 1e-9 m or rad.
  bool holds(double x) const { return x >= lower - 1e-9 && x <= upper + 1e-9; }
};

struct Switch {
  SwitchKind kind = Fixed{};
  std::string coordinate;  ///< its coordinate's name, unique in the scene; if empty, named after its solid
  Motion motion = Free{};
  std::vector<double> q;  ///< initial position (nq numbers); empty: zero, or the identity quaternion
  std::vector<double> v;  ///< initial velocity (nv numbers); empty: zero. Free coordinates only
  /// None, or nv of them: a scalar coordinate's one, or a ball's three, of the components of its rotation
  /// vector in its own axes (logarithm of its quaternion, at most pi long: where a ball passes half a turn,
  /// its rotation vector jumps to the other side).
  std::vector<Range> ranges;
  /// Inertia of what turns (or slides) with the coordinate and is no solid, such as a motor's rotor: kg m^2,
  /// or kg; of a ball about each axis. See armature.hpp.
  double armature = 0;
};

/// What the i-th range of a coordinate with `nq` positions q speaks of: q itself, or a component of a ball's
/// rotation vector.
inline double ranged_value(const double* q, int nq, int i) {
  return nq == 4 ? logarithm(Quaternion(q[0], q[1], q[2], q[3]))[i] : q[i];
}

}  // namespace borelli
