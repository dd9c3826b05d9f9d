// The fastest change in time that a scene's drives, efforts and constraints prescribe. A method that steps
// over whole waves of it sees other values than the scene gives (aliasing) and cannot notice.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dynamics/system/system.hpp"

namespace borelli {

struct FastestChange {
  std::string name;   ///< what it moves, e.g. "effort 'push'"
  std::string wave;   ///< what its period is one of: "period", or "shortest wave (a polynomial of degree 6)"
  double period = 0;  ///< s
};

/// The shortest period among the functions of time over a run of `span` seconds: a Sine's own (of any
/// amplitude); of a Polynomial of degree d, 2 span / d, for it has d zeros at most, and what it does between
/// closer ones is small beside what it does elsewhere in the run; of a Table four times its shortest
/// interval, the width of what one value sticking out makes of the spline. None: nothing changes. What a
/// user's own C++ (FunctionConstraint, OwnEffort) does in time is not known. Without `tables` these are left
/// out: steps that end where their pieces meet (knots.hpp) see each of them, and a piece has no waves.
std::optional<FastestChange> fastest_change(const System& system, const Parameters& parameters, double span,
                                            bool tables);

/// Of each independent group: whether its work is to be as good as its motion, which alone says too little of
/// it: drives or constraints move it in time, or a user's own constraint may; or it has a limit spring with
/// losses, which do not end smoothly where a slack one is left.
std::vector<char> groups_of_counted_work(const System& system, const Parameters& parameters);

/// The longest step that follows it, in parts of its period. With eight steps to a period classical
/// Runge-Kutta samples it sixteen times, and step doubling thirty-two times: w h is below 0.8 (0.4 for the
/// half steps), where the methods' series in w h converge fast and the difference of whole and half steps is
/// an estimate of the error; one step per period would show both the same value. A run sees a polynomial of
/// degree d at more than 4 d times: it cannot vanish at all of them.
inline constexpr double longest_step_in_periods = 1.0 / 8;

}  // namespace borelli
